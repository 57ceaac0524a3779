#pragma once
/// Contacts of two convex parts at features that are no faces: corners, edges and rims, and lines along which they touch.
#include "sim/collide/separating_direction.h"

namespace sim {

/// The contacts of the features that define the separating direction: the ends of lines that are nearly parallel, and where none
/// of these is the lowest the features themselves. gap [m]: of the bodies.
void feature_contacts(const Convex& a, const Convex& b, const SeparatingDirection& best, double gap, const ContactList& list);

/// Id of a contact within its pair of parts: its group above, which orders the contacts, its features below.
std::uint64_t contact_id(std::uint64_t group, std::uint64_t first, std::uint64_t second, std::uint64_t third);

/// Adds a contact with gap <= margin; a gap below `least` [m] is raised to it (see allowance).
void add_raised(FoundContact contact, double least, const ContactList& list);

inline Vec3 in_frame(const Pose& pose, const Vec3& x) {
    return pose.orientation.conjugate() * (x - pose.position);
}

} // namespace sim
