#pragma once
/// The separating direction of two features of which at least one is a rim.
#include "sim/collide/convex.h"

namespace sim {

/// The unit vector from b to a along which they are farthest apart, by Newton's method from `near` on; across the edge, if
/// one of them is an edge. Zero: there is none.
Vec3 rim_direction(const CoreFeature& fa, const CoreFeature& fb, const Vec3& near);

} // namespace sim
