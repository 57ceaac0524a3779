#include "sim/collide/feature_contacts.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

namespace sim {
namespace {

/// Edges and axes that cross at less than this angle [rad], and lie across the normal within it, touch at the ends of what they
/// share; at less than the other, only there.
constexpr double nearly_parallel_edges = 0.05;
constexpr double parallel = 1e-5;

/// Cores nearer than this share [-] of the sizes tell no direction.
constexpr double same_point = 1e-6;

using Kind = CoreFeature::Kind;

/// Where a feature of a touches along the world direction n from b to a, as a point or a line.
struct Touch {
    Vec3 core;              ///< [m], world
    Vec3 line = Vec3::Zero(); ///< unit, world; zero: a point
    double radius = 0.0;    ///< [m] around the core
};

/// inwards: unit, into the body.
Touch touch_of(const Convex& convex, const CoreFeature& feature, const Vec3& inwards) {
    Touch touch{feature.point, Vec3::Zero(), convex.rounding};
    if (feature.kind == Kind::edge) {
        touch.line = feature.direction;
        touch.radius += feature.radius;
    } else if (feature.kind == Kind::rim) {
        touch.core = lowest_rim_point(feature.point, feature.direction, feature.radius, inwards);
        touch.line = feature.direction.cross(touch.core - feature.point).stableNormalized();
    }
    return touch;
}

/// The contact of two touches: points and lines as such; a plane across n where the lines are parallel, and where the
/// cores are so near that they tell no direction.
FoundContact touch_contact(const Convex& a, const Convex& b, const Touch& ta, const Touch& tb, const Vec3& n) {
    FoundContact contact;
    ContactFeature& f = contact.feature;
    const bool line_a = !ta.line.isZero(0.0);
    const bool line_b = !tb.line.isZero(0.0);
    const Vec3 cross = ta.line.cross(tb.line);
    const double core_gap = n.dot(ta.core - tb.core);
    f.core_a = in_frame(a.world_from_body, ta.core);
    f.core_b = in_frame(b.world_from_body, tb.core);
    f.radius_a = ta.radius;
    f.radius_b = tb.radius;
    f.direction_a = a.world_from_body.orientation.conjugate() * ta.line;
    f.direction_b = b.world_from_body.orientation.conjugate() * tb.line;
    if (line_a && line_b && cross.norm() > parallel) {
        f.kind = FeatureKind::edges;
        f.direction_a = cross.dot(n) >= 0.0 ? f.direction_a : Vec3(-f.direction_a);
    } else if ((line_a && line_b) || core_gap < same_point * (a.size + b.size)) {
        f.kind = FeatureKind::face_b;
        f.direction_a.setZero();
        f.direction_b = b.world_from_body.orientation.conjugate() * n;
    } else {
        f.kind = line_a ? FeatureKind::line_a : line_b ? FeatureKind::line_b : FeatureKind::cores;
    }
    contact.at = contact_geometry(f, a.world_from_body, b.world_from_body);
    return contact;
}

/// Two lines along which bodies touch, with the normal n there: of a round one its axis, of a polytope an edge.
struct Lines {
    CoreFeature a;
    CoreFeature b;
    Vec3 n;

    double sine() const { return a.direction.cross(b.direction).norm(); }
};

bool has_axis(const Convex& convex) {
    return convex.kind == CoreKind::segment || convex.kind == CoreKind::cylinder;
}

/// The line that a feature is, or ends: of a rim or a tip the axis; of a corner that of its edges that is nearest to `along`.
/// u: towards the other body; both unit. No edge where there is none.
CoreFeature line_of(const Convex& convex, const CoreFeature& feature, const Vec3& u, const Vec3& along) {
    CoreFeature line = feature;
    if (feature.kind == Kind::edge || convex.kind == CoreKind::point) {
        return line;
    }
    std::vector<CoreFeature> near;
    near_features(convex, u, near);
    double nearest = -1.0; // cosine
    for (const CoreFeature& edge : near) {
        const double cosine = std::abs(edge.direction.dot(along));
        if (edge.kind == Kind::edge && cosine > nearest) {
            nearest = cosine;
            line = edge;
        }
    }
    return line;
}

/// The lines where they are nearly parallel, and one of them is an axis. Which end of what they share is the lowest changes with
/// the least turn of a body that rests along it.
std::optional<Lines> parallel_lines(const Convex& a, const Convex& b, const SeparatingDirection& best) {
    if (!has_axis(a) && !has_axis(b)) {
        return std::nullopt;
    }
    const Vec3 axis = has_axis(a) ? a.axis() : b.axis();
    const Lines lines{line_of(a, best.a, -best.n, axis), line_of(b, best.b, best.n, axis), best.n};
    const auto lies_across = [&](const CoreFeature& f) {
        return f.kind == Kind::edge && std::abs(f.direction.dot(best.n)) < nearly_parallel_edges;
    };
    const bool are_parallel = lies_across(lines.a) && lies_across(lines.b) && lines.sine() < nearly_parallel_edges;
    return are_parallel ? std::optional(lines) : std::nullopt;
}

/// Contacts at both ends of what two nearly parallel lines share. gap [m]: of the bodies, to which theirs are raised: the ball
/// that stands for a cylinder's end reaches beyond its rim where it leans.
void shared_ends(const Convex& a, const Convex& b, const Lines& lines, double gap, const ContactList& list) {
    const Vec3& n = lines.n;
    const CoreFeature& ea = lines.a;
    const CoreFeature& eb = lines.b;
    const double cosine = ea.direction.dot(eb.direction);
    const double side = std::copysign(1.0, cosine);
    const double middle_b = ea.direction.dot(eb.point - ea.point);
    for (const double end : {1.0, -1.0}) {
        const double end_b = middle_b + end * std::abs(cosine) * eb.length;
        const bool ends_with_a = end * end_b > ea.length;
        if (end * end_b < -ea.length) {
            continue; // they share nothing
        }
        Touch ta = touch_of(a, ea, n);
        Touch tb = touch_of(b, eb, -n);
        if (ends_with_a) {
            ta.core = ea.point + end * ea.length * ea.direction;
            ta.line.setZero();
        } else {
            tb.core = eb.point + end * side * eb.length * eb.direction;
            tb.line.setZero();
        }
        FoundContact contact = touch_contact(a, b, ta, tb, n);
        contact.feature.id = list.id_base + contact_id(6, end > 0.0 ? 1 : 0, 0, 0);
        add_raised(contact, gap, list);
    }
}

} // namespace

std::uint64_t contact_id(std::uint64_t group, std::uint64_t first, std::uint64_t second, std::uint64_t third) {
    std::uint64_t hash = first;
    for (const std::uint64_t x : {second, third}) {
        hash = hash * 0x9E3779B97F4A7C15u + x + 1; // Fibonacci hashing (Knuth, vol. 3, sec. 6.4)
        hash ^= hash >> 29;
    }
    return (group << 28) | (hash & ((std::uint64_t{1} << 28) - 1));
}

void add_raised(FoundContact contact, double least, const ContactList& list) {
    if (contact.at.gap < least) {
        contact.feature.allowance = least - contact.at.gap;
        contact.at.gap = least;
    }
    if (contact.at.gap <= list.margin) {
        list.contacts.push_back(contact);
    }
}

void feature_contacts(const Convex& a, const Convex& b, const SeparatingDirection& best, double gap, const ContactList& list) {
    const std::size_t first = list.contacts.size();
    if (const std::optional<Lines> lines = parallel_lines(a, b, best)) {
        shared_ends(a, b, *lines, gap, list);
        const std::span<const FoundContact> ends = std::span(list.contacts).subspan(first);
        const auto is_lowest = [&](const FoundContact& end) { return end.at.gap <= gap + same_gap * (a.size + b.size); };
        if (!ends.empty() && (lines->sine() < parallel || std::ranges::any_of(ends, is_lowest))) {
            return;
        }
    }
    FoundContact contact = touch_contact(a, b, touch_of(a, best.a, best.n), touch_of(b, best.b, -best.n), best.n);
    contact.feature.id =
        list.id_base + contact_id(5, static_cast<std::uint64_t>(best.a.kind) * 4 + static_cast<std::uint64_t>(best.b.kind),
                             static_cast<std::uint64_t>(best.a.index), static_cast<std::uint64_t>(best.b.index));
    list.contacts.push_back(contact);
}

} // namespace sim
