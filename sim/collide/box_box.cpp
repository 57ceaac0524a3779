#include "sim/collide/box_box.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace sim {
namespace {

/// A pair of edges wins over a face only by more than this share [-] of the boxes' size: nearly parallel
/// faces keep their face manifold from step to step.
constexpr double edge_preference = 1e-7;

/// Crossing edges whose normal is this near [-] (cosine) to a face's: the faces are about to meet, and within
/// one step the contact may pass from the edges to the faces' corners. Both are given then, with the face's
/// normal.
constexpr double nearly_parallel = 0.998;

/// Ids of the contacts of two faces begin at 64 times the number of the pair of faces, one of 72; those of edges come after.
constexpr std::uint64_t ids_of_faces = 64;
constexpr std::uint64_t first_edge_id = 72 * ids_of_faces;

/// Differences of separations that tell nothing [m].
double slack_of(const PlacedBoxRow& a, const PlacedBoxRow& b) {
    return edge_preference * std::max(half_of(a).maxCoeff(), half_of(b).maxCoeff());
}

/// Is it a face of a, rather than of b, that the contacts lie on?
bool reference_is_a(const BoxAxes& axes, double slack) {
    return axes.face_a().separation + slack >= axes.face_b().separation;
}

/// A direction of the box in its body's frame; they are turned alike but for parts of compounds.
Vec3 turned_in_body(const PlacedBox& box, const Vec3& direction) {
    return box.body_from_box.orientation.w() == 1.0 ? direction : Vec3(box.body_from_box.orientation * direction);
}
/// The same of a point.
Vec3 in_body(const PlacedBox& box, const Vec3& x) {
    return box.body_from_box.position + turned_in_body(box, x);
}

/// Its rotation is that of the box, which is there already, but for parts of compounds.
PlacedBody body_of(const PlacedBox& box) {
    if (box.body_from_box.orientation.w() != 1.0) {
        return PlacedBody(box.world_from_body);
    }
    PlacedBody body;
    body.position = box.world_from_body.position;
    body.rotation = axes_of(box.row);
    return body;
}

/// The one contact of two crossing edges.
FoundContact edge_contact(const PlacedBox& a, const PlacedBox& b, const AxisChoice& axis, std::uint64_t id_base) {
    const int i = axis.index / 3;
    const int j = axis.index % 3;
    const auto axes_a = axes_of(a.row);
    const auto axes_b = axes_of(b.row);
    const Vec3 n = axes_a.col(i).cross(axes_b.col(j)).normalized() * axis.side;
    // The edge of a that lies farthest against n, and the edge of b farthest along it.
    Vec3 middle_a = Vec3::Zero();
    Vec3 middle_b = Vec3::Zero();
    std::uint64_t signs = 0;
    for (int k = 0; k < 3; ++k) {
        if (k != i) {
            const bool positive = axes_a.col(k).dot(n) < 0.0;
            middle_a[k] = positive ? a.row.half[k] : -a.row.half[k];
            signs |= static_cast<std::uint64_t>(positive) << k;
        }
        if (k != j) {
            const bool positive = axes_b.col(k).dot(n) > 0.0;
            middle_b[k] = positive ? b.row.half[k] : -b.row.half[k];
            signs |= static_cast<std::uint64_t>(positive) << (3 + k);
        }
    }
    FoundContact contact;
    ContactFeature& feature = contact.feature;
    feature.kind = FeatureKind::edges;
    feature.id = id_base + first_edge_id + static_cast<std::uint64_t>(axis.index) * 64 + signs;
    feature.core_a = in_body(a, middle_a);
    feature.core_b = in_body(b, middle_b);
    feature.direction_a = turned_in_body(a, axis.side * Vec3::Unit(i));
    feature.direction_b = turned_in_body(b, Vec3::Unit(j));
    contact.at = contact_geometry(feature, body_of(a), body_of(b));
    return contact;
}

/// The contacts of two faces. choice: the axis of the reference.
void face_contacts(const PlacedBox& a, const PlacedBox& b, const AxisChoice& choice, const FaceCorners& corners,
                   const ContactList& to) {
    const bool is_a = corners.is_of_a;
    const PlacedBox& reference = is_a ? a : b;
    const PlacedBox& incident = is_a ? b : a;
    const double outward = is_a ? -choice.side : choice.side; // n is from b to a
    const Vec3 normal = axes_of(reference.row).col(choice.index) * outward;
    const Vec3 direction = turned_in_body(reference, outward * Vec3::Unit(choice.index));
    const std::uint64_t face_id = static_cast<std::uint64_t>(2 * choice.index + (outward > 0.0 ? 0 : 1)) * 6 +
                                  static_cast<std::uint64_t>(corners.incident_face) + (is_a ? 0u : 36u);
    for (const FaceCorner& corner : std::span(corners.corners, static_cast<std::size_t>(corners.count))) {
        if (corner.gap > to.margin) {
            continue;
        }
        const Eigen::Map<const Vec3> on_reference(corner.on_reference);
        FoundContact& contact = to.contacts.emplace_back();
        ContactFeature& feature = contact.feature;
        feature.id = to.id_base + ids_of_faces * face_id + corner.id;
        feature.kind = is_a ? FeatureKind::face_a : FeatureKind::face_b;
        const Vec3 core_reference = in_body(reference, on_reference);
        const Vec3 core_incident = in_body(incident, Eigen::Map<const Vec3>(corner.on_incident));
        feature.core_a = is_a ? core_reference : core_incident;
        feature.core_b = is_a ? core_incident : core_reference;
        (is_a ? feature.direction_a : feature.direction_b) = direction;
        const Vec3 on_face = centre_of(reference.row) + axes_of(reference.row) * on_reference;
        contact.at.gap = corner.gap;
        contact.at.n = is_a ? Vec3(-normal) : normal;
        contact.at.a = is_a ? on_face : Vec3(on_face + corner.gap * normal);
    }
}

/// Where a face of either box separates them alike, the normal is the one in the middle: two boxes that lean against
/// each other as mirror images push each other along the mirror's normal. The contacts are those of a face of a.
void take_middle_normal(const PlacedBox& a, const PlacedBox& b, const Vec3& sum_of_normals,
                        std::span<FoundContact> contacts) {
    const Vec3 direction = -(a.world_from_body.orientation.conjugate() * sum_of_normals.normalized());
    const PlacedBody body_a = body_of(a);
    const PlacedBody body_b = body_of(b);
    for (FoundContact& contact : contacts) {
        contact.feature.direction_a = direction;
        contact.at = contact_geometry(contact.feature, body_a, body_b);
    }
}

} // namespace

PlacedBoxRow box_row(const Box& box, const Pose& world_from_box) {
    PlacedBoxRow row;
    Eigen::Map<Mat3>(row.axes) = world_from_box.orientation.toRotationMatrix();
    Eigen::Map<Vec3>(row.centre) = world_from_box.position;
    Eigen::Map<Vec3>(row.half) = box.half_extents;
    return row;
}

BoxAxes box_box_axes(const PlacedBox& a, const PlacedBox& b) {
    const PlacedBoxRow rows[] = {a.row, b.row};
    BoxAxes axes;
    find_axes({.boxes = rows, .count = 1, .a = {0}, .b = {1}, .axes = {&axes}});
    return axes;
}

void add_to(FaceClip& clip, int a, int b, const BoxAxes& axes, FaceCorners& corners) {
    const bool is_a = reference_is_a(axes, slack_of(clip.boxes[a], clip.boxes[b]));
    const AxisChoice face = is_a ? axes.face_a() : axes.face_b();
    const int lane = clip.count++;
    clip.reference[lane] = is_a ? a : b;
    clip.incident[lane] = is_a ? b : a;
    clip.axis.x[lane] = face.index;
    clip.outward.x[lane] = is_a ? -face.side : face.side;
    clip.corners[lane] = &corners;
    corners.is_of_a = is_a;
}

void box_box_contacts(const PlacedBox& a, const PlacedBox& b, const BoxAxes& axes, const ContactList& to) {
    if (axes.separation() > to.margin) {
        return;
    }
    const PlacedBoxRow rows[] = {a.row, b.row};
    FaceCorners corners;
    FaceClip clip{.boxes = rows};
    add_to(clip, 0, 1, axes, corners);
    clip_faces(clip);
    box_box_contacts(a, b, axes, corners, to);
}

void box_box_contacts(const PlacedBox& a, const PlacedBox& b, const BoxAxes& axes, const FaceCorners& corners,
                      const ContactList& to) {
    std::vector<FoundContact>& contacts = to.contacts;
    const AxisChoice face_a = axes.face_a();
    const AxisChoice face_b = axes.face_b();
    const AxisChoice edges = axes.edges();
    const double slack = slack_of(a.row, b.row);
    const AxisChoice& reference = corners.is_of_a ? face_a : face_b;
    const Vec3 normal_a = axes_of(a.row).col(face_a.index) * face_a.side;
    const Vec3 normal_b = axes_of(b.row).col(face_b.index) * face_b.side;
    const std::size_t first = contacts.size();
    if (edges.separation <= std::max(face_a.separation, face_b.separation) + slack) {
        face_contacts(a, b, reference, corners, to);
        if (std::abs(face_a.separation - face_b.separation) <= slack) {
            take_middle_normal(a, b, normal_a + normal_b, std::span(contacts).subspan(first));
        }
        return;
    }
    FoundContact crossing = edge_contact(a, b, edges, to.id_base);
    const Vec3& normal = corners.is_of_a ? normal_a : normal_b;
    if (crossing.at.n.dot(normal) >= nearly_parallel) {
        face_contacts(a, b, reference, corners, to);
        // The crossing edges keep the faces' corners apart, which lie beyond the other face's rim.
        for (FoundContact& corner : std::span(contacts).subspan(first)) {
            corner.feature.allowance = std::max(edges.separation - corner.at.gap, 0.0);
            corner.at.gap += corner.feature.allowance;
        }
        crossing.at.n = normal;
    }
    contacts.push_back(crossing);
}

} // namespace sim
