#pragma once
/// What a scene contains, in a few lines for a person: what `tumble check` prints.
#include "sim/model/scene_def.h"

#include <string>

namespace sim {

/// Several lines, each ended: name and title, bodies by kind and shape, mass, joints, steps, frames,
/// tolerances, the parts of the model that the scene uses, cameras, overrides.
std::string describe_scene(const SceneDef& scene);

} // namespace sim
