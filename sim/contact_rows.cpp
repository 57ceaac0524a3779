#include "sim/contact_rows.h"

#include <cmath>

namespace sim {
namespace {

/// A sliding velocity at t0 below this share [-] of the step's slip counts as zero: the sliding begins there.
constexpr double onset_share = 1e-3;

double combined(double x, double y) {
    if (x < 0.0 || y < 0.0) {
        return std::max({x, y, 0.0});
    }
    return std::sqrt(x * y);
}

/// A unit vector across n: from the world axis that is least along n, so it turns continuously with n.
Vec3 tangent_of(const Vec3& n) {
    int axis = 0;
    n.cwiseAbs().minCoeff(&axis);
    return n.cross(Vec3::Unit(axis)).normalized();
}

Direction make_direction(const Bodies& bodies, int a, int b, const Vec3& axis, const Vec3& r_a,
                         const Vec3& r_b) {
    Direction d;
    d.axis = axis;
    d.arm_a = r_a.cross(axis);
    d.arm_b = r_b.cross(axis);
    d.turn_a = bodies.inverse_inertia[static_cast<std::size_t>(a)] * d.arm_a;
    d.turn_b = bodies.inverse_inertia[static_cast<std::size_t>(b)] * d.arm_b;
    return d;
}

/// x^T K y for two directions of one contact [1/kg].
double coupling(const ContactRow& row, const Direction& x, const Direction& y) {
    return (row.inverse_mass_a + row.inverse_mass_b) * x.axis.dot(y.axis) + x.arm_a.dot(y.turn_a) +
           x.arm_b.dot(y.turn_b);
}

/// Friction matrix K_tt of a row from its directions: its inverse and its largest eigenvalue.
void set_response(ContactRow& row) {
    row.n_K_n = coupling(row, row.direction[0], row.direction[0]);
    if (!row.has_friction()) {
        return;
    }
    Mat2 K_tt;
    K_tt(0, 0) = coupling(row, row.direction[1], row.direction[1]);
    K_tt(1, 1) = coupling(row, row.direction[2], row.direction[2]);
    K_tt(0, 1) = K_tt(1, 0) = coupling(row, row.direction[1], row.direction[2]);
    row.K_tt_inverse = K_tt.inverse();
    const double half_trace = 0.5 * K_tt.trace();
    row.k_t = half_trace + std::sqrt(std::max(half_trace * half_trace - K_tt.determinant(), 0.0));
}

} // namespace

PairMaterial pair_material(const BodyProps& a, const BodyProps& b) {
    return {combined(a.restitution, b.restitution), combined(a.mu_s, b.mu_s), combined(a.mu_d, b.mu_d)};
}

ContactRow make_row(const Bodies& bodies, int a, int b, const ContactGeometry& at,
                    const PairMaterial& material) {
    const auto ia = static_cast<std::size_t>(a);
    const auto ib = static_cast<std::size_t>(b);
    ContactRow row;
    row.a = a;
    row.b = b;
    row.inverse_mass_a = bodies.props[ia].inverse_mass;
    row.inverse_mass_b = bodies.props[ib].inverse_mass;
    row.mu_s = material.mu_s;
    row.mu_d = material.mu_d;
    const Vec3 r_a = at.a - bodies.pose[ia].position;
    const Vec3 r_b = at.b - bodies.pose[ib].position;
    row.direction[0] = make_direction(bodies, a, b, at.n, r_a, r_b);
    if (row.has_friction()) {
        const Vec3 t = tangent_of(at.n);
        row.direction[1] = make_direction(bodies, a, b, t, r_a, r_b);
        row.direction[2] = make_direction(bodies, a, b, at.n.cross(t), r_a, r_b);
    }
    set_response(row);
    return row;
}

void apply_sums(const ContactRow& row, std::span<Velocity> velocity) {
    if (row.p_n == 0.0) {
        return;
    }
    apply(row, row.direction[0], row.p_n, velocity);
    if (row.has_friction()) {
        apply(row, row.direction[1], row.p_t.x(), velocity);
        apply(row, row.direction[2], row.p_t.y(), velocity);
    }
}

double iterate(ContactRow& row, std::span<Velocity> velocity) {
    const double u_n = normal_velocity(row, velocity);
    const double p_n = clamped_sum(row.p_n, normal_impulse(u_n, row.u_n_target, row.n_K_n));
    double change = std::abs(p_n - row.p_n) * row.n_K_n;
    if (p_n != row.p_n) {
        apply(row, row.direction[0], p_n - row.p_n, velocity);
        row.p_n = p_n;
    }
    if (!row.has_friction() || (p_n == 0.0 && row.p_t.isZero(0.0))) {
        return change;
    }
    const Vec2 u_t = tangential_velocity(row, velocity);
    const Vec2 slip = u_t - row.u_t_target;
    Vec2 p_t = stopping_sum(row.p_t, slip, row.K_tt_inverse);
    const double mu = row.is_sticking ? row.mu_s : row.mu_d;
    if (!can_stick(p_t, p_n, mu)) {
        // A marked contact at its limit still holds against the slip of this step; a sliding one acts against
        // the sliding velocity at t0, between those before and after the impulses: its direction stays second
        // order. Where sliding begins at t0 that velocity is zero, and the slip of the step tells the
        // direction.
        const Vec2 u_t0 = row.u_t_before + row.node_weight * (u_t - row.u_t_before);
        const bool begins = u_t0.squaredNorm() < onset_share * onset_share * slip.squaredNorm();
        const Vec2 u_sliding = row.is_sticking || begins ? slip : u_t0;
        p_t = sliding_sum(row.p_t, u_sliding, row.k_t, mu * p_n);
    }
    const Vec2 dp = p_t - row.p_t;
    change = std::max(change, dp.norm() * row.k_t);
    apply(row, row.direction[1], dp.x(), velocity);
    apply(row, row.direction[2], dp.y(), velocity);
    row.p_t = p_t;
    return change;
}

double iterate_with_immovable(ContactRow& row, std::span<Velocity> velocity, bool hold_a, bool hold_b) {
    ContactRow held = row;
    for (Direction& d : held.direction) {
        if (hold_a) {
            d.turn_a.setZero();
        }
        if (hold_b) {
            d.turn_b.setZero();
        }
    }
    held.inverse_mass_a = hold_a ? 0.0 : row.inverse_mass_a;
    held.inverse_mass_b = hold_b ? 0.0 : row.inverse_mass_b;
    set_response(held);
    const double change = iterate(held, velocity);
    row.p_n = held.p_n;
    row.p_t = held.p_t;
    return change;
}

double sweep(std::span<ContactRow> rows, std::span<Velocity> velocity) {
    double change = 0.0;
    for (ContactRow& row : rows) {
        change = std::max(change, iterate(row, velocity));
    }
    return change;
}

} // namespace sim
