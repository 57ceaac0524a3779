#pragma once
/// One block in each lane, solved with all others held: eq. 1 to 3 for all points of the block at once in normals.h, 4 and 5 in
/// friction.h. Included by block_kernel.cpp only, once for each instruction set.
#include "sim/block/lane_twist.h"

namespace sim {
namespace {

constexpr double infinity = __builtin_inf();

/// Lanes of a batch while they are solved.
template <int N>
struct Visit : Window {
    const BlockBatch& batch;
    BatchPoint* points;
    Real x[N], y[N];
    LANES_INLINE Visit(const BlockBatch& of, BatchPoint* at, int first_lane) : Window{first_lane}, batch(of), points(at) {
        for (int k = 0; k < N; ++k) {
            x[k] = load(points[k].x);
            y[k] = load(points[k].y);
        }
    }
    Real p_n[N], p_1[N], p_2[N];
    Twist twist;
    Mask due;            ///< lanes that are to be solved
    Real3 force, moment; ///< wrench added so far, in the block's frame
    Real change;         ///< largest velocity change at a point [m/s]
    Real share;          ///< [-] of what the visit finds that is taken: see share_that_lasts()
    Real left;           ///< what the visit may leave of it: friction moves what normal impulses have solved, and is projected once [m/s]

    LANES_INLINE Real w(int i, int j) const {
        return i >= j ? load(batch.response[i * (i + 1) / 2 + j]) : load(batch.response[j * (j + 1) / 2 + i]);
    }
    LANES_INLINE Real normal_velocity(int k, const Twist& t) const { return t.normal(x[k], y[k]); }

    /// (P_n, L_1, L_2) of normal impulses.
    LANES_INLINE Real3 normal_wrench(const Real* p) const {
        Real3 sum{p[0], p[0] * y[0], -p[0] * x[0]};
        for (int k = 1; k < N; ++k) {
            sum = sum + Real3{p[k], p[k] * y[k], -p[k] * x[k]};
        }
        return sum;
    }
    /// (P_1, P_2, L_n) of friction impulses.
    LANES_INLINE Real3 friction_wrench() const {
        Real3 sum{p_1[0], p_2[0], x[0] * p_2[0] - y[0] * p_1[0]};
        for (int k = 1; k < N; ++k) {
            sum = sum + Real3{p_1[k], p_2[k], x[k] * p_2[k] - y[k] * p_1[k]};
        }
        return sum;
    }

    /// Of the velocities of a twist at the points [m^2/s^2].
    LANES_INLINE Real largest_square(const Twist& t) const {
        Real largest = real(0.0);
        for (int k = 0; k < N; ++k) {
            const Real3 u{t.tangential1(y[k]), t.tangential2(x[k]), t.normal(x[k], y[k])};
            largest = max(largest, dot(u, u));
        }
        return largest;
    }
    void solve_normals(Real slack, Real softness);
    void iterate_normals(const Sym3& wn, Mask open, const Real* excess, Real* impulse) const;
    void add_normals(const Sym3& wn, const Real3& held, const Real* impulse);
    void solve_friction();
    Mask stop_slip(const Real3& held, Real sum, Real per_load, Real* new_1, Real* new_2) const;
    void slide(Mask slides, Real per_load, Real* new_1, Real* new_2) const;
    Real share_that_lasts(Mask slides, const Real3& by_friction) const;
    Real3 add_friction(const Real3& held, const Real* new_1, const Real* new_2);
};

} // namespace
} // namespace sim
