#pragma once
/// Contacts of two convex parts, or of one with a half space: the features that define the separating direction, and
/// the others that lie as low.
#include "sim/collide/convex.h"

namespace sim {

void convex_contacts(const Convex& a, const Convex& b, const ContactList& list);

/// Signed distance [m]: minus the depth where they overlap; a lower bound of it where they are well apart.
double convex_separation(const Convex& a, const Convex& b);

/// The same against the half space z <= 0 of a body's frame; the plane's body is b if plane_is_b.
void convex_plane_contacts(const Convex& convex, const Pose& plane, bool plane_is_b, const ContactList& list);
double convex_plane_separation(const Convex& convex, const Pose& plane);

} // namespace sim
