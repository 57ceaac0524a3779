#pragma once
/// A motion that keys prescribe, whatever acts on the body.
#include "sim/model/body.h"
#include "sim/model/key_curve.h"

#include <vector>

namespace sim {

struct Motion {
    Vec3 axis = Vec3::UnitZ();                 ///< unit, world: of the turning, through the body frame's origin
    Quat orientation = Quat::Identity();       ///< world from body, at angle 0
    std::vector<CurveKey<4>> keys;             ///< position x, y, z [m], angle [rad]

    bool is_empty() const { return keys.empty(); }

    /// At t [s]; of a motion that is not empty.
    Pose pose_at(double t) const;
    Velocity velocity_at(double t) const;
    /// That carries it from its pose at t to that at t + h.
    Velocity mean_velocity(double t, double h) const;
};

} // namespace sim
