#pragma once
/// The stages of a picture before and after OpenGL: what is drawn of a state, and the picture made of what
/// was drawn.
#include "render/picture/edges.h"
#include "render/picture/image.h"
#include "render/scene/draw_list.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace render {

struct RenderSettings {
    std::string camera = {};  ///< name; empty: what the scene's output says
    std::string gl = "auto";  ///< what draws, as GlContext takes it
    int shadow_size = 1024;   ///< [px] side of the shadow map
    bool soft_shadows = true; ///< edges four texels wide; else two
    bool smooth_edges = true;
    bool reads_ids = true;         ///< part numbers too, for smooth edges and body_ids()
    bool is_deep = false;          ///< colours of 16 bits too: drawn once more
    std::string shader_lines = {}; ///< placed before the text of the shaders of all surfaces and the sky
};

/// Those that a scene asks for.
RenderSettings render_settings(const sim::OutputDef& output);

/// What all pictures of one scene have in common. Does not change: threads may share one.
class PicturePlan {
public:
    /// width, height: of the pictures [px]. Throws Error (usage) for an unknown camera.
    PicturePlan(const sim::SceneDef& scene, int width, int height, const RenderSettings& settings = {});

    /// What is drawn of a state.
    DrawList list(const sim::Snapshot& snapshot) const { return list(scene_, snapshot); }
    /// The same of a scene that differs from the plan's in nothing but colours of bodies.
    DrawList list(const sim::SceneDef& colored, const sim::Snapshot& snapshot) const;
    /// The same of several states of one picture; see make_draw_lists().
    std::vector<DrawList> lists(const sim::SceneDef& colored, std::span<const sim::Snapshot> states) const;
    std::vector<DrawList> lists(std::span<const sim::Snapshot> states) const { return lists(scene_, states); }
    /// The camera at a state's time; x, y and w as in the state's list.
    glm::dmat4 clip_from_world(const sim::Snapshot& snapshot) const;
    /// The picture of what was drawn of the list.
    Image picture(const RawPicture& raw, const DrawList& list) const;
    /// The same in 16 bits, of settings that ask for it: RGB, top row first.
    std::vector<std::uint16_t> deep_picture(const RawPicture& raw, const DrawList& list) const;

    const Viewport& viewport() const { return viewport_; }
    const SceneGeometry& geometry() const { return geometry_; }
    const RenderSettings& settings() const { return settings_; }

private:
    sim::SceneDef scene_;
    sim::CameraDef camera_;
    Viewport viewport_;
    SceneGeometry geometry_;
    RenderSettings settings_;
};

/// Which body each pixel's centre shows, top row first: its index plus 1; 0: none. The ids have been read.
std::vector<std::uint32_t> body_ids(const RawPicture& raw, const DrawList& list);

/// The states that a blurred picture shows: `count` >= 1 of them, spread evenly over the time `shutter` [s]
/// around the snapshot. Bodies keep the snapshot's velocities meanwhile.
std::vector<sim::Snapshot> states_in_shutter(const sim::Snapshot& snapshot, double shutter, int count);

/// Mean of pictures: of their light, not of display values.
class PictureMean {
public:
    /// The first is a whole picture; rect: which part of it the image is. The others, all of one rect, are as the first
    /// outside it.
    void add(Image image, const PixelRect& rect);
    /// Of those added since the last call, at least one: CHECK.
    Image take();

private:
    void add_squares(const std::uint8_t* values, int row);
    std::uint8_t* mean_row(int row);

    Image mean_;                     ///< the first
    PixelRect rect_;                 ///< where the others differ from it
    std::vector<std::uint32_t> sum_; ///< of squares, in rect_, top row first
    int count_ = 0;
};

} // namespace render
