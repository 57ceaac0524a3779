#pragma once
/// The iteration loop that collisions and resting contacts share: one row a contact, visited in a fixed
/// order. What differs, the target velocities, is set by collision_solver and contact_solver.
#include "sim/impulse.h"
#include "sim/manifold.h"

#include <array>
#include <span>
#include <vector>

namespace sim {

/// State of all bodies at one instant, arrays of [body_count].
struct Bodies {
    std::vector<BodyProps> props;
    std::vector<Pose> pose;
    std::vector<Velocity> velocity;
    std::vector<Mat3> inverse_inertia; ///< world frame, at `pose`
};

/// One direction of a contact: its Jacobian and the velocity a unit impulse gives to the bodies.
struct Direction {
    Vec3 axis;   ///< unit, world
    Vec3 arm_a;  ///< r_a x axis [m]
    Vec3 arm_b;  ///< r_b x axis [m]
    Vec3 turn_a; ///< J_a^-1 arm_a [1/(kg m)]
    Vec3 turn_b; ///< J_b^-1 arm_b [1/(kg m)]
};

/// A contact in the loop: normal row and, with friction, two tangential ones.
struct ContactRow {
    int a = -1;
    int b = -1;
    double inverse_mass_a = 0.0;        ///< [1/kg]
    double inverse_mass_b = 0.0;        ///< [1/kg]
    std::array<Direction, 3> direction; ///< n, t_1, t_2
    double n_K_n = 0.0;                 ///< [1/kg]
    Mat2 K_tt_inverse = Mat2::Zero();   ///< [kg]
    double k_t = 0.0;                   ///< largest eigenvalue of K_tt [1/kg]
    double mu_s = 0.0;
    double mu_d = 0.0;
    double u_n_target = 0.0;        ///< [m/s]
    Vec2 u_t_target = Vec2::Zero(); ///< of a sticking contact [m/s]
    Vec2 u_t_before = Vec2::Zero(); ///< before any impulse of this solve [m/s]
    double node_weight = 0.5;       ///< share [-] of the impulses that acts before the instant t0
    double p_n = 0.0;               ///< sum of the normal impulses [N s]
    Vec2 p_t = Vec2::Zero();        ///< sum of the friction impulses [N s]
    bool is_sticking = false;       ///< the mark of eq. 6

    bool has_friction() const { return mu_s > 0.0; }
    Vec3 impulse() const {
        return p_n * direction[0].axis + p_t.x() * direction[1].axis + p_t.y() * direction[2].axis;
    }
};

/// Restitution and friction coefficients of a pair.
struct PairMaterial {
    double restitution = 0.0;
    double mu_s = 0.0;
    double mu_d = 0.0;
};
/// A value unset on one body is the partner's; set on both: geometric mean; on none: zero.
PairMaterial pair_material(const BodyProps& a, const BodyProps& b);

/// Row of a contact between bodies a and b with geometry `at` (at the poses in `bodies`). Impulses are zero,
/// targets unset.
ContactRow make_row(const Bodies& bodies, int a, int b, const ContactGeometry& at,
                    const PairMaterial& material);

/// Relative velocity along one direction of a row [m/s].
inline double relative_velocity(const ContactRow& row, const Direction& d,
                                std::span<const Velocity> velocity) {
    const Velocity& a = velocity[static_cast<std::size_t>(row.a)];
    const Velocity& b = velocity[static_cast<std::size_t>(row.b)];
    return d.axis.dot(a.v - b.v) + d.arm_a.dot(a.w) - d.arm_b.dot(b.w);
}
inline double normal_velocity(const ContactRow& row, std::span<const Velocity> velocity) {
    return relative_velocity(row, row.direction[0], velocity);
}
inline Vec2 tangential_velocity(const ContactRow& row, std::span<const Velocity> velocity) {
    return {relative_velocity(row, row.direction[1], velocity),
            relative_velocity(row, row.direction[2], velocity)};
}

/// Adds p [N s] along one direction to both bodies.
inline void apply(const ContactRow& row, const Direction& d, double p, std::span<Velocity> velocity) {
    Velocity& a = velocity[static_cast<std::size_t>(row.a)];
    Velocity& b = velocity[static_cast<std::size_t>(row.b)];
    a.v += (p * row.inverse_mass_a) * d.axis;
    a.w += p * d.turn_a;
    b.v -= (p * row.inverse_mass_b) * d.axis;
    b.w -= p * d.turn_b;
}

/// Applies the impulses a row starts with (warm start).
void apply_sums(const ContactRow& row, std::span<Velocity> velocity);

/// One iteration over one contact; returns the largest velocity change it made at the contact [m/s].
double iterate(ContactRow& row, std::span<Velocity> velocity);

/// The same with bodies held immovable (shock propagation).
double iterate_with_immovable(ContactRow& row, std::span<Velocity> velocity, bool hold_a, bool hold_b);

/// One iteration over all contacts in order; returns the largest velocity change at any of them [m/s].
double sweep(std::span<ContactRow> rows, std::span<Velocity> velocity);

} // namespace sim
