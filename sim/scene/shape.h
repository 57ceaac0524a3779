#pragma once
/// The shape of a body in a scene file.
#include "sim/model/shape.h"
#include "sim/scene/section.h"

#include <cstdint>

namespace sim {

/// Keys orientation, axis_angle_degrees, euler_degrees, of which one may be given.
Quat read_orientation(Section& section);

/// A table `shape = { ... }`. index: of the body in its pattern, which a rock adds to its seed; title: "body 'cube'
/// shape". Throws Error (usage), and Error (io) for an OBJ file that cannot be read.
Shape read_shape(const TextSource& source, const TreeNode& node, const std::string& title, std::int64_t index);

/// Is this table of a body one whose shape differs from body to body in a pattern?
bool is_random_shape(const TreeNode& body);

} // namespace sim
