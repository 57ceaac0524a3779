#include "sim/collide/manifold.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim {
namespace {

/// Unit vector of d, or `fallback` where d has no direction.
Vec3 direction_or(const Vec3& d, const Vec3& fallback) {
    const double length = d.norm();
    return length > 0.0 ? Vec3(d / length) : fallback;
}

/// direction: unit.
Vec3 nearest_on_line(const Vec3& point, const Vec3& direction, const Vec3& to) {
    return point + direction * direction.dot(to - point);
}

/// Contacts that one face keeps: with a crossing of edges they fill a block.
constexpr std::size_t most_contacts = 8;

} // namespace

Vec3 lowest_rim_point(const Vec3& centre, const Vec3& axis, double radius, const Vec3& n) {
    const Vec3 across = n - axis * axis.dot(n);
    const double length = across.norm();
    return length > 0.0 ? Vec3(centre - across * (radius / length)) : centre;
}

ContactGeometry contact_geometry(const ContactFeature& feature, const PlacedBody& a, const PlacedBody& b) {
    Vec3 core_a = a * feature.core_a;
    Vec3 core_b = b * feature.core_b;
    ContactGeometry g;
    double distance = 0.0; // of the cores along n
    switch (feature.kind) {
    case FeatureKind::rim_on_face_a:
        core_b = lowest_rim_point(core_b, b.rotation * feature.direction_b, feature.radius_b,
                                  a.rotation * feature.direction_a);
        [[fallthrough]];
    case FeatureKind::face_a:
        g.n = -(a.rotation * feature.direction_a);
        distance = g.n.dot(core_a - core_b);
        core_a = core_b + distance * g.n;
        break;
    case FeatureKind::rim_on_face_b:
        core_a = lowest_rim_point(core_a, a.rotation * feature.direction_a, feature.radius_a,
                                  b.rotation * feature.direction_b);
        [[fallthrough]];
    case FeatureKind::face_b:
        g.n = b.rotation * feature.direction_b;
        distance = g.n.dot(core_a - core_b);
        core_b = core_a - distance * g.n;
        break;
    case FeatureKind::line_a:
    case FeatureKind::line_b:
    case FeatureKind::cores:
        if (feature.kind == FeatureKind::line_a) {
            core_a = nearest_on_line(core_a, a.rotation * feature.direction_a, core_b);
        } else if (feature.kind == FeatureKind::line_b) {
            core_b = nearest_on_line(core_b, b.rotation * feature.direction_b, core_a);
        }
        g.n = direction_or(core_a - core_b, Vec3::UnitZ());
        distance = g.n.dot(core_a - core_b);
        break;
    case FeatureKind::edges: {
        const Vec3 edge_a = a.rotation * feature.direction_a;
        const Vec3 edge_b = b.rotation * feature.direction_b;
        g.n = direction_or(edge_a.cross(edge_b), Vec3::UnitZ());
        distance = g.n.dot(core_a - core_b);
        // Closest points of the two lines.
        const double cosine = edge_a.dot(edge_b);
        const Vec3 between = core_b - core_a;
        const double along_a = between.dot(edge_a);
        const double along_b = between.dot(edge_b);
        const double denominator = 1.0 - cosine * cosine;
        core_a += edge_a * ((along_a - cosine * along_b) / denominator);
        core_b = core_a - distance * g.n;
        break;
    }
    }
    const double radius_a = is_rim(feature) ? 0.0 : feature.radius_a;
    const double radius_b = is_rim(feature) ? 0.0 : feature.radius_b;
    g.gap = distance - radius_a - radius_b + feature.allowance;
    g.a = core_a - radius_a * g.n;
    return g;
}

void Manifold::keep_features(std::span<const FoundContact> found) {
    std::size_t count = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
        const bool is_told = is_flat(found[i].feature);
        contacts[i].feature = static_cast<std::uint16_t>(is_told ? 0 : count + 1);
        if (!is_told) {
            features.resize(std::max(features.size(), count + 1));
            features[count++] = found[i].feature;
        }
    }
    features.resize(count);
    if (count == 0) {
        features.shrink_to_fit(); // flat ones mostly stay so
    }
}

FoundContact Manifold::found(const Contact& contact, const Pose& a, const Pose& b) const {
    FoundContact found;
    found.at = contact.at;
    if (contact.feature > 0) {
        found.feature = features[contact.feature - 1u];
        return found;
    }
    found.feature.id = contact.id;
    found.feature.kind = contact.kind;
    found.feature.core_a = a.orientation.conjugate() * (contact.at.a - a.position);
    found.feature.core_b = b.orientation.conjugate() * (contact.at.b() - b.position);
    if (contact.kind == FeatureKind::face_a) {
        found.feature.direction_a = a.orientation.conjugate() * -contact.at.n;
    } else {
        found.feature.direction_b = b.orientation.conjugate() * contact.at.n;
    }
    return found;
}

void keep_outermost(std::vector<FoundContact>& contacts, std::size_t first) {
    if (contacts.size() - first <= most_contacts) {
        return;
    }
    const auto begin = contacts.begin() + static_cast<std::ptrdiff_t>(first);
    const Vec3 n = begin->at.n;
    const Vec3 t = n.unitOrthogonal();
    const Vec3 s = n.cross(t);
    std::vector<char> keep(contacts.size() - first, 0);
    const auto mark = [&](const auto& value) {
        const auto best = std::ranges::max_element(begin, contacts.end(), {}, value);
        keep[static_cast<std::size_t>(best - begin)] = 1;
    };
    mark([](const FoundContact& c) { return -c.at.gap; });
    for (std::size_t k = 0; k + 1 < most_contacts; ++k) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / (most_contacts - 1);
        const Vec3 outwards = std::cos(angle) * t + std::sin(angle) * s;
        mark([&](const FoundContact& c) { return outwards.dot(c.at.a); });
    }
    std::size_t next = first;
    for (std::size_t i = 0; i < keep.size(); ++i) {
        if (keep[i] != 0) {
            contacts[next++] = contacts[first + i];
        }
    }
    contacts.resize(next);
}

} // namespace sim
