#pragma once
/// Box against box: separating axes, then the full manifold of the axis with the largest separation.
#include "sim/manifold.h"

namespace sim {

/// A box placed in the world, and where it sits in its body's frame.
struct PlacedBox {
    Box box;
    Pose world_from_body;
    Pose body_from_box;
    Pose world_from_box;
};

/// Contacts with gap <= margin [m], appended; `id_base` is added to their ids (bits 32 and up).
void box_box_contacts(const PlacedBox& a, const PlacedBox& b, double margin, std::uint64_t id_base,
                      std::vector<Contact>& contacts);

/// Largest separation over the fifteen axes [m].
double box_box_separation(const PlacedBox& a, const PlacedBox& b);

} // namespace sim
