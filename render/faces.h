#pragma once
/// The flat faces that a camera sees of the boxes, with the share of the sky that their points see.
#include "render/draw_list.h"

#include <cstdint>
#include <span>

namespace render {

/// A placed part together with what sorts it.
struct Part {
    Instance instance;
    int mesh; ///< mesh_id of a round part, -1 of a box
    sim::Pattern pattern;
    float depth; ///< along the view [m]
    std::uint32_t body; ///< index plus 1; 0: of none, a joint's rod
};

/// Adds faces, their batches and the sky atlas to a list whose camera and occlusion are set.
/// boxes: nearest first.
void add_faces(std::span<const Part> boxes, const SceneGeometry& geometry, DrawList& list);

} // namespace render
