#pragma once
/// The frames of eight blocks, and the relative twists of their bodies. Included by kernels only.
#include "sim/base/lanes.h"
#include "sim/block/batch.h"

namespace sim {
namespace {

/// The frame of a block: n from b to a, t_1 and t_2 across.
struct Frame {
    Real3 t1, t2, n;
    LANES_INLINE Real3 world(const Real& x, const Real& y) const { return x * t1 + y * t2; }
};

LANES_INLINE Frame frame_of(const BlockBatch& batch) {
    return {load3(batch.frame), load3(batch.frame + 3), load3(batch.frame + 6)};
}

/// Relative twist of the bodies of a block, in its frame: u_1 u_2 u_n, w_1 w_2 w_n.
struct Twist {
    Real3 u, w;
    /// Velocity of a point of the block.
    LANES_INLINE Real normal(const Real& x, const Real& y) const { return u.z + w.x * y - w.y * x; }
    LANES_INLINE Real tangential1(const Real& y) const { return u.x - w.z * y; }
    LANES_INLINE Real tangential2(const Real& x) const { return u.y + w.z * x; }
};

/// velocity: rows as in BatchSweep.
LANES_INLINE Twist twist_of(const double* velocity, const BlockBatch& batch, const Frame& f) {
    Real a[8];
    Real b[8];
    gather(velocity, batch.a, a);
    gather(velocity, batch.b, b);
    const Real3 w_a{a[3], a[4], a[5]};
    const Real3 w_b{b[3], b[4], b[5]};
    const Real3 v = Real3{a[0], a[1], a[2]} + cross(w_a, load3(batch.r_a)) -
                    (Real3{b[0], b[1], b[2]} + cross(w_b, load3(batch.r_b)));
    return {{dot(f.t1, v), dot(f.t2, v), dot(f.n, v)},
            {dot(f.t1, w_a - w_b), dot(f.t2, w_a - w_b), dot(f.n, w_a - w_b)}};
}

} // namespace
} // namespace sim
