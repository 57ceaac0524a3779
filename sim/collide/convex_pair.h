#pragma once
/// Contacts of two convex parts, or of one with a half space: the features that define the separating direction, and
/// the others that lie as low.
#include "sim/collide/convex.h"

namespace sim {

/// near: see find_separation().
void convex_contacts(const Convex& a, const Convex& b, const ContactList& list, const Vec3* near);

/// Unit vector from b to a along which they are farthest apart, or least deep in each other; of parts that are well apart one along
/// which they are.
Vec3 separating_direction(const Convex& a, const Convex& b);

/// How far they are apart along the unit vector n [m]; negative where they overlap.
double convex_separation(const Convex& a, const Convex& b, const Vec3& n);

/// The same against the half space z <= 0 of a body's frame; the plane's body is b if plane_is_b.
void convex_plane_contacts(const Convex& convex, const Pose& plane, bool plane_is_b, const ContactList& list);
double convex_plane_separation(const Convex& convex, const Pose& plane);

} // namespace sim
