#pragma once
/// Vectors, matrices and quaternions of the simulation, and the project's table of symbols.
///
/// Symbols (Bender & Schmitt 2006, the paper's letters are kept in the code):
///   m, J          mass [kg], inertia tensor about the centre of mass [kg m^2]
///   c, v          centre of mass [m], its velocity [m/s]
///   q, w          orientation (unit quaternion, world_from_body), angular velocity [rad/s], world frame
///   a, b          contact point on the first and on the second body of a pair [m]
///   n             unit contact normal, from b to a
///   gap           distance of the bodies along n [m], > 0 apart; penetration = -gap
///   u_rel         u_a - u_b, relative velocity of the contact points [m/s]; u_n along n, u_t across it
///   K             dv/dp at a contact [1/kg]; K = K_aa + K_bb
///   p_n, p_t      normal impulse (>= 0), friction impulse [N s]; +p acts on a, -p on b
///   e             restitution [-];  mu_s, mu_d  static and dynamic friction coefficient [-]
///   d, d_n, d_t   gap vector a - b at t0 + h, its normal and tangential parts [m]
///   h, g          time step [s], gravity [m/s^2]
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace sim {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
/// Stored x y z w, constructed w x y z: always construct by argument.
using Quat = Eigen::Quaterniond;

/// Matrix r* with r* x = r x x (cross product matrix of Bender & Schmitt 2006, sec. 3.1).
inline Mat3 cross_matrix(const Vec3& r) {
    Mat3 m;
    m << 0, -r.z(), r.y(), r.z(), 0, -r.x(), -r.y(), r.x(), 0;
    return m;
}

/// The shortest rotation that takes the direction of `from` to that of `to`; about any axis where they are opposite.
/// Eigen's FromTwoVectors has the opposite ones by a singular value decomposition, which takes ten seconds to compile.
Quat rotation_between(const Vec3& from, const Vec3& to);

/// Rigid placement of a frame: x_world = orientation * x_body + position.
struct Pose {
    Vec3 position = Vec3::Zero();          ///< [m]
    Quat orientation = Quat::Identity();   ///< world_from_body, unit

    Vec3 operator*(const Vec3& x_body) const { return orientation * x_body + position; }
    /// This after inner.
    Pose operator*(const Pose& inner) const { return {*this * inner.position, orientation * inner.orientation}; }
};

} // namespace sim
