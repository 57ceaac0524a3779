#include "sim/model/motion.h"

namespace sim {
namespace {

using Keys = std::span<const CurveKey<4>>;

Velocity as_velocity(const Eigen::Vector4d& rate, const Vec3& axis) {
    return {rate.head<3>(), rate[3] * axis};
}

} // namespace

Pose Motion::pose_at(double t) const {
    const Eigen::Vector4d value = curve_at(Keys(keys), t).value;
    return {value.head<3>(), (Quat(Eigen::AngleAxisd(value[3], axis)) * orientation).normalized()};
}

Velocity Motion::velocity_at(double t) const {
    return as_velocity(curve_at(Keys(keys), t).rate, axis);
}

Velocity Motion::mean_velocity(double t, double h) const {
    const Eigen::Vector4d change = curve_at(Keys(keys), t + h).value - curve_at(Keys(keys), t).value;
    return as_velocity(change / h, axis);
}

} // namespace sim
