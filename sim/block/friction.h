#pragma once
/// Eq. 4 and 5 for a block: friction that stops the slip, else that of the friction cone.
#include "sim/block/visit.h"

namespace sim {
namespace {

/// Puts new friction impulses in place. Returns what that changes of (u_n, w_1, w_2).
template <int N>
LANES_INLINE Real3 Visit<N>::add_friction(const Real3& held, const Real* new_1, const Real* new_2) {
    for (int k = 0; k < N; ++k) {
        p_1[k] = new_1[k];
        p_2[k] = new_2[k];
    }
    const Real3 added = friction_wrench() - held;
    Twist d;
    d.u = {w(0, 0) * added.x + w(0, 1) * added.y + w(0, 5) * added.z,
           w(1, 0) * added.x + w(1, 1) * added.y + w(1, 5) * added.z,
           w(2, 0) * added.x + w(2, 1) * added.y + w(2, 5) * added.z};
    d.w = {w(3, 0) * added.x + w(3, 1) * added.y + w(3, 5) * added.z,
           w(4, 0) * added.x + w(4, 1) * added.y + w(4, 5) * added.z,
           w(5, 0) * added.x + w(5, 1) * added.y + w(5, 5) * added.z};
    twist = {twist.u + d.u, twist.w + d.w};
    force.x += added.x;
    force.y += added.y;
    moment.z += added.z;
    Real square = real(0.0);
    for (int k = 0; k < N; ++k) {
        const Real u1 = d.u.x - d.w.z * y[k];
        const Real u2 = d.u.y + d.w.z * x[k];
        square = max(square, u1 * u1 + u2 * u2);
    }
    change = max(change, sqrt(square));
    for (int k = 0; k < N; ++k) {
        left = max(left, abs(normal_velocity(k, d)));
    }
    return {d.u.z, d.w.x, d.w.y};
}

/// Friction impulses that stop the slip of all loaded points: weighted mean slip, and turning about the pressure centre.
/// Returns the lanes in which none is beyond its limit. sum: of the normal impulses.
template <int N>
LANES_INLINE Mask Visit<N>::stop_slip(const Real3& held, Real sum, Real per_load, Real* new_1, Real* new_2) const {
    const Real zero = real(0.0);
    if constexpr (N == 1) { // it lies at the block's centre
        const Real u1 = twist.u.x - load(points[0].u_t_target[0]);
        const Real u2 = twist.u.y - load(points[0].u_t_target[1]);
        const Real per = 1.0 / (w(0, 0) * w(1, 1) - w(0, 1) * w(0, 1));
        new_1[0] = p_1[0] - per * (w(1, 1) * u1 - w(0, 1) * u2);
        new_2[0] = p_2[0] - per * (w(0, 0) * u2 - w(0, 1) * u1);
        const Real radius = load(batch.mu) * p_n[0];
        return new_1[0] * new_1[0] + new_2[0] * new_2[0] <= radius * radius;
    }
    Real cx = zero;
    Real cy = zero;
    for (int k = 0; k < N; ++k) {
        cx += p_n[k] * x[k];
        cy += p_n[k] * y[k];
    }
    cx *= per_load;
    cy *= per_load;
    Real slip1 = zero;
    Real slip2 = zero;
    Real inertia = zero;
    Real turning = zero;
    for (int k = 0; k < N; ++k) {
        const Real ax = x[k] - cx;
        const Real ay = y[k] - cy;
        const Real u1 = twist.u.x - twist.w.z * y[k] - load(points[k].u_t_target[0]);
        const Real u2 = twist.u.y + twist.w.z * x[k] - load(points[k].u_t_target[1]);
        slip1 += p_n[k] * u1;
        slip2 += p_n[k] * u2;
        inertia += p_n[k] * (ax * ax + ay * ay);
        turning += p_n[k] * (ax * u2 - ay * u1);
    }
    slip1 *= per_load;
    slip2 *= per_load;
    const Mask turns = inertia > (collinear * collinear) * (sum * (cx * cx + cy * cy) + inertia);
    const Real per_inertia = 1.0 / select(turns, inertia, real(1.0));
    // Response of (u_1, u_2 at the pressure centre, w_n) to (P_1, P_2, L_n about it).
    const Real w55 = w(5, 5);
    const Real k02 = w(0, 5) - cy * w55;
    const Real k12 = w(1, 5) + cx * w55;
    Sym3 a{w(0, 0) - cy * (w(0, 5) + k02), w(0, 1) + cx * w(0, 5) - cy * k12, k02,
           w(1, 1) + cx * (w(1, 5) + k12), k12, w55};
    a.xz = select(turns, a.xz, zero);
    a.yz = select(turns, a.yz, zero);
    a.zz = select(turns, a.zz, a.xx);
    const Real3 stop = solve(a, Real3{slip1, slip2, select(turns, turning * per_inertia, zero)});
    const Real share1 = (held.x - stop.x) * per_load;
    const Real share2 = (held.y - stop.y) * per_load;
    const Real twisting = select(turns, (held.z - cx * held.y + cy * held.x - stop.z) * per_inertia, zero);
    const Real mu = load(batch.mu);
    Mask sticks = sum >= 0.0;
    for (int k = 0; k < N; ++k) {
        new_1[k] = p_n[k] * (share1 - twisting * (y[k] - cy));
        new_2[k] = p_n[k] * (share2 + twisting * (x[k] - cx));
        const Real radius = mu * p_n[k];
        sticks &= new_1[k] * new_1[k] + new_2[k] * new_2[k] <= radius * radius;
    }
    return sticks;
}

/// One projection onto the friction cone in the lanes `slides`: at each point a disc of radius mu p_n.
template <int N>
LANES_INLINE void Visit<N>::slide(Mask slides, Real per_load, Real* new_1, Real* new_2) const {
    const Real zero = real(0.0);
    const Real one = real(1.0);
    const Real mu = load(batch.mu);
    const Real weight = load(batch.node_weight);
    const Mask marked = lanes_of(batch.sticking);
    const Real per_k_load = load(batch.per_k_t) * per_load;
    const Real3 start = load3(batch.before);
    Real kept[N]; // share of its friction that a point still holds; the rest goes with the load to the others
    Real left1 = zero;
    Real left2 = zero;
    for (int k = 0; k < N; ++k) {
        const Real limit = mu * p_n[k];
        const Real square = p_1[k] * p_1[k] + p_2[k] * p_2[k];
        const Mask beyond = square > limit * limit;
        kept[k] = select(beyond, limit * limit / select(beyond, square, one), one);
        left1 += (1.0 - kept[k]) * p_1[k];
        left2 += (1.0 - kept[k]) * p_2[k];
    }
    for (int k = 0; k < N; ++k) {
        const Mask carries = p_n[k] > 0.0;
        const Real held1 = kept[k] * p_1[k] + p_n[k] * per_load * left1;
        const Real held2 = kept[k] * p_2[k] + p_n[k] * per_load * left2;
        const Real u1 = twist.u.x - twist.w.z * y[k];
        const Real u2 = twist.u.y + twist.w.z * x[k];
        const Real s1 = u1 - load(points[k].u_t_target[0]);
        const Real s2 = u2 - load(points[k].u_t_target[1]);
        // The sliding direction at t0, between the velocities before and after the impulses; nearer to stopping
        // in this step, its slip tells the direction.
        const Real before1 = start.x - start.z * y[k];
        const Real before2 = start.y + start.z * x[k];
        const Real at1 = before1 + weight * (u1 - before1);
        const Real at2 = before2 + weight * (u2 - before2);
        const Real o1 = at1 - s1;
        const Real o2 = at2 - s2;
        const Real stopped = o1 * o1 + o2 * o2;
        const Real moving = s1 * s1 + s2 * s2;
        const Mask by_slip = marked | (stopped == 0.0);
        // All times moving + stopped: of q only the direction counts.
        const Real of_slip = select(by_slip, one, moving + stopped);
        const Real of_before = select(by_slip, zero, moving);
        const Real v1 = of_slip * s1 + of_before * o1;
        const Real v2 = of_slip * s2 + of_before * o2;
        const Real per_k = p_n[k] * per_k_load; // 1 / (k_t load / p_n)
        const Real radius = mu * p_n[k];
        const Real stop1 = held1 - s1 * per_k;
        const Real stop2 = held2 - s2 * per_k;
        const Mask holds = stop1 * stop1 + stop2 * stop2 <= radius * radius;
        const Real q1 = of_slip * held1 - v1 * per_k;
        const Real q2 = of_slip * held2 - v2 * per_k;
        const Real square = q1 * q1 + q2 * q2;
        const Mask moves = square > 0.0;
        const Real scale = select(moves, radius / sqrt(select(moves, square, one)), zero);
        new_1[k] = select(slides, select(carries, select(holds, stop1, q1 * scale), zero), new_1[k]);
        new_2[k] = select(slides, select(carries, select(holds, stop2, q2 * scale), zero), new_2[k]);
    }
}

/// Under-relaxation of the visit [-]. Friction that slides follows the load: it changes the normal velocities by r times what the new
/// normal impulses did. Of these the next visit takes r times as much away again, and from r = 1 on visits take turns for ever, at a
/// single contact too. A linear iteration by the factor -r stands still where 1 / (1 + r) of the change is taken: returned where
/// r > 1, else 1. by_friction: changes of (u_n, w_1, w_2). What follows the load counts, mu times its change at most.
template <int N>
LANES_INLINE Real Visit<N>::share_that_lasts(Mask slides, const Real3& by_friction) const {
    const Real one = real(1.0);
    const Real3 loaded{force.z, moment.x, moment.y};
    const Real by_load = dot(loaded, normal_response(batch, *this) * loaded);
    const Real beside_it = dot(loaded, by_friction);
    const Mask may_diverge = slides & (beside_it > by_load);
    if (!any(may_diverge)) {
        return one;
    }
    const Real limit = load(batch.mu) * force.z;
    const Real square = force.x * force.x + force.y * force.y;
    const Mask beyond = square > limit * limit;
    const Real follows = beside_it * select(beyond, sqrt(limit * limit / select(beyond, square, one)), one);
    const Mask diverges = may_diverge & (follows > by_load);
    return select(diverges, by_load / select(diverges, by_load + follows, one), one);
}

/// Friction impulses for the present normal impulses (eq. 4 and 5 for the block).
template <int N>
LANES_INLINE void Visit<N>::solve_friction() {
    const Real zero = real(0.0);
    Real sum = zero;
    for (int k = 0; k < N; ++k) {
        sum += p_n[k];
    }
    const Mask loaded = sum > 0.0;
    Real new_1[N];
    Real new_2[N];
    const Real per_load = 1.0 / select(loaded, sum, real(1.0));
    const Real3 held = friction_wrench();
    const Mask sticks = stop_slip(held, sum, per_load, new_1, new_2);
    for (int k = 0; k < N; ++k) {
        new_1[k] = select(loaded, new_1[k], zero);
        new_2[k] = select(loaded, new_2[k], zero);
    }
    const Mask slides = due & loaded & ~sticks;
    if (any(slides)) {
        slide(slides, per_load, new_1, new_2);
    }
    const Real3 by_friction = add_friction(held, new_1, new_2);
    share = share_that_lasts(slides, by_friction);
    left = select(slides, change, left);
}

} // namespace
} // namespace sim
