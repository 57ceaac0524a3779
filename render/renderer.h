#pragma once
/// Draws snapshots of one scene into pictures, offscreen and in software.
#include "render/image.h"
#include "sim/scene_def.h"
#include "sim/snapshot.h"

#include <memory>
#include <string>

namespace render {

struct RenderSettings {
    std::string camera;     ///< name; empty: what the scene's output says
    int shadow_size = 2048; ///< [px] side of the shadow map
    int samples = 4;        ///< a pixel, 1 or 4
};

/// Owns one OpenGL context: to be made, used and destroyed in one thread. Several may exist side by side.
class Renderer {
public:
    /// width, height: of the pictures [px]. Throws Error: usage for an unknown camera, io if OpenGL fails.
    Renderer(const sim::SceneDef& scene, int width, int height, const RenderSettings& settings = {});
    ~Renderer();
    Renderer(Renderer&&) noexcept;
    Renderer& operator=(Renderer&&) noexcept;

    /// The picture depends on scene, settings and snapshot only. Throws Error (io) if OpenGL fails.
    Image draw(const sim::Snapshot& snapshot);

    /// Name and version of the OpenGL library.
    std::string renderer_string() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
