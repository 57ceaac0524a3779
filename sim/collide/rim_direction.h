#pragma once
/// The separating direction of two features of which at least one is a rim.
#include "sim/collide/convex.h"

namespace sim {

/// The unit vector from b to a along which they are farthest apart, by Newton's method from `near` on; across the edge, if
/// one of them is an edge. Zero: there is none.
Vec3 rim_direction(const CoreFeature& fa, const CoreFeature& fb, const Vec3& near);

/// May the direction of a rim and an edge of a polytope lie between `left` and `right`, the outward normals of the faces which the
/// edge joins, where they are no less than `least` [m] apart along it? Not where bounds tell without a search that none does.
bool may_be_between(const CoreFeature& rim, const CoreFeature& edge, Vec3 left, Vec3 right, double least);

/// The difference of a rim's disc and an edge is a slanting cylinder, along the edge, over the ellipse as which the disc is seen
/// from there: does it hold a ball of that radius [m] which touches it where n is normal to it? n: unit, into the rim's body.
bool is_within_disc(const CoreFeature& rim, const CoreFeature& edge, const Vec3& n, double radius);

} // namespace sim
