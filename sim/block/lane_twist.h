#pragma once
/// The frames of eight blocks, the relative twists of their bodies, and the wrenches that these get. Included by kernels only.
#include "sim/base/lanes.h"
#include "sim/block/batch.h"

namespace sim {
namespace {

/// The frame of a block: n from b to a, t_1 and t_2 across.
struct Frame {
    Real3 t1, t2, n;
    LANES_INLINE Real3 world(const Real& x, const Real& y) const { return x * t1 + y * t2; }
    LANES_INLINE Real3 world(const Real3& v) const { return world(v.x, v.y) + v.z * n; }
};

LANES_INLINE Frame frame_of(const BlockBatch& batch, Window lanes) {
    const Real3 t1 = lanes.load3(batch.t1);
    const Real3 n = lanes.load3(batch.n);
    return {t1, cross(n, t1), n};
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
LANES_INLINE Twist twist_of(const double* velocity, const BlockBatch& batch, const Frame& f, Window lanes) {
    Real a[8];
    Real b[8];
    gather([&](int l) { return velocity + 8 * batch.a[lanes.first + l]; }, a);
    gather([&](int l) { return velocity + 8 * batch.b[lanes.first + l]; }, b);
    const Real3 w_a{a[3], a[4], a[5]};
    const Real3 w_b{b[3], b[4], b[5]};
    const Real3 v = Real3{a[0], a[1], a[2]} + cross(w_a, lanes.load3(batch.r_a)) -
                    (Real3{b[0], b[1], b[2]} + cross(w_b, lanes.load3(batch.r_b)));
    return {{dot(f.t1, v), dot(f.t2, v), dot(f.n, v)},
            {dot(f.t1, w_a - w_b), dot(f.t2, w_a - w_b), dot(f.n, w_a - w_b)}};
}

/// Response of (u_n, w_1, w_2) to (P_n, L_1, L_2).
LANES_INLINE Sym3 normal_response(const BlockBatch& batch, Window lanes) {
    const auto w = [&](int i, int j) { return lanes.load(batch.response[i * (i + 1) / 2 + j]); };
    return {w(2, 2), w(3, 2), w(4, 2), w(3, 3), w(4, 3), w(4, 4)};
}

/// (P, L): an impulse [N s], and its moment [N m s] about a block's centre.
struct Wrench {
    Real3 force, moment;
};

/// One body of each of the blocks, where it moves; r: from its centre to the block's [m].
struct Pushed {
    const int* body;
    unsigned moves;
    Real3 r;
};

/// Gives the bodies a wrench. rows: as the interval begins; velocity: rows as in BatchSweep.
LANES_INLINE void push(const BodyRows* rows, double* velocity, const Pushed& to, const Wrench& by) {
    Real m[8];
    gather([&](int l) { return rows[to.body[l]].x; }, m);
    const Real3 dv = m[0] * by.force;
    const Real3 dw = Sym3{m[1], m[2], m[3], m[4], m[5], m[6]} * (cross(to.r, by.force) + by.moment);
    const Real zero = real(0.0);
    Real change[8] = {dv.x, dv.y, dv.z, dw.x, dw.y, dw.z, zero, zero};
    scatter(change, [&](int l, int place, const Real& numbers) {
        if ((to.moves >> l & 1u) != 0) {
            double* row = velocity + 8 * to.body[l] + place;
            store(row, load(row) + numbers);
        }
    });
}

/// Gives body a of the blocks a wrench, and b the opposite.
LANES_INLINE void push_bodies(const BodyRows* rows, double* velocity, const BlockBatch& batch, Window lanes, const Wrench& by) {
    push(rows, velocity, {batch.a + lanes.first, batch.moves_a >> lanes.first, lanes.load3(batch.r_a)}, by);
    push(rows, velocity, {batch.b + lanes.first, batch.moves_b >> lanes.first, lanes.load3(batch.r_b)}, {-by.force, -by.moment});
}

} // namespace
} // namespace sim
