#pragma once
/// Independent integration of a top of revolution with a round bowl and a round stem on a rough floor: six
/// degrees of freedom, normal forces from the constraints, Coulomb friction. Shares no code with sim/.
///
/// Equations. k: unit axis from the bowl to the stem; L: angular momentum about the centre of mass c; A, C:
/// transverse and axial moments. The top is a body of revolution, so its turn about k does not matter and
///   dk/dt = L x k / A,   dL/dt = sum r_j x F_j,   m dv/dt = sum F_j - m g z,   w = L_perp / A + L_axial / C.
/// Contact j is a sphere of radius r_j whose centre lies at c + o_j k: its lowest point is at r_j = o_j k -
/// r_j z from c, its height is c_z + o_j k_z - r_j, and while it touches, the second derivative of that
/// height is zero. With
///   F_j = N_j (z - mu s(u_j)),   s(u) = u_t / sqrt(|u_t|^2 + eps^2),
/// this is a linear system for the normal forces N_j. eps [m/s] regularises the friction of a vanishing slip;
/// its effect is shown to vanish with it.
#include "tests/laws/reference/ode.h"

#include <Eigen/Geometry>

#include <array>
#include <limits>

namespace reference {

/// A sphere on the axis that can touch the floor.
struct TopContact {
    double offset = 0.0; ///< [m] of its centre from the centre of mass, along the axis
    double radius = 0.0; ///< [m]
};

struct Top {
    double mass = 0.0;       ///< [kg]
    double transverse = 0.0; ///< A [kg m^2]
    double axial = 0.0;      ///< C [kg m^2]
    TopContact bowl;
    TopContact stem;
    double mu = 0.0;          ///< [-]
    double gravity = 9.81;    ///< [m/s^2]
    double slip_scale = 1e-5; ///< eps [m/s]
};

/// c, v, k, L one after the other.
using TopVector = Eigen::Matrix<double, 12, 1>;

struct TopState {
    TopVector y = TopVector::Zero();
    std::array<bool, 2> touching{true, false}; ///< bowl, stem

    Eigen::Vector3d centre() const { return y.segment<3>(0); }
    Eigen::Vector3d velocity() const { return y.segment<3>(3); }
    Eigen::Vector3d axis() const { return y.segment<3>(6); }
    Eigen::Vector3d angular_momentum() const { return y.segment<3>(9); }
};

struct TopResult {
    static constexpr double never = std::numeric_limits<double>::infinity();
    double time_to_90_degrees = never;   ///< [s] the axis is horizontal for the first time
    double time_to_stem_contact = never; ///< [s]
    double time_bowl_leaves = never;     ///< [s] after the stem has touched
    double largest_jellett_error = 0.0;  ///< [-] relative, up to the stem's contact
    double largest_height_error = 0.0;   ///< [m] of the bowl's lowest point, up to the stem's contact
    double smallest_slip = never;        ///< [m/s] of the bowl, up to the stem's contact
    double smallest_axis_z = 1.0;        ///< [-] of the upward component of the axis
    TopState end;
};

/// The top on its bowl, at rest but for an angular velocity `spin` [rad/s] about the vertical, its axis
/// tilted by `tilt` [rad] in the xz plane.
TopState tilted_top(const Top& top, double spin, double tilt);

/// J = -L . (contact point of the bowl - c) [kg m^3/s]: constant while only the bowl touches, whatever the
/// friction.
double jellett(const Top& top, const TopState& state);

/// Angular velocity [rad/s], world.
Eigen::Vector3d angular_velocity(const Top& top, const TopState& state);

/// Kinetic and potential energy [J].
double energy(const Top& top, const TopState& state);

/// Integrates for `duration` [s] or, if asked, to the stem's first contact.
TopResult integrate_top(const Top& top, TopState state, double duration, bool until_stem = false,
                        const OdeSettings& settings = {});

} // namespace reference
