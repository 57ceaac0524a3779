#pragma once
/// What a scene file says on its cameras.
#include "sim/model/scene_def.h"
#include "sim/scene/layer.h"
#include "sim/scene/section.h"

#include <string>

namespace sim {

/// One [[camera]]. `scene`: its bodies and earlier cameras are known.
CameraDef read_camera(const TextSource& source, const TreeNode& node, const std::string& title, const SceneDef& scene,
                      const BodyFinder& find);

/// A view of all bodies that have an end, where they are at the start and wherever keys move them, for a scene without cameras.
CameraDef default_camera(const SceneDef& scene);

} // namespace sim
