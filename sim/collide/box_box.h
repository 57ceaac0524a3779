#pragma once
/// Box against box: separating axes, then the full manifold of the axis with the largest separation.
#include "sim/collide/box_pairs.h"
#include "sim/collide/manifold.h"

namespace sim {

/// What the search takes of a box.
PlacedBoxRow box_row(const Box& box, const Pose& world_from_box);
inline Eigen::Map<const Mat3> axes_of(const PlacedBoxRow& row) {
    return Eigen::Map<const Mat3>(row.axes);
}
inline Eigen::Map<const Vec3> centre_of(const PlacedBoxRow& row) {
    return Eigen::Map<const Vec3>(row.centre);
}
inline Eigen::Map<const Vec3> half_of(const PlacedBoxRow& row) {
    return Eigen::Map<const Vec3>(row.half);
}

/// A box placed in the world, and where it sits in its body's frame.
struct PlacedBox {
    PlacedBoxRow row;
    Pose world_from_body;
    Pose body_from_box;
};

/// The axes of the largest separation among the fifteen.
BoxAxes box_box_axes(const PlacedBox& a, const PlacedBox& b);

/// Adds a pair of clip.boxes: the face whose axis separates them most, and the other box.
void add_to(FaceClip& clip, int a, int b, const BoxAxes& axes, FaceCorners& corners);

/// Appends the contacts, by ascending ids. corners: of this pair, as add_to() asks for them.
void box_box_contacts(const PlacedBox& a, const PlacedBox& b, const BoxAxes& axes, const FaceCorners& corners,
                      const ContactList& to);
/// Of a pair alone.
void box_box_contacts(const PlacedBox& a, const PlacedBox& b, const BoxAxes& axes, const ContactList& to);

} // namespace sim
