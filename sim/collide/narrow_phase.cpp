#include "sim/collide/narrow_phase.h"

#include "sim/base/error.h"
#include "sim/collide/box_box.h"
#include "sim/collide/convex_pair.h"
#include "sim/model/polytope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sim {
namespace {

/// Ids of contacts between part i of a and part j of b start at (i * parts + j) << 32: that leaves 2^24 pairs of parts.
constexpr int part_id_shift = 32;

/// A ball in the world and where its centre sits in its body's frame.
struct PlacedBall {
    double radius;
    Vec3 centre;
    Vec3 centre_body;
};

/// Calls f(primitive, body_from_part) for each part of a bounded shape.
template <typename F>
void for_each_part(const Shape& shape, F&& f) {
    std::visit(
        [&](const auto& s) {
            using S = std::decay_t<decltype(s)>;
            if constexpr (std::is_same_v<S, Compound>) {
                for (const CompoundPart& part : s.parts) {
                    f(part.shape, part.body_from_part);
                }
            } else if constexpr (!std::is_same_v<S, Plane>) {
                f(PrimitiveShape(s), Pose{});
            }
        },
        shape);
}

/// Of a convex shape.
std::optional<PrimitiveShape> only_part(const Shape& shape) {
    std::optional<PrimitiveShape> part;
    if (!std::holds_alternative<Compound>(shape)) {
        for_each_part(shape, [&](const PrimitiveShape& primitive, const Pose&) { part = primitive; });
    }
    return part;
}

PlacedBall placed(const Sphere& sphere, const Pose& world_from_body, const Pose& body_from_part) {
    return {sphere.radius, world_from_body * body_from_part.position, body_from_part.position};
}

PlacedBox placed(const Box& box, const Pose& world_from_body, const Pose& body_from_part) {
    return {box_row(box, world_from_body * body_from_part), world_from_body, body_from_part};
}

/// Largest distance of a point of a part from the part's origin [m].
double reach_of(const PrimitiveShape& part) {
    struct Reach {
        double operator()(const Box& box) const { return box.half_extents.norm(); }
        double operator()(const Sphere& sphere) const { return sphere.radius; }
        double operator()(const Cylinder& cylinder) const { return std::hypot(cylinder.radius, cylinder.half_length); }
        double operator()(const Capsule& capsule) const { return capsule.half_length + capsule.radius; }
        double operator()(const Hull& hull) const { return hull.polytope->radius; }
    };
    return std::visit(Reach{}, part);
}

/// What the pair loop collects: contacts within the margin, or only the least separation.
struct Collector {
    double margin = 0.0;
    std::vector<FoundContact>* contacts = nullptr; ///< null: separation only
    std::span<const Contact> known; ///< of the pair, before
    double separation = std::numeric_limits<double>::infinity();
    Vec3 n = Vec3::Zero(); ///< along which it was found, if between convex parts

    /// Does a gap [m] matter?
    bool is_wanted(double gap) const { return contacts != nullptr ? gap <= margin : gap < separation; }

    void add_convex(const Convex& a, const Convex& b, std::uint64_t id_base) {
        if (contacts != nullptr) {
            const auto parts_of = [](const Contact& contact) { return contact.id >> part_id_shift; };
            const auto before = std::ranges::find(known, id_base >> part_id_shift, parts_of);
            convex_contacts(a, b, {margin, id_base, *contacts}, before == known.end() ? nullptr : &before->at.n);
        } else {
            const Vec3 direction = separating_direction(a, b);
            const double apart = convex_separation(a, b, direction);
            n = apart < separation ? direction : n;
            separation = std::min(separation, apart);
        }
    }

    void add_convex_plane(const Convex& convex, const Pose& plane, bool plane_is_b, std::uint64_t id_base) {
        if (contacts != nullptr) {
            convex_plane_contacts(convex, plane, plane_is_b, {margin, id_base, *contacts});
        } else {
            separation = std::min(separation, convex_plane_separation(convex, plane));
        }
    }

    void add(const ContactFeature& feature, const Pose& a, const Pose& b) {
        add(feature, PlacedBody(a), PlacedBody(b));
    }
    void add(const ContactFeature& feature, const PlacedBody& a, const PlacedBody& b) {
        const ContactGeometry at = contact_geometry(feature, a, b);
        separation = std::min(separation, at.gap);
        if (contacts != nullptr && at.gap <= margin) {
            FoundContact& contact = contacts->emplace_back();
            contact.at = at;
            contact.feature = feature;
        }
    }
};

/// Feature of a ball (centre c in the frame of the box) against the nearest part of the box's surface.
/// Outside: the nearest corner, edge or face. Inside: the nearest face.
ContactFeature ball_box_feature(const PlacedBall& ball, const PlacedBox& box, bool ball_is_a,
                                std::uint64_t id_base) {
    const Vec3 c = axes_of(box.row).transpose() * (ball.centre - centre_of(box.row));
    const Vec3 half = half_of(box.row);
    Vec3 nearest = c.cwiseMax(-half).cwiseMin(half);
    int outside = 0;
    int face_axis = 0;
    int edge_axis = 0;
    std::uint64_t signs = 0;
    for (int k = 0; k < 3; ++k) {
        if (std::abs(c[k]) > half[k]) {
            ++outside;
            face_axis = k;
            signs |= (c[k] > 0.0 ? 1u : 2u) << (2 * k);
        } else {
            edge_axis = k;
        }
    }
    if (outside == 0) {
        (half - c.cwiseAbs()).minCoeff(&face_axis);
        nearest[face_axis] = c[face_axis] >= 0.0 ? half[face_axis] : -half[face_axis];
        signs = (c[face_axis] >= 0.0 ? 1u : 2u) << (2 * face_axis);
    }
    ContactFeature feature;
    feature.id = id_base + signs;
    Vec3 direction = Vec3::Zero();
    FeatureKind kind = FeatureKind::cores;
    if (outside <= 1) {
        direction[face_axis] = c[face_axis] >= 0.0 ? 1.0 : -1.0;
        kind = ball_is_a ? FeatureKind::face_b : FeatureKind::face_a;
    } else if (outside == 2) {
        direction[edge_axis] = 1.0;
        kind = ball_is_a ? FeatureKind::line_b : FeatureKind::line_a;
    }
    feature.kind = kind;
    const Vec3 direction_body = box.body_from_box.orientation * direction;
    const Vec3 nearest_body = box.body_from_box * nearest;
    if (ball_is_a) {
        feature.core_a = ball.centre_body;
        feature.radius_a = ball.radius;
        feature.core_b = nearest_body;
        feature.direction_b = direction_body;
    } else {
        feature.core_b = ball.centre_body;
        feature.radius_b = ball.radius;
        feature.core_a = nearest_body;
        feature.direction_a = direction_body;
    }
    return feature;
}

/// Feature of a point or ball of one body against the surface of a half space.
ContactFeature plane_feature(const Vec3& core_body, double radius, bool plane_is_b, std::uint64_t id) {
    ContactFeature feature;
    feature.id = id;
    feature.kind = plane_is_b ? FeatureKind::face_b : FeatureKind::face_a;
    (plane_is_b ? feature.core_a : feature.core_b) = core_body;
    (plane_is_b ? feature.radius_a : feature.radius_b) = radius;
    (plane_is_b ? feature.direction_b : feature.direction_a) = Vec3::UnitZ();
    return feature;
}

/// Every part of a bounded shape against a half space.
void against_plane(const Shape& shape, const Pose& pose_a, const Pose& pose_b, bool plane_is_b,
                   Collector& out) {
    const PlacedBody placed_a(pose_a);
    const PlacedBody placed_b(pose_b);
    std::uint64_t part_index = 0;
    for_each_part(shape, [&](const PrimitiveShape& part, const Pose& body_from_part) {
        const std::uint64_t id_base = part_index++ << part_id_shift;
        if (const auto* sphere = std::get_if<Sphere>(&part)) {
            out.add(plane_feature(body_from_part.position, sphere->radius, plane_is_b, id_base), placed_a,
                    placed_b);
            return;
        }
        if (!std::holds_alternative<Box>(part)) {
            const Convex convex = placed(part, plane_is_b ? pose_a : pose_b, body_from_part);
            out.add_convex_plane(convex, plane_is_b ? pose_b : pose_a, plane_is_b, id_base);
            return;
        }
        const Vec3& half = std::get<Box>(part).half_extents;
        const Pose& plane = plane_is_b ? pose_b : pose_a;
        const Pose world_from_part = (plane_is_b ? pose_a : pose_b) * body_from_part;
        const Vec3 normal = plane.orientation * Vec3::UnitZ();
        const Vec3 up = world_from_part.orientation.conjugate() * normal;
        const double middle = normal.dot(world_from_part.position - plane.position);
        for (unsigned corner = 0; corner < 8; ++corner) {
            const Vec3 x((corner & 1u) != 0 ? half.x() : -half.x(), (corner & 2u) != 0 ? half.y() : -half.y(),
                         (corner & 4u) != 0 ? half.z() : -half.z());
            const double height = middle + up.dot(x);
            if (height > 0.0 && !out.is_wanted(0.5 * height)) {
                continue; // too high, however this is rounded
            }
            out.add(plane_feature(body_from_part * x, 0.0, plane_is_b, id_base + corner), placed_a, placed_b);
        }
    });
}

/// A part of a body.
struct Part {
    const PrimitiveShape& shape;
    const Pose& world_from_body;
    const Pose& body_from_part;

    Convex convex() const { return placed(shape, world_from_body, body_from_part); }
    PlacedBox box() const { return placed(std::get<Box>(shape), world_from_body, body_from_part); }
    PlacedBall ball() const { return placed(std::get<Sphere>(shape), world_from_body, body_from_part); }
};

bool has_closed_forms(const PrimitiveShape& a, const PrimitiveShape& b) {
    const auto is_simple = [](const PrimitiveShape& s) {
        return std::holds_alternative<Sphere>(s) || std::holds_alternative<Box>(s);
    };
    return is_simple(a) && is_simple(b);
}

/// One part of a against one part of b.
void part_against_part(const Part& a, const Part& b, std::uint64_t id_base, Collector& out) {
    const bool ball_a = std::holds_alternative<Sphere>(a.shape);
    const bool ball_b = std::holds_alternative<Sphere>(b.shape);
    if (!has_closed_forms(a.shape, b.shape)) {
        out.add_convex(a.convex(), b.convex(), id_base);
    } else if (ball_a && ball_b) {
        ContactFeature feature;
        feature.id = id_base;
        feature.core_a = a.body_from_part.position;
        feature.core_b = b.body_from_part.position;
        feature.radius_a = std::get<Sphere>(a.shape).radius;
        feature.radius_b = std::get<Sphere>(b.shape).radius;
        out.add(feature, a.world_from_body, b.world_from_body);
    } else if (ball_a) {
        out.add(ball_box_feature(a.ball(), b.box(), true, id_base), a.world_from_body, b.world_from_body);
    } else if (ball_b) {
        out.add(ball_box_feature(b.ball(), a.box(), false, id_base), a.world_from_body, b.world_from_body);
    } else {
        const PlacedBox box_a = a.box();
        const PlacedBox box_b = b.box();
        const BoxAxes axes = box_box_axes(box_a, box_b);
        if (out.contacts != nullptr) {
            box_box_contacts(box_a, box_b, axes, {out.margin, id_base, *out.contacts});
        } else {
            out.separation = std::min(out.separation, axes.separation());
        }
    }
}

void collect(const PlacedShape& a, const PlacedShape& b, Collector& out) {
    const bool plane_a = std::holds_alternative<Plane>(a.shape);
    const bool plane_b = std::holds_alternative<Plane>(b.shape);
    CHECK(!(plane_a && plane_b));
    if (plane_b) {
        against_plane(a.shape, a.pose, b.pose, true, out);
        return;
    }
    if (plane_a) {
        against_plane(b.shape, a.pose, b.pose, false, out);
        return;
    }
    std::uint64_t pair_index = 0;
    for_each_part(a.shape, [&](const PrimitiveShape& part_a, const Pose& a_from_part) {
        const Vec3 middle_a = a.pose * a_from_part.position;
        const double reach_a = reach_of(part_a);
        for_each_part(b.shape, [&](const PrimitiveShape& part_b, const Pose& b_from_part) {
            const std::uint64_t id_base = pair_index++ << part_id_shift;
            if (out.is_wanted((b.pose * b_from_part.position - middle_a).norm() - reach_a - reach_of(part_b))) {
                part_against_part({part_a, a.pose, a_from_part}, {part_b, b.pose, b_from_part}, id_base, out);
            }
        });
    });
}

void sort_by_id(std::vector<FoundContact>& contacts) {
    const auto id = [](const FoundContact& contact) { return contact.feature.id; };
    if (!std::ranges::is_sorted(contacts, {}, id)) {
        std::ranges::sort(contacts, {}, id);
    }
}

} // namespace

void find_contacts(const PlacedShape& a, const PlacedShape& b, double margin, std::vector<FoundContact>& contacts,
                   std::span<const Contact> known) {
    contacts.clear();
    Collector out{.margin = margin, .contacts = &contacts, .known = known};
    collect(a, b, out);
    sort_by_id(contacts);
}

double separation(const PlacedShape& a, const PlacedShape& b, ContactFeature* nearest) {
    Collector out;
    collect(a, b, out);
    if (nearest != nullptr) {
        nearest->kind = FeatureKind::face_b;
        nearest->direction_b = b.pose.orientation.conjugate() * out.n;
    }
    return out.separation;
}

std::optional<double> separation_along(const PlacedShape& a, const PlacedShape& b, const ContactFeature& features) {
    const std::optional<PrimitiveShape> part_a = only_part(a.shape);
    const std::optional<PrimitiveShape> part_b = only_part(b.shape);
    if (!part_a || !part_b || has_closed_forms(*part_a, *part_b)) {
        return std::nullopt;
    }
    return convex_separation(placed(*part_a, a.pose, Pose{}), placed(*part_b, b.pose, Pose{}),
                             contact_geometry(features, a.pose, b.pose).n);
}

} // namespace sim
