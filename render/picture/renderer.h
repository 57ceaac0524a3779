#pragma once
/// Draws snapshots of one scene into pictures, offscreen.
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

    /// The middle stage, in two parts, so that a graphics card draws while the processor takes the picture before.
    /// Begins a picture of a list of the plan; of lists made together, in their order. has_depth: its depths will be
    /// read too. `capacity()` at most are begun and not finished: CHECK. Throws Error (io) if OpenGL fails.
    void begin(const DrawList& list, bool has_depth);
    /// The first picture that is begun and not finished; depth is filled if it was asked for. Throws Error (io) if
    /// OpenGL fails.
    void finish(RawPicture& raw, DepthPicture& depth);
    /// In software 1, else more.
    int capacity() const;

    /// All stages. The picture depends on scene, settings and snapshot only. Throws Error (io) if OpenGL
    /// fails.
    Image draw(const sim::Snapshot& snapshot);

    /// The mean of `count` >= 1 pictures over the time `shutter` [s] around the snapshot: what moves is
    /// blurred.
    Image draw_blurred(const sim::Snapshot& snapshot, double shutter, int count);

    /// Of the last picture of a snapshot.
    const DepthPicture& depth() const;

    /// Which body each pixel's centre of the last picture of a snapshot shows, unless it was blurred: body_ids() of
    /// plan.h.
    std::vector<std::uint32_t> body_ids() const;

    /// Name and version of the OpenGL library.
    std::string renderer_string() const;

private:
    Image draw_list(DrawList list);

    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
