#include "sim/collide/manifold.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

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

/// Of corners that span the same area rounding must not choose: each counts the more, by up to this share [-], the farther it lies
/// to this side in the frame of a.
constexpr double uneven = 1e-3;
const Vec3 uneven_side(0.6, 0.7, 0.4);

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
    const double radius_a = is_rim(feature.kind) ? 0.0 : feature.radius_a;
    const double radius_b = is_rim(feature.kind) ? 0.0 : feature.radius_b;
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

void keep_outermost(std::vector<FoundContact>& contacts, std::size_t first, double slack) {
    if (contacts.size() - first <= most_contacts) {
        return;
    }
    const std::span<FoundContact> all = std::span(contacts).subspan(first);
    const auto place = [&](std::size_t i) -> const Vec3& { return all[i].at.a; };
    const auto gap = [&](std::size_t i) { return all[i].at.gap; };
    Vec3 middle = Vec3::Zero();
    for (std::size_t i = 0; i < all.size(); ++i) {
        middle += place(i) / static_cast<double>(all.size());
    }
    const Vec3 n = all.front().at.n;
    const Vec3 t = n.unitOrthogonal();
    std::vector<std::size_t> ring(all.size()); // in the order of their angles about the middle
    std::iota(ring.begin(), ring.end(), std::size_t{0});
    std::ranges::sort(ring, {}, [&](std::size_t i) {
        const Vec3 arm = place(i) - middle;
        return std::atan2(n.cross(t).dot(arm), t.dot(arm));
    });
    const std::size_t lowest = *std::ranges::min_element(ring, {}, gap);
    while (ring.size() > most_contacts) {
        std::vector<double> area; // of the triangle with its neighbours, twice [m^2]
        for (std::size_t k = 0; k < ring.size(); ++k) {
            const Vec3& at = place(ring[k]);
            const Vec3 before = place(ring[(k + ring.size() - 1) % ring.size()]) - at;
            const Vec3 after = place(ring[(k + 1) % ring.size()]) - at;
            const double side = all[ring[k]].feature.core_a.stableNormalized().dot(uneven_side);
            area.push_back((1.0 + uneven * side) * n.dot(after.cross(before)));
        }
        ring.erase(ring.begin() + (std::ranges::min_element(area) - area.begin()));
    }
    if (gap(lowest) < gap(*std::ranges::min_element(ring, {}, gap)) - slack) {
        ring.back() = lowest;
    }
    std::ranges::sort(ring);
    for (std::size_t k = 0; k < ring.size(); ++k) {
        all[k] = all[ring[k]];
    }
    contacts.resize(first + ring.size());
}

} // namespace sim
