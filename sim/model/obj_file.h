#pragma once
/// Points of a Wavefront OBJ file.
#include "sim/base/math.h"

#include <string>
#include <vector>

namespace sim {

/// The vertices ("v x y z", further numbers ignored) of an OBJ text, in its order and units; other lines are passed
/// over. file: its name in messages. Throws Error (usage) for a v line without three finite numbers: file, line.
std::vector<Vec3> obj_points(const std::string& text, const std::string& file);

} // namespace sim
