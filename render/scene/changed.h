#pragma once
/// Where pictures of several states differ, so that only that is drawn anew.
#include "render/scene/draw_list.h"
#include "render/scene/parts.h"

#include <span>
#include <vector>

namespace render {

/// What is known of states that the same camera sees under the same light.
struct StatesSeen {
    const SceneGeometry& geometry;
    std::span<const Parts> parts;    ///< of each state
    std::span<const DrawList> lists; ///< of each state; camera, shadow volume and occluded volume are the same
    std::vector<bool> moves;         ///< [body + 1], [0]: rods of joints
};

struct Changed {
    PixelRect picture; ///< all pixels that one of the states shows otherwise than the first
    PixelRect shadows; ///< the same of the shadow map
};

/// What moves, its shadow, and bodies that mirror it or are so near that it takes sky from them; what it takes from a
/// floor farther away changes too little to be seen. The whole picture where that cannot be told.
Changed find_changed(const StatesSeen& seen, const Viewport& viewport);

} // namespace render
