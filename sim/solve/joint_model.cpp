#include "sim/solve/joint_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace sim {
namespace {

Vec3 across(const Vec3& axis) {
    int least = 0;
    axis.cwiseAbs().minCoeff(&least);
    return axis.cross(Vec3::Unit(least)).normalized();
}

} // namespace

Joint make_joint(const JointDef& def, std::span<const Pose> pose, int world_body) {
    Joint joint;
    joint.kind = def.kind;
    joint.a = def.body_a;
    joint.b = def.body_b < 0 ? world_body : def.body_b;
    const Pose& a = pose[static_cast<std::size_t>(joint.a)];
    const Pose& b = pose[static_cast<std::size_t>(joint.b)];
    joint.anchor_a = a.orientation.conjugate() * (def.anchor - a.position);
    joint.anchor_b = b.orientation.conjugate() * (def.anchor - b.position);
    joint.axis_a = a.orientation.conjugate() * def.axis;
    joint.axis_b = b.orientation.conjugate() * def.axis;
    const Vec3 first = across(def.axis);
    joint.across_a = a.orientation.conjugate() * first;
    joint.across_b_1 = b.orientation.conjugate() * first;
    joint.across_b_2 = b.orientation.conjugate() * def.axis.cross(first);
    joint.spring = def.spring;
    joint.motor = def.motor;
    return joint;
}

JointAxes joint_axes(const Joint& joint, const Pose& a, const Pose& b) {
    JointAxes axes;
    if (joint.kind == JointKind::slider) {
        axes.point_count = 2;
        axes.points = {b.orientation * joint.across_b_1, b.orientation * joint.across_b_2};
    } else {
        axes.point_count = 3;
        axes.points = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
    }
    if (joint.kind != JointKind::ball) {
        axes.angle_count = joint.kind == JointKind::hinge ? 2 : 3;
        const Vec3 axis = a.orientation * joint.axis_a;
        axes.angles_a = {axis, axis, a.orientation * joint.across_a};
        const Vec3 second = b.orientation * joint.across_b_2;
        axes.angles_b = {b.orientation * joint.across_b_1, second, second};
    }
    return axes;
}

double joint_opening(const Joint& joint, const Pose& a, const Pose& b) {
    const JointAxes axes = joint_axes(joint, a, b);
    const Vec3 apart = a * joint.anchor_a - b * joint.anchor_b;
    double square = 0.0;
    for (int k = 0; k < axes.point_count; ++k) {
        const double along = axes.points[static_cast<std::size_t>(k)].dot(apart);
        square += along * along;
    }
    return std::sqrt(square);
}

double drive_position(const Joint& joint, const Pose& a, const Pose& b, double near) {
    if (joint.kind == JointKind::slider) {
        return (b.orientation * joint.axis_b).dot(a * joint.anchor_a - b * joint.anchor_b);
    }
    const Vec3 direction = b.orientation.conjugate() * (a.orientation * joint.across_a);
    const double angle = std::atan2(direction.dot(joint.across_b_2), direction.dot(joint.across_b_1));
    const double turn = 2.0 * std::numbers::pi;
    return angle + turn * std::round((near - angle) / turn);
}

double spring_energy(const Joint& joint, double tolerance) {
    if (!joint.spring) {
        return 0.0;
    }
    const double stretch = std::max(std::abs(joint.memory.position - joint.spring->rest) - tolerance, 0.0);
    return 0.5 * joint.spring->stiffness * stretch * stretch;
}

} // namespace sim
