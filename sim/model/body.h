#pragma once
/// A rigid body, split by how often it changes: properties fixed after load, and the state of every step.
#include "sim/base/math.h"
#include "sim/model/shape.h"

namespace sim {

/// Which moments of inertia are equal decides how a body turns freely (integrate.h).
enum class InertiaKind { spherical, symmetric, asymmetric };

/// Fixed after load, but that a body which waits has no mass yet. A static or kinematic body has inverse mass and inverse
/// inertia zero.
struct BodyProps {
    double inverse_mass = 0.0;                     ///< [1/kg]
    Vec3 principal_inertia = Vec3::Zero();         ///< [kg m^2]; symmetric: z is the axis of symmetry
    Vec3 inverse_principal_inertia = Vec3::Zero(); ///< [1/(kg m^2)]
    Quat body_from_principal = Quat::Identity();   ///< principal axes in the body frame
    InertiaKind inertia_kind = InertiaKind::spherical;
    double bounding_radius = 0.0; ///< [m] about the centre of mass; infinite for a plane
    double restitution = -1.0;    ///< e [-]; < 0: the partner's
    double mu_s = -1.0;           ///< [-]; < 0: the partner's
    double mu_d = -1.0;           ///< [-]; < 0: the partner's
    bool is_kinematic = false;    ///< moved by keys (motion.h)
    bool is_led = false;          ///< kinematic, or joints connect it with one that is
    bool is_waiting = false;      ///< to be released: until then nothing meets it, and nothing moves it
    Shape shape;

    bool is_static() const { return inverse_mass == 0.0; }           ///< no force moves it
    bool is_fixed() const { return is_static() && !is_kinematic; }   ///< and no key
};

/// Linear and angular velocity, world frame.
/// A row of 64 bytes: block_kernel.cpp reads eight of them at a time.
struct alignas(64) Velocity {
    Vec3 v = Vec3::Zero(); ///< of the centre of mass [m/s]
    Vec3 w = Vec3::Zero(); ///< [rad/s]

    /// Velocity of a point at r = x - c.
    Vec3 at(const Vec3& r) const { return v + w.cross(r); }
};

/// from + s (to - from).
inline Velocity between(const Velocity& from, const Velocity& to, double s) {
    return {from.v + s * (to.v - from.v), from.w + s * (to.w - from.w)};
}

/// Largest velocity [m/s] that the body's rotation gives a point of it.
inline double rim_speed(const BodyProps& props, const Velocity& velocity) {
    const double turn = velocity.w.norm();
    return turn > 0.0 ? turn * props.bounding_radius : 0.0;
}

/// J^-1 in the world frame [1/(kg m^2)].
inline Mat3 inverse_inertia_world(const BodyProps& props, const Quat& orientation) {
    if (props.inertia_kind == InertiaKind::spherical) {
        return props.inverse_principal_inertia.x() * Mat3::Identity();
    }
    const Mat3 r = (orientation * props.body_from_principal).toRotationMatrix();
    return r * props.inverse_principal_inertia.asDiagonal() * r.transpose();
}

/// J w in the world frame [kg m^2/s].
inline Vec3 angular_momentum(const BodyProps& props, const Quat& orientation, const Vec3& w) {
    if (props.inertia_kind == InertiaKind::spherical) {
        return props.principal_inertia.x() * w;
    }
    const Quat world_from_principal = orientation * props.body_from_principal;
    const Vec3 w_principal = world_from_principal.conjugate() * w;
    return world_from_principal * props.principal_inertia.cwiseProduct(w_principal);
}

/// Kinetic energy [J] of a body that is not static.
inline double kinetic_energy(const BodyProps& props, const Quat& orientation, const Velocity& velocity) {
    return 0.5 * (velocity.v.squaredNorm() / props.inverse_mass +
                  velocity.w.dot(angular_momentum(props, orientation, velocity.w)));
}

} // namespace sim
