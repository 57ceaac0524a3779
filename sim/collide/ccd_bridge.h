#pragma once
/// Sole user of libccd.
#include "sim/collide/convex.h"

#include <optional>

namespace sim {

/// About the direction (unit, from b to a) along which two cores are least deep in each other, or farthest apart;
/// nothing if libccd finds none. A degree may be missing: a start for the exact features.
std::optional<Vec3> penetration_direction(const Convex& a, const Convex& b);

} // namespace sim
