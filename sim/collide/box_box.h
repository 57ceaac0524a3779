#pragma once
/// Box against box: separating axes, then the full manifold of the axis with the largest separation.
#include "sim/collide/box_axes.h"
#include "sim/collide/manifold.h"

namespace sim {

/// A box placed in the world, and where it sits in its body's frame.
struct PlacedBox {
    Box box;
    Pose world_from_body;
    Pose body_from_box;
    Pose world_from_box;
};

/// The axes of the largest separation among the fifteen.
BoxAxes box_box_axes(const PlacedBox& a, const PlacedBox& b);

/// Appends the contacts.
void box_box_contacts(const PlacedBox& a, const PlacedBox& b, const BoxAxes& axes, const ContactList& to);

} // namespace sim
