#pragma once
/// Motion of a body between two sets of impulses: free flight under gravity and torque-free rotation, exact.
///
/// Impulses act at t0 and the bodies then move freely to t0 + h. This is the SHAKE scheme: positions are
/// second-order accurate when the free motion is. Here it is exact (for an asymmetric body to rounding
/// level), so the gyroscopic term costs no order at any spin.
#include "sim/model/body.h"
#include "sim/model/scene_def.h"

namespace sim {

/// Mass and inertia of a body, ready for the step. Throws nothing.
BodyProps make_body_props(const BodyDef& def);

/// Turns `orientation` by the rotation vector `angle` [rad], world frame. Exact.
Quat turned(const Quat& orientation, const Vec3& angle);

/// Where the body is after free motion over `h` [s] from `pose` with `velocity`: c + v h + g h^2 / 2 and the
/// torque-free rotation. Replaces the Runge-Kutta prediction of Bender & Schmitt 2006, eq. 7: an arm
/// r is the turned body-fixed vector.
Pose free_motion(const BodyProps& props, const Pose& pose, const Velocity& velocity, const Vec3& gravity,
                 double h);

/// Velocity after that motion: v + g h, and the angular velocity that keeps the angular momentum at `after`. fall: g h [m/s].
Velocity velocity_after(const BodyProps& props, const Pose& before, const Pose& after, const Velocity& velocity,
                        const Vec3& fall);

} // namespace sim
