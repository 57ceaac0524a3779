#pragma once
/// The flat faces that a camera sees of the boxes, with the share of the sky that their points see.
#include "render/scene/draw_list.h"
#include "render/scene/parts.h"

#include <span>

namespace render {

/// Adds faces, their batches and the sky atlas to a list whose camera and occlusion are set.
/// boxes: nearest first.
void add_faces(std::span<const Part> boxes, const SceneGeometry& geometry, DrawList& list);

} // namespace render
