#pragma once
/// Draws snapshots of one scene into pictures, offscreen and in software.
#include "render/picture/depth_picture.h"
#include "render/picture/plan.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace render {

/// Owns one OpenGL context: to be made, used and destroyed in one thread. Several may exist side by side.
class Renderer {
public:
    /// Throws Error (io) if OpenGL fails.
    explicit Renderer(std::shared_ptr<const PicturePlan> plan);
    /// With a plan of its own. Throws Error: usage for an unknown camera, io if OpenGL fails.
    Renderer(const sim::SceneDef& scene, int width, int height, const RenderSettings& settings = {});
    ~Renderer();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;

    /// The middle stage: draws a list of the plan into `raw`. Throws Error (io) if OpenGL fails.
    void draw(const DrawList& list, RawPicture& raw);

    /// All stages. The picture depends on scene, settings and snapshot only. Throws Error (io) if OpenGL
    /// fails.
    Image draw(const sim::Snapshot& snapshot);

    /// The mean of `count` >= 1 pictures over the time `shutter` [s] around the snapshot: what moves is
    /// blurred.
    Image draw_blurred(const sim::Snapshot& snapshot, double shutter, int count);

    /// Of the last picture. Throws Error (io) if OpenGL fails.
    DepthPicture depth() const;

    /// Which body each pixel's centre of the last picture shows: body_ids() of picture_plan.h.
    std::vector<std::uint32_t> body_ids() const;

    /// Name and version of the OpenGL library.
    std::string renderer_string() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
