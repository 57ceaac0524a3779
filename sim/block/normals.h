#pragma once
/// Eq. 1 to 3 for a block: non-negative normal impulses, by the active set of its points.
#include "sim/block/visit.h"

namespace sim {
namespace {

/// Rounds of the search for the set of loaded points, beside one a point; lanes that have not come to an end then, or
/// come back to the set of two rounds before, are iterated point by point, as many rounds.
constexpr int set_rounds = 5;

/// A symmetric 2x2 matrix.
struct Gram {
    Real m11, m12, m22;
};

/// Directions (y, -x) in which the rows of a block's points spread about their centroid, and the inverse of their Gram matrix
/// m there. Points that span a plane: the axes; points on a line: along it, of any length; one point: none.
struct RowBasis {
    Mask spread, plane;
    Real d1, d2;        ///< the first direction; the second one is the second axis
    Real g11, g12, g22; ///< of the directions that there are, else 0; a line's times the square of its direction

    /// n: points [-] whose centroid is (cx, cy).
    LANES_INLINE RowBasis(Real n, Real cx, Real cy, const Gram& m) {
        const auto& [m11, m12, m22] = m;
        const Real trace = m11 + m22;
        const Real extent = n * (cx * cx + cy * cy) + trace;
        const Real zero = real(0.0);
        const Real one = real(1.0);
        spread = trace > (collinear * collinear) * extent;
        const Real determinant = m11 * m22 - m12 * m12;
        plane = spread & (determinant > collinear * (trace * trace));
        const Mask line = spread & ~plane;
        d1 = one;
        d2 = zero;
        Real along = one;  // square of the direction of a line
        Real square = one; // sum of the squares of the rows along it
        if (any(line)) {
            const Mask first_larger = m11 >= m22;
            d1 = select(line, select(first_larger, m11, m12), one);
            d2 = select(line, select(first_larger, m12, m22), zero);
            along = d1 * d1 + d2 * d2;
            square = select(line, d1 * (m11 * d1 + m12 * d2) + d2 * (m12 * d1 + m22 * d2), one);
        }
        const Real per = 1.0 / select(plane, determinant, square);
        g11 = select(plane, m22 * per, select(line, along * per, zero));
        g12 = select(plane, -m12 * per, zero);
        g22 = select(plane, m11 * per, zero);
    }

    /// The response about the centroid, whose row is (1, cy, -cx), in these directions; 1 where there is none.
    LANES_INLINE Sym3 response(const Sym3& w, Real cx, Real cy) const {
        const Real zero = real(0.0);
        const Real w0 = w.xx + cy * w.xy - cx * w.xz;
        const Real w1 = w.xy + cy * w.yy - cx * w.yz;
        const Real w2 = w.xz + cy * w.yz - cx * w.zz;
        const Real yz = d1 * w.yz + d2 * w.zz;
        Sym3 a{w0 + cy * w1 - cx * w2, d1 * w1 + d2 * w2, w2, d1 * (d1 * w.yy + d2 * w.yz) + d2 * yz, yz, w.zz};
        a.xy = select(spread, a.xy, zero);
        a.yy = select(spread, a.yy, a.xx);
        a.xz = select(plane, a.xz, zero);
        a.yz = select(plane, a.yz, zero);
        a.zz = select(plane, a.zz, a.xx);
        return a;
    }
};

/// Least-squares normal impulses of the points with active[k] = 1 (else 0) that bring their velocities to their
/// targets: smallest where the points are redundant, also when they lie on a line or are one. `excess`: velocity
/// above target without these impulses. w: response of (u_n, w_1, w_2) to (P_n, L_1, L_2).
template <int N>
LANES_INLINE void fit_impulses(const Visit<N>& v, const Sym3& w, const Real* active, const Real* excess, Real* impulse) {
    Real n = real(0.0);
    Real sx = real(0.0);
    Real sy = real(0.0);
    Real mean = real(0.0);
    for (int k = 0; k < N; ++k) {
        n += active[k];
        sx += active[k] * v.x[k];
        sy += active[k] * v.y[k];
        mean += active[k] * excess[k];
    }
    Real per = real(1.0); // 1 / n, without a division
    for (int k = 2; k <= N; ++k) {
        per = select(n > k - 0.5, real(1.0 / k), per);
    }
    const Real cx = sx * per;
    const Real cy = sy * per;
    mean *= per;
    // Second moments about the centroid of the rows' (y, -x), and slopes of the excess along them.
    Real m11 = real(0.0);
    Real m12 = real(0.0);
    Real m22 = real(0.0);
    Real f1 = real(0.0);
    Real f2 = real(0.0);
    for (int k = 0; k < N; ++k) {
        const Real r1 = v.y[k] - cy;
        const Real r2 = cx - v.x[k];
        m11 += active[k] * (r1 * r1);
        m12 += active[k] * (r1 * r2);
        m22 += active[k] * (r2 * r2);
        f1 += active[k] * (excess[k] * r1);
        f2 += active[k] * (excess[k] * r2);
    }
    const RowBasis basis(n, cx, cy, {m11, m12, m22});
    const Real e1 = basis.d1 * f1 + basis.d2 * f2;
    const Real s1 = basis.g11 * e1 + basis.g12 * f2;
    const Real s2 = basis.g12 * e1 + basis.g22 * f2;
    const Real3 wrench = solve(basis.response(w, cx, cy), Real3{-mean, -s1, -s2});
    const Real force = wrench.x * per;
    const Real t1 = basis.g11 * wrench.y + basis.g12 * wrench.z;
    const Real t2 = basis.g12 * wrench.y + basis.g22 * wrench.z;
    const Real h1 = basis.d1 * t1;
    const Real h2 = basis.d2 * t1 + t2;
    for (int k = 0; k < N; ++k) {
        impulse[k] = active[k] * (force + h1 * (v.y[k] - cy) + h2 * (cx - v.x[k]));
    }
}

/// The same for the lanes `open` point by point, from the present impulses.
template <int N>
LANES_INLINE void Visit<N>::iterate_normals(const Sym3& wn, Mask open, const Real* excess, Real* impulse) const {
    const Real one = real(1.0);
    const Real zero = real(0.0);
    for (int k = 0; k < N; ++k) {
        impulse[k] = select(open, p_n[k], impulse[k]);
    }
    Real3 now = wn * normal_wrench(impulse);
    Real per_response[N];
    for (int k = 0; k < N; ++k) {
        const Real3 row{one, y[k], -x[k]};
        per_response[k] = 1.0 / dot(row, wn * row);
    }
    for (int round = 0; round < set_rounds; ++round) {
        for (int k = 0; k < N; ++k) {
            const Real3 row{one, y[k], -x[k]};
            const Real3 response = wn * row;
            const Real next = max(impulse[k] - (excess[k] + dot(row, now)) * per_response[k], zero);
            const Real step = select(open, next - impulse[k], zero);
            now = now + step * response;
            impulse[k] = impulse[k] + step;
        }
    }
}

/// Puts new normal impulses in place.
template <int N>
LANES_INLINE void Visit<N>::add_normals(const Sym3& wn, const Real3& held, const Real* impulse) {
    const Real3 added = normal_wrench(impulse) - held;
    force.z = added.x;
    moment.x = added.y;
    moment.y = added.z;
    Twist d;
    d.u = {w(0, 2) * added.x + w(0, 3) * added.y + w(0, 4) * added.z,
           w(1, 2) * added.x + w(1, 3) * added.y + w(1, 4) * added.z, real(0.0)};
    const Real3 dn = wn * added;
    d.u.z = dn.x;
    d.w = {dn.y, dn.z, w(5, 2) * added.x + w(5, 3) * added.y + w(5, 4) * added.z};
    twist = {twist.u + d.u, twist.w + d.w};
    for (int k = 0; k < N; ++k) {
        change = max(change, abs(normal_velocity(k, d)));
        p_n[k] = impulse[k];
    }
}

/// What impulses `found` for the points with active[k] = 1 do: to all points' velocities above their targets.
template <int N>
struct SetTrial {
    Real u[N];
    Real least;                     ///< of the impulses
    Real lowest = real(infinity);   ///< of the worst free point
    Real highest = real(-infinity); ///< of a loaded point above its target
    Real miss = real(0.0);          ///< of the loaded points, the largest

    /// change: of (u_n, w_1, w_2) by these impulses.
    LANES_INLINE SetTrial(const Visit<N>& v, const Real3& change, const Real* active, const Real* excess, const Real* found)
        : least(found[0]) {
        for (int k = 0; k < N; ++k) {
            u[k] = excess[k] + change.x + change.y * v.y[k] - change.z * v.x[k];
            const Mask in = active[k] > 0.5;
            least = min(least, found[k]);
            const Mask below = u[k] < -rounding_share * abs(excess[k]);
            lowest = select(~in & below, min(lowest, u[k]), lowest);
            highest = select(in, max(highest, u[k]), highest);
            miss = select(in, max(miss, abs(u[k])), miss);
        }
    }

    /// One point changes: the first that is the extreme one. Returns the lanes in which none has to.
    LANES_INLINE Mask exchange(Mask open, Real slack, const Real* found, Real* active) const {
        const Mask drop_pulling = least < 0.0;
        const Mask add = ~drop_pulling & (lowest < 0.0);
        const Mask drop_high = ~drop_pulling & ~add & (miss > slack); // also of two at one place
        Mask changed = ~open;
        for (int k = 0; k < N; ++k) {
            const Mask in = active[k] > 0.5;
            const Mask out = in & ~changed & ((drop_pulling & (found[k] == least)) | (drop_high & (u[k] == highest)));
            const Mask enter = ~in & ~changed & add & (u[k] == lowest);
            active[k] = select(out, real(0.0), select(enter, real(1.0), active[k]));
            changed |= out | enter;
        }
        return open & ~drop_pulling & ~add & ~drop_high;
    }
};

/// Non-negative normal impulses with velocities at or above their targets (eq. 1-3 for the block), less what softness [-] times
/// their response gives.
template <int N>
LANES_INLINE void Visit<N>::solve_normals(Real slack, Real softness) {
    const Sym3 wn = normal_response(batch, *this);
    const Sym3 soft = (1.0 + softness) * wn;
    const Real3 held = normal_wrench(p_n);
    const Real3 lifted = wn * held;
    Real excess[N];
    Real active[N];
    Real approaching[N];
    Mask loaded = p_n[0] > 0.0;
    Mask work = loaded & ~loaded;
    const Real one = real(1.0);
    const Real zero = real(0.0);
    for (int k = 0; k < N; ++k) {
        excess[k] = normal_velocity(k, twist) - (lifted.x + lifted.y * y[k] - lifted.z * x[k]) - load(points[k].u_n_target);
        slack = max(slack, select(lanes_of(points[k].there), same_share * abs(excess[k]), zero)); // the targets agree so far
        active[k] = select(p_n[k] > 0.0, one, zero);
        approaching[k] = select(excess[k] < 0.0, one, zero);
        loaded |= p_n[k] > 0.0;
        work |= excess[k] < 0.0;
    }
    work |= loaded;
    for (int k = 0; k < N; ++k) {
        active[k] = select(loaded, active[k], approaching[k]);
    }
    Real impulse[N];
    if constexpr (N == 1) { // it lies at the block's centre, and nothing is to be shared
        impulse[0] = max(-excess[0] / soft.xx, zero);
        add_normals(wn, held, impulse);
        return;
    }
    for (int k = 0; k < N; ++k) {
        impulse[k] = zero;
    }
    Mask open = work & due;
    Mask circling = ~work & work;
    Real set_before = real(-1.0); // the points as bits
    Real set = real(-1.0);
    Real found[N];
    for (int round = 0; round < set_rounds + N && any(open); ++round) {
        fit_impulses<N>(*this, soft, active, excess, found);
        const SetTrial<N> trial(*this, soft * normal_wrench(found), active, excess, found);
        const Mask done = trial.exchange(open, slack, found, active);
        for (int k = 0; k < N; ++k) {
            impulse[k] = select(done, found[k], impulse[k]);
        }
        open &= ~done;
        Real next_set = zero;
        for (int k = 0; k < N; ++k) {
            next_set += static_cast<double>(1 << k) * active[k];
        }
        circling |= open & (next_set == set_before);
        open &= ~circling;
        set_before = set;
        set = next_set;
    }
    open |= circling;
    if (any(open)) {
        iterate_normals(soft, open, excess, impulse);
    }
    add_normals(wn, held, impulse);
}

} // namespace
} // namespace sim
