#include "sim/collide/ccd_bridge.h"

#include <ccd/ccd.h>

#include <algorithm>

namespace sim {
namespace {

/// Both cores are enlarged by this share [-] of the smaller one: the direction stays well defined down to the touch.
/// Where that does not make them overlap, by half the distance of their centres.
constexpr double enlargement = 0.02;

/// Tolerance of the polytope that grows towards the nearest face, as a share [-] of the smaller core; one of less than
/// `smallest` [-] of the larger one counts as that: for a grain in a round body the polytope would have a million corners.
constexpr double tolerance = 1e-5;
constexpr double smallest = 1e-2;
/// Steps until the cores are known to overlap.
constexpr unsigned long iteration_limit = 100;

struct Enlarged {
    const Convex* convex;
    double margin; ///< [m]
};

Vec3 from_ccd(const ccd_vec3_t& v) {
    return {v.v[0], v.v[1], v.v[2]};
}

extern "C" void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* point) noexcept {
    const auto& enlarged = *static_cast<const Enlarged*>(object);
    const Vec3 u = from_ccd(*direction).stableNormalized();
    const Vec3 x = support_point(*enlarged.convex, u) + enlarged.margin * u;
    ccdVec3Set(point, x.x(), x.y(), x.z());
}

double size_of(const Convex& convex) {
    return convex.size + convex.rounding;
}

} // namespace

std::optional<Vec3> penetration_direction(const Convex& a, const Convex& b) {
    const double size = std::min(size_of(a), size_of(b));
    const double distance = (a.world_from_part.position - b.world_from_part.position).norm();
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = support;
    ccd.max_iterations = iteration_limit;
    ccd.epa_tolerance = tolerance * std::max(size, smallest * std::max(size_of(a), size_of(b)));
    for (const double margin : {enlargement * size, 0.5 * distance + enlargement * size}) {
        const Enlarged first{&a, margin};
        const Enlarged second{&b, margin};
        double depth = 0.0;
        ccd_vec3_t direction;
        ccd_vec3_t point;
        if (ccdGJKPenetration(&first, &second, &ccd, &depth, &direction, &point) == 0) {
            // libccd moves b out of a along its direction: that is against n.
            const Vec3 n = -from_ccd(direction);
            return n.allFinite() && n.norm() > 0.5 ? std::optional<Vec3>(n.normalized()) : std::nullopt;
        }
    }
    return std::nullopt;
}

} // namespace sim
