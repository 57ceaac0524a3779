#pragma once
/// Points of a Wavefront OBJ file, as a whole or by its groups.
#include "sim/base/math.h"

#include <string>
#include <vector>

namespace sim {

/// The vertices ("v x y z", further numbers ignored) of an OBJ text, in its order and units; other lines are passed
/// over. file: its name in messages. Throws Error (usage) for a v line without three finite numbers: file, line.
std::vector<Vec3> obj_points(const std::string& text, const std::string& file);

/// The vertices that the faces ("f") of each group use, a group beginning with a line "g" or "o"; groups without faces are
/// passed over. Throws Error (usage) as obj_points, and for a face with a vertex that does not exist.
std::vector<std::vector<Vec3>> obj_groups(const std::string& text, const std::string& file);

} // namespace sim
