#pragma once
/// Where rays meet spheres, faces of hulls and bodies of revolution.
#include "render/scene/float4.h"
#include "render/scene/mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace render {

/// A face of a hull, or a body of revolution; rays are followed in its frame, divided by its scale.
struct RoundPart {
    glm::vec3 origin;          ///< of all rays
    glm::mat3 ray_from_window; ///< direction of the ray through (x, y, 1), such that w is the ray's parameter
    const LatheBand* first;    ///< bands of this group; none for a sphere
    const LatheBand* last;
    float radius;         ///< that holds the bands, with some to spare
    const HullFace* face; ///< null: a body of revolution
};

/// Four rays, in the frame of a round part.
struct Rays {
    glm::vec3 origin;
    Float4 x;
    Float4 y;
    Float4 z;
};

/// Parameters > 0 at which the rays enter the unit sphere; infinity if they do not.
inline Float4 meet_sphere(const Rays& rays) {
    const glm::vec3& o = rays.origin;
    const Float4 a = rays.x * rays.x + rays.y * rays.y + rays.z * rays.z;
    const Float4 b = all(o.x) * rays.x + all(o.y) * rays.y + all(o.z) * rays.z;
    const Float4 d = b * b - a * all(glm::dot(o, o) - 1.0f);
    const Float4 t = (-b - root(chosen(d > all(0.0f), d, all(0.0f)))) / a;
    return chosen((d >= all(0.0f)) & (t > all(0.0f)), t, all(std::numeric_limits<float>::infinity()));
}

/// As meet_sphere, for a face of a hull.
inline Float4 meet_face(const HullFace& face, const Rays& rays) {
    const glm::vec3& n = face.normal;
    const glm::vec3& o = rays.origin;
    const Float4 t =
        all(glm::dot(n, face.corners[0] - o)) / (all(n.x) * rays.x + all(n.y) * rays.y + all(n.z) * rays.z);
    Int4 is_met = t > all(0.0f);
    glm::vec3 from = face.corners.back();
    for (const glm::vec3& to : face.corners) {
        const glm::vec3 side = to - from;
        const Float4 x = all(o.x) + t * rays.x - all(from.x);
        const Float4 y = all(o.y) + t * rays.y - all(from.y);
        const Float4 z = all(o.z) + t * rays.z - all(from.z);
        const Float4 inwards = (all(side.y) * z - y * all(side.z)) * all(n.x) +
                               (all(side.z) * x - z * all(side.x)) * all(n.y) +
                               (all(side.x) * y - x * all(side.y)) * all(n.z);
        is_met = is_met & ~(inwards < all(0.0f));
        from = to;
    }
    return chosen(is_met, t, all(std::numeric_limits<float>::infinity()));
}

/// As meet_sphere, for a cone's band, from outside or inside, or a flat ring.
inline Float4 meet_band(const LatheBand& band, const Rays& rays) {
    const Float4 none = all(std::numeric_limits<float>::infinity());
    const glm::vec3& o = rays.origin;
    const float height = band.upper.y - band.lower.y;
    if (height == 0.0f) {
        const Float4 t = all(band.lower.y - o.z) / rays.z;
        const Float4 x = all(o.x) + t * rays.x;
        const Float4 y = all(o.y) + t * rays.y;
        const Float4 radius = root(x * x + y * y);
        const auto [inner, outer] = std::minmax(band.lower.x, band.upper.x);
        return chosen((t > all(0.0f)) & (radius >= all(inner)) & (radius <= all(outer)), t, none);
    }
    // x^2 + y^2 = (q + k z)^2 along the ray.
    const float slope = (band.upper.x - band.lower.x) / height;
    const float radius = band.lower.x + slope * (o.z - band.lower.y);
    const Float4 a = rays.x * rays.x + rays.y * rays.y - all(slope * slope) * rays.z * rays.z;
    const Float4 b = all(o.x) * rays.x + all(o.y) * rays.y - all(slope) * rays.z * all(radius);
    const Float4 c = all(o.x * o.x + o.y * o.y - radius * radius);
    const Float4 d = b * b - a * c;
    const auto [z0, z1] = std::minmax(band.lower.y, band.upper.y);
    Float4 nearest = none;
    const Int4 has_root = (d >= all(0.0f)) & (a != all(0.0f));
    if (!any(has_root)) {
        return none;
    }
    const Float4 far_root = root(chosen(has_root, d, all(0.0f)));
    for (const Float4& sum : {-b - far_root, -b + far_root}) {
        const Float4 t = sum / a;
        const Float4 z = all(o.z) + t * rays.z;
        const Int4 is_met = has_root & (t > all(0.0f)) & (t < nearest) & (z >= all(z0)) & (z <= all(z1));
        nearest = chosen(is_met, t, nearest);
    }
    return nearest;
}

struct Heights {
    float low;
    float high;
};

/// Where the rays are while they are within a radius about z, or a little more.
inline Heights heights_within(float radius, const Rays& rays) {
    constexpr float most = std::numeric_limits<float>::max();
    const glm::vec3& o = rays.origin;
    const Float4 a = rays.x * rays.x + rays.y * rays.y;
    const Float4 b = all(o.x) * rays.x + all(o.y) * rays.y;
    const Float4 d = b * b - a * all(o.x * o.x + o.y * o.y - radius * radius);
    const Float4 far_root = root(chosen(d > all(0.0f), d, all(0.0f)));
    Heights within{most, -most};
    for (const Float4& sum : {-b - far_root, -b + far_root}) {
        const Float4 z = all(o.z) + sum / a * rays.z;
        for (int s = 0; s < 4; ++s) {
            // Along the axis, or nearly: anywhere.
            within.low = std::isfinite(z[s]) ? std::min(within.low, z[s]) : -most;
            within.high = std::isfinite(z[s]) ? std::max(within.high, z[s]) : most;
        }
    }
    const float spare = 1e-3f * (radius + std::abs(o.z));
    return {within.low - spare, within.high + spare};
}

/// As meet_sphere, for the bands of a body of revolution.
inline Float4 meet_bands(const RoundPart& part, const Rays& rays) {
    Float4 nearest = all(std::numeric_limits<float>::infinity());
    const Heights within = heights_within(part.radius, rays);
    for (const LatheBand* band = part.first; band != part.last; ++band) {
        const auto [low, high] = std::minmax(band->lower.y, band->upper.y);
        if (high < within.low || low > within.high) {
            continue;
        }
        const Float4 t = meet_band(*band, rays);
        nearest = chosen(t < nearest, t, nearest);
    }
    return nearest;
}

/// As meet_sphere, for any of these.
inline Float4 meet(const RoundPart& part, const Rays& rays) {
    return part.face != nullptr    ? meet_face(*part.face, rays)
           : part.first == nullptr ? meet_sphere(rays)
                                   : meet_bands(part, rays);
}

} // namespace render
