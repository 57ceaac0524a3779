#pragma once
/// The equations of one contact: what an impulse does to velocities, and the impulse one iteration applies.
/// J. Bender, A. Schmitt, "Constraint-based collision and contact handling using impulses", CASA 2006.
/// Eq. 1-6 stand here, eq. 7 is free_motion in integrate.h, eq. 8 is eq. 1 with the bias of
/// contact_solver.cpp.
#include "sim/model/body.h"

#include <Eigen/LU>

#include <algorithm>

namespace sim {

using Vec2 = Eigen::Vector2d;
using Mat2 = Eigen::Matrix2d;

/// K_xy = 1/m I - [x-c]* J^-1 [y-c]*: velocity of x by an impulse at y of the same body (sec. 3.1) [1/kg].
/// r_x, r_y: arms from the centre of mass [m]. Zero for a static body, whose inverse mass and inertia are
/// zero.
inline Mat3 response(double inverse_mass, const Mat3& inverse_inertia, const Vec3& r_x, const Vec3& r_y) {
    return inverse_mass * Mat3::Identity() - cross_matrix(r_x) * inverse_inertia * cross_matrix(r_y);
}

/// Impulse p [N s] applied at arm r [m] of a body.
inline void apply_impulse(Velocity& velocity, double inverse_mass, const Mat3& inverse_inertia, const Vec3& r,
                          const Vec3& p) {
    velocity.v += inverse_mass * p;
    velocity.w += inverse_inertia * r.cross(p);
}

/// Normal impulse that takes one contact to its target normal velocity in one iteration (eq. 1).
/// u_n, u_n_target [m/s] along n (b to a);  n_K_n [1/kg] > 0.  Returns [N s] along n.
/// With u_n_target chosen so that the predicted penetration d_n closes within h it is eq. 8.
inline double normal_impulse(double u_n, double u_n_target, double n_K_n) noexcept {
    return (u_n_target - u_n) / n_K_n;
}

/// The sum of a contact's normal impulses after one more, which may never pull (eq. 2, 3) [N s].
inline double clamped_sum(double sum, double p_n) noexcept {
    return std::max(sum + p_n, 0.0);
}

/// The friction impulse sum that stops the sliding (eq. 5, in the plane: t^T K t becomes the 2x2 matrix
/// K_tt). sum [N s], u_t [m/s], K_tt^-1 [kg].
inline Vec2 stopping_sum(const Vec2& sum, const Vec2& u_t, const Mat2& K_tt_inverse) noexcept {
    return sum - K_tt_inverse * u_t;
}

/// The friction impulse sum of a sliding contact: of length mu_d p_n, against the sliding direction (eq. 4).
/// It is the projection of sum - u_t / k_t on the disc of radius mu_d p_n, whose fixed point is exactly
/// antiparallel to u_t; friction given before therefore comes down again when a later iteration lowers p_n.
/// radius = mu_d * sum p_n [N s];  k_t [1/kg]: largest eigenvalue of K_tt.
inline Vec2 sliding_sum(const Vec2& sum, const Vec2& u_t, double k_t, double radius) noexcept {
    const Vec2 p = sum - u_t / k_t;
    const double length = p.norm();
    return length > 0.0 ? Vec2(p * (radius / length)) : Vec2(Vec2::Zero());
}

/// May the contact stick? |sum p_t| <= mu_s |sum p_n| (eq. 6).
inline bool can_stick(const Vec2& sum_t, double sum_n, double mu_s) noexcept {
    return sum_t.squaredNorm() <= mu_s * mu_s * sum_n * sum_n;
}

} // namespace sim
