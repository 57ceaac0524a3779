#pragma once
/// How the bodies of eight blocks have moved when the interval ends, and with them the edges that cross. Included by rest_kernel.cpp
/// only, once for each instruction set.
#include "sim/block/lane_twist.h"
#include "sim/solve/rest_batch.h"

namespace sim {
namespace {

/// A body's predicted motion since the interval began.
struct Motion {
    Real row[16];
    LANES_INLINE Motion(const BodyRows* end, const int* body) { gather_two(end->x, body, row); }
    LANES_INLINE Real3 turn(const Real3& v) const {
        return {row[0] * v.x + row[1] * v.y + row[2] * v.z, row[3] * v.x + row[4] * v.y + row[5] * v.z,
                row[6] * v.x + row[7] * v.y + row[8] * v.z};
    }
    LANES_INLINE Real3 position() const { return {row[9], row[10], row[11]}; }
};

/// A body as the interval begins.
struct Placed {
    Real3 axis; ///< of its orientation, a quaternion
    Real w, radius;
    LANES_INLINE Placed(const BodyRows* begin, const int* body) {
        Real row[8];
        gather([&](int l) { return begin[body[l]].x + 8; }, row);
        axis = {row[3], row[4], row[5]};
        w = row[6];
        radius = row[7];
    }
    LANES_INLINE Real3 turn(const Real3& v) const {
        const Real3 across = cross(axis, v);
        const Real3 twice = across + across;
        return v + w * twice + cross(axis, twice);
    }
};

/// The same bodies, before and after.
struct Moved {
    const Placed& from;
    const Motion& by;
};

/// Normal of crossing edges.
LANES_INLINE Real3 edge_normal(const Real3& edge_a, const Real3& edge_b) {
    const Real one = real(1.0);
    const Real zero = real(0.0);
    const Real3 across = cross(edge_a, edge_b);
    const Real square = dot(across, across);
    const Mask crosses = square > 0.0;
    return (1.0 / select(crosses, sqrt(square), one)) * select(crosses, across, Real3{zero, zero, one});
}

/// The crossing edges of the blocks at the predicted poses.
struct Edges {
    Real3 a, b, n;
    Real3 lean; ///< where impulses act along another normal: how much their points differ from the edges', per gap
    Real size;  ///< [m] of the smaller body
    LANES_INLINE Edges() {}
    /// rows: their directions in the bodies' frames.
    LANES_INLINE Edges(const double* const* rows, const Moved& on_a, const Moved& on_b, const Real3& n_b) {
        Real row[8];
        gather([&](int l) { return rows[l]; }, row);
        const Real3 a_before = on_a.from.turn({row[0], row[1], row[2]});
        const Real3 b_before = on_b.from.turn({row[3], row[4], row[5]});
        size = min(on_a.from.radius, on_b.from.radius);
        a = on_a.by.turn(a_before);
        b = on_b.by.turn(b_before);
        n = edge_normal(a, b);
        lean = n_b - on_b.by.turn(edge_normal(a_before, b_before));
    }
    /// Is the touch now too far along them? d: of points on them that touched as the interval began. The lines of edges
    /// that are parallel are nowhere near.
    LANES_INLINE Mask wander(const Real3& d) const {
        const Real cosine = dot(a, b);
        const Real sine_square = 1.0 - cosine * cosine;
        return abs(cosine * dot(d, b) - dot(d, a)) > wander_share * size * abs(sine_square);
    }
};

} // namespace
} // namespace sim
