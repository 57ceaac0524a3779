#include "sim/collide/box_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace sim {
namespace {

/// Edge directions whose cross product is shorter than this [-] count as parallel: a face axis then says the
/// same.
constexpr double parallel_edges = 1e-6;

/// A pair of edges wins over a face only by more than this share [-] of the boxes' size: nearly parallel
/// faces keep their face manifold from step to step.
constexpr double edge_preference = 1e-7;

/// Crossing edges whose normal is this near [-] (cosine) to a face's: the faces are about to meet, and within
/// one step the contact may pass from the edges to the faces' corners. Both are given then, with the face's
/// normal.
constexpr double nearly_parallel = 0.998;

/// Share [-] of a face's half width by which a corner may stick out and still count as inside the face.
constexpr double aligned = 1e-6;

/// The frames of two boxes relative to each other.
struct Frames {
    const PlacedBox& a;
    const PlacedBox& b;
    Mat3 axes_a; ///< columns: axes of a in the world
    Mat3 axes_b;
    Vec3 half_a;
    Vec3 half_b;
    Vec3 b_to_a;   ///< centre of a minus centre of b
    Mat3 rotation; ///< axes_a^T axes_b
    Mat3 absolute; ///< |rotation|

    Frames(const PlacedBox& box_a, const PlacedBox& box_b)
        : a(box_a), b(box_b), axes_a(a.world_from_box.orientation.toRotationMatrix()),
          axes_b(b.world_from_box.orientation.toRotationMatrix()), half_a(a.box.half_extents),
          half_b(b.box.half_extents), b_to_a(a.world_from_box.position - b.world_from_box.position),
          rotation(axes_a.transpose() * axes_b), absolute(rotation.cwiseAbs()) {}
};

/// No axis yet.
constexpr AxisChoice no_axis{-std::numeric_limits<double>::infinity(), -1, 1};

/// Separation along the three face axes of a (n from b to a is -axis for a face of a whose outward side is
/// +).
AxisChoice best_face(const Vec3& centre_offset, const Vec3& own_half, const Vec3& other_reach) {
    AxisChoice best = no_axis;
    for (int i = 0; i < 3; ++i) {
        const double s = std::abs(centre_offset[i]) - own_half[i] - other_reach[i];
        if (s > best.separation) {
            best = {s, i, centre_offset[i] >= 0.0 ? 1 : -1};
        }
    }
    return best;
}

/// Separation along the nine cross products of edges.
AxisChoice best_edges(const Frames& f) {
    AxisChoice best = no_axis;
    const Vec3 t = f.axes_a.transpose() * f.b_to_a; // in the frame of a
    for (int i = 0; i < 3; ++i) {
        const int i1 = (i + 1) % 3;
        const int i2 = (i + 2) % 3;
        for (int j = 0; j < 3; ++j) {
            const int j1 = (j + 1) % 3;
            const int j2 = (j + 2) % 3;
            const double sine_squared = 1.0 - f.rotation(i, j) * f.rotation(i, j);
            if (sine_squared < parallel_edges * parallel_edges) {
                continue;
            }
            // axis = e_i x R e_j, in the frame of a: components -R(i2,j) at i1 and R(i1,j) at i2.
            const double offset = t[i2] * f.rotation(i1, j) - t[i1] * f.rotation(i2, j);
            const double reach = f.half_a[i1] * f.absolute(i2, j) + f.half_a[i2] * f.absolute(i1, j) +
                                 f.half_b[j1] * f.absolute(i, j2) + f.half_b[j2] * f.absolute(i, j1);
            const double s = (std::abs(offset) - reach) / std::sqrt(sine_squared);
            if (s > best.separation) {
                best = {s, 3 * i + j, offset >= 0.0 ? 1 : -1};
            }
        }
    }
    return best;
}

AxisChoice best_face_of_a(const Frames& f) {
    return best_face(f.axes_a.transpose() * f.b_to_a, f.half_a, f.absolute * f.half_b);
}

AxisChoice best_face_of_b(const Frames& f) {
    return best_face(f.axes_b.transpose() * f.b_to_a, f.half_b, f.absolute.transpose() * f.half_a);
}

/// A corner of the incident face while it is clipped. Edges 0..3 are the incident face's, 4..7 the clipping
/// planes.
struct ClipPoint {
    Vec3 x;           ///< in the frame of the reference box [m]
    int edge_in;  ///< edge that ends here
    int edge_out; ///< edge that starts here
};

/// Up to eight points of a clipped quadrilateral, without allocation.
struct Polygon {
    std::array<ClipPoint, 12> points; // each of four cuts of a convex polygon adds one at most
    int size = 0;

    void add(const ClipPoint& p) { points[static_cast<std::size_t>(size++)] = p; }
    const ClipPoint& operator[](int i) const { return points[static_cast<std::size_t>(i)]; }
};

/// A face while it is cut by planes, from one polygon into the other.
struct CutFace {
    std::array<Polygon, 2> polygons;
    Polygon* now = &polygons[0];
    Polygon* spare = &polygons[1];

    void clip(int axis, double side, double half, int plane);
};

/// Keeps the part with side * x[axis] <= half; new corners are marked with the clipping plane. Corners that lie on the plane to within `aligned` count as inside, so that boxes
/// exactly on top of each other keep their features.
void CutFace::clip(int axis, double side, double half, int plane) {
    const double limit = half * (1.0 + aligned);
    const Polygon& in = *now;
    bool inside = true;
    for (int i = 0; i < in.size; ++i) {
        inside = inside && side * in[i].x[axis] <= limit;
    }
    if (inside) {
        return;
    }
    Polygon& out = *spare;
    out.size = 0;
    for (int i = 0; i < in.size; ++i) {
        const ClipPoint& p = in[i];
        const ClipPoint& q = in[i + 1 == in.size ? 0 : i + 1];
        const double dp = side * p.x[axis] - limit;
        const double dq = side * q.x[axis] - limit;
        if (dp <= 0.0) {
            out.add(p);
        }
        if ((dp < 0.0 && dq > 0.0) || (dp > 0.0 && dq < 0.0)) {
            out.add({p.x + (q.x - p.x) * (dp / (dp - dq)), dp < 0.0 ? p.edge_out : plane,
                     dp < 0.0 ? plane : p.edge_out});
        }
    }
    std::swap(now, spare);
}

/// The face of the incident box that is most opposed to the reference face, in the frame of the reference box.
/// rotation, offset: of the incident box there; n: the reference face's normal in the frame of the incident box.
Polygon incident_face(const Vec3& half, const Mat3& rotation, const Vec3& offset, const Vec3& n,
                      int& face_index) {
    int axis = 0;
    n.cwiseAbs().maxCoeff(&axis);
    const double side = n[axis] > 0.0 ? -1.0 : 1.0;
    face_index = 2 * axis + (side > 0.0 ? 0 : 1);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Vec3 centre = offset + rotation.col(axis) * (side * half[axis]);
    const Vec3 edge_u = rotation.col(u) * half[u];
    const Vec3 edge_v = rotation.col(v) * half[v];
    Polygon face;
    face.add({centre + edge_u + edge_v, 3, 0});
    face.add({centre - edge_u + edge_v, 0, 1});
    face.add({centre - edge_u - edge_v, 1, 2});
    face.add({centre + edge_u - edge_v, 2, 3});
    return face;
}

/// A point of the box in its body's frame; they are one but for parts of compounds.
Vec3 in_body(const PlacedBox& box, const Vec3& x) {
    return box.body_from_box.orientation.w() == 1.0 ? Vec3(box.body_from_box.position + x) : box.body_from_box * x;
}

/// One face against the other box.
struct ReferenceFace {
    const PlacedBox& reference;
    const PlacedBox& incident;
    const Mat3& axes;  ///< of the reference box
    bool is_a;         ///< whose face it is
    Mat3 rotation;     ///< reference_from_incident
    Vec3 offset;       ///< of the incident box in the frame of the reference box [m]
    int axis;
    double outward;    ///< sign of its normal, towards the incident box
    Vec3 normal;       ///< world
    Vec3 direction;    ///< the same in the frame of the body

    ReferenceFace(const Frames& f, bool of_a, const AxisChoice& choice)
        : reference(of_a ? f.a : f.b), incident(of_a ? f.b : f.a), axes(of_a ? f.axes_a : f.axes_b), is_a(of_a),
          rotation(of_a ? f.rotation : Mat3(f.rotation.transpose())),
          offset(axes.transpose() * (incident.world_from_box.position - reference.world_from_box.position)),
          axis(choice.index), outward(of_a ? -choice.side : choice.side), normal(axes.col(axis) * outward),
          direction(reference.body_from_box.orientation * Vec3(outward * Vec3::Unit(axis))) {}

    void add_contact(const ClipPoint& p, std::uint64_t face_id, const ContactList& to) const;
    void add_contacts(const ContactList& to) const;
};

/// The contact of a corner of the incident face, if it is near enough.
void ReferenceFace::add_contact(const ClipPoint& p, std::uint64_t face_id, const ContactList& to) const {
    const double half = reference.box.half_extents[axis];
    const double gap = outward * p.x[axis] - half;
    if (gap > to.margin) {
        return;
    }
    Vec3 on_face = p.x;
    on_face[axis] = outward * half;
    const Vec3 on_incident = rotation.transpose() * (p.x - offset);
    Contact& contact = to.contacts.emplace_back();
    ContactFeature& feature = contact.feature;
    feature.id = to.id_base + face_id * 64 + static_cast<std::uint64_t>(p.edge_in * 8 + p.edge_out);
    feature.kind = is_a ? FeatureKind::face_a : FeatureKind::face_b;
    const Vec3 core_reference = in_body(reference, on_face);
    const Vec3 core_incident = in_body(incident, on_incident);
    feature.core_a = is_a ? core_reference : core_incident;
    feature.core_b = is_a ? core_incident : core_reference;
    (is_a ? feature.direction_a : feature.direction_b) = direction;
    const Vec3 world_face = reference.world_from_box.position + axes * on_face;
    contact.at.gap = gap;
    contact.at.n = is_a ? Vec3(-normal) : normal;
    contact.at.a = is_a ? world_face : Vec3(world_face + gap * normal);
}

/// Its manifold, in the order of the ids.
void ReferenceFace::add_contacts(const ContactList& to) const {
    int incident_index = 0;
    CutFace face;
    *face.now = incident_face(incident.box.half_extents, rotation, offset, outward * rotation.row(axis).transpose(),
                              incident_index);
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    const Vec3& half = reference.box.half_extents;
    face.clip(u, 1.0, half[u], 4);
    face.clip(u, -1.0, half[u], 5);
    face.clip(v, 1.0, half[v], 6);
    face.clip(v, -1.0, half[v], 7);
    Polygon& corners = *face.now;
    std::sort(corners.points.begin(), corners.points.begin() + corners.size, [](const ClipPoint& p, const ClipPoint& q) {
        return p.edge_in * 8 + p.edge_out < q.edge_in * 8 + q.edge_out;
    });
    const std::uint64_t face_id = static_cast<std::uint64_t>(2 * axis + (outward > 0.0 ? 0 : 1)) * 6 +
                                  static_cast<std::uint64_t>(incident_index) + (is_a ? 0u : 36u);
    for (int i = 0; i < corners.size; ++i) {
        add_contact(corners[i], face_id, to);
    }
}

/// The one contact of two crossing edges.
void edge_contact(const Frames& f, const AxisChoice& axis, const ContactList& to) {
    const int i = axis.index / 3;
    const int j = axis.index % 3;
    Vec3 n = f.axes_a.col(i).cross(f.axes_b.col(j)).normalized() * axis.side;
    // The edge of a that lies farthest against n, and the edge of b farthest along it.
    Vec3 middle_a = Vec3::Zero();
    Vec3 middle_b = Vec3::Zero();
    std::uint64_t signs = 0;
    for (int k = 0; k < 3; ++k) {
        if (k != i) {
            const bool positive = f.axes_a.col(k).dot(n) < 0.0;
            middle_a[k] = positive ? f.half_a[k] : -f.half_a[k];
            signs |= static_cast<std::uint64_t>(positive) << k;
        }
        if (k != j) {
            const bool positive = f.axes_b.col(k).dot(n) > 0.0;
            middle_b[k] = positive ? f.half_b[k] : -f.half_b[k];
            signs |= static_cast<std::uint64_t>(positive) << (3 + k);
        }
    }
    Contact contact;
    ContactFeature& feature = contact.feature;
    feature.kind = FeatureKind::edges;
    feature.id = to.id_base + 72 * 64 + static_cast<std::uint64_t>(axis.index) * 64 + signs;
    feature.core_a = f.a.body_from_box * middle_a;
    feature.core_b = f.b.body_from_box * middle_b;
    feature.direction_a = f.a.body_from_box.orientation * Vec3(axis.side * Vec3::Unit(i));
    feature.direction_b = f.b.body_from_box.orientation * Vec3::Unit(j);
    contact.at = contact_geometry(feature, f.a.world_from_body, f.b.world_from_body);
    to.contacts.push_back(contact);
}

/// Where a face of either box separates them alike, the normal is the one in the middle: two boxes that lean against
/// each other as mirror images push each other along the mirror's normal. The contacts are those of a face of a.
void take_middle_normal(const PlacedBox& a, const PlacedBox& b, const Vec3& sum_of_normals,
                        std::span<Contact> contacts) {
    const Vec3 direction = -(a.world_from_body.orientation.conjugate() * sum_of_normals.normalized());
    for (Contact& contact : contacts) {
        contact.feature.direction_a = direction;
        contact.at = contact_geometry(contact.feature, a.world_from_body, b.world_from_body);
    }
}

} // namespace

BoxAxes box_box_axes(const PlacedBox& a, const PlacedBox& b) {
    const Frames f(a, b);
    return {best_face_of_a(f), best_face_of_b(f), best_edges(f)};
}

void box_box_contacts(const PlacedBox& a, const PlacedBox& b, const BoxAxes& axes, const ContactList& to) {
    std::vector<Contact>& contacts = to.contacts;
    const auto& [face_a, face_b, edges] = axes;
    if (axes.separation() > to.margin) {
        return;
    }
    const Frames f(a, b);
    const double slack = edge_preference * std::max(f.half_a.maxCoeff(), f.half_b.maxCoeff());
    const bool reference_is_a = face_a.separation + slack >= face_b.separation;
    const bool edges_touch = edges.separation > std::max(face_a.separation, face_b.separation) + slack;
    const std::size_t first = contacts.size();
    if (edges_touch) {
        edge_contact(f, edges, to);
        const Vec3 face_normal = reference_is_a ? Vec3(f.axes_a.col(face_a.index) * face_a.side)
                                                : Vec3(f.axes_b.col(face_b.index) * face_b.side);
        if (contacts.back().at.n.dot(face_normal) < nearly_parallel) {
            return;
        }
        ContactGeometry& at = contacts.back().at;
        at.n = face_normal;
    }
    ReferenceFace(f, reference_is_a, reference_is_a ? face_a : face_b).add_contacts(to);
    if (!edges_touch && std::abs(face_a.separation - face_b.separation) <= slack) {
        const Vec3 sum = f.axes_a.col(face_a.index) * face_a.side + f.axes_b.col(face_b.index) * face_b.side;
        take_middle_normal(a, b, sum, std::span(contacts).subspan(first));
    }
    if (edges_touch) {
        // The crossing edges keep the faces' corners apart, which lie beyond the other face's rim.
        for (std::size_t i = first + 1; i < contacts.size(); ++i) {
            Contact& corner = contacts[i];
            corner.feature.allowance = std::max(edges.separation - corner.at.gap, 0.0);
            corner.at.gap += corner.feature.allowance;
        }
    }
}

} // namespace sim
