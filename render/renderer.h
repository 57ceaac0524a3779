#pragma once
/// Draws snapshots of one scene into pictures, offscreen and in software.
#include "render/depth_picture.h"
#include "render/image.h"
#include "sim/scene_def.h"
#include "sim/snapshot.h"

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace render {

struct RenderSettings {
    std::string camera = {};     ///< name; empty: what the scene's output says
    int shadow_size = 1024;      ///< [px] side of the shadow map
    std::string shader_lines = {}; ///< placed before the text of the shaders of all surfaces and the sky
    bool measures_times = false; ///< waits for OpenGL after each pass, so that times() tells them apart
};

/// Where the time of one picture went [ms]: processor time of the thread that draws. With LP_NUM_THREADS=0
/// that is all there is; otherwise OpenGL draws in threads of its own.
struct RenderTimes {
    double list = 0.0;    ///< from the snapshot to what is drawn; occlusion
    double shadow = 0.0;  ///< shadow map
    double picture = 0.0; ///< bodies, floors, sky
    double edges = 0.0;   ///< reading back, smooth edges
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

    /// The mean of `count` >= 1 pictures over the time `shutter` [s] around the snapshot: what moves is
    /// blurred. Bodies keep the snapshot's velocities meanwhile. Light is averaged, not display values.
    Image draw_blurred(const sim::Snapshot& snapshot, double shutter, int count);

    /// Colours [body_count], linear RGB, of the pictures from now on, instead of the scene's.
    void set_colors(std::span<const sim::Vec3> colors);

    /// Of the last picture. Throws Error (io) if OpenGL fails.
    DepthPicture depth() const;

    /// Which body each pixel's centre of the last picture shows, top row first: its index plus 1; 0: none. Of a
    /// blurred picture: the last sub-frame's.
    std::vector<std::uint32_t> body_ids() const;

    /// Of the last picture; the passes are told apart only with measures_times.
    const RenderTimes& times() const;

    /// Name and version of the OpenGL library.
    std::string renderer_string() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
