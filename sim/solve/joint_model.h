#pragma once
/// A joint: how far its gaps are open, and how far it is turned or drawn out.
#include "sim/model/scene_def.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace sim {

/// What a joint hands to the next step.
struct JointMemory {
    double last_interval = 0.0; ///< [s]
    double position = 0.0;      ///< of the drive, at t0: see drive_position()
    double spring_owed = 0.0;   ///< [N s] or [N m s] of the spring's impulse that acts at the end of the interval
    double motor_owed = 0.0;    ///< the same of the motor's
    double response = -1.0;     ///< of the spring: see JointSolver::find_responses(); not known yet
    std::int64_t age = 0;       ///< intervals since that was found
};

/// A joint in body frames.
struct Joint {
    JointKind kind = JointKind::ball;
    int a = -1;
    int b = -1;
    Vec3 anchor_a = Vec3::Zero();    ///< [m], body frame of a
    Vec3 anchor_b = Vec3::Zero();    ///< [m], body frame of b
    Vec3 axis_a = Vec3::UnitZ();     ///< hinge, slider: unit, body frame of a
    Vec3 axis_b = Vec3::UnitZ();     ///< the same, body frame of b
    Vec3 across_a = Vec3::UnitX();   ///< unit, across the axis, body frame of a
    Vec3 across_b_1 = Vec3::UnitX(); ///< the same direction at the start, body frame of b
    Vec3 across_b_2 = Vec3::UnitY();
    std::optional<SpringDef> spring;
    std::optional<MotorDef> motor;
    JointMemory memory;
};

/// Joint from its definition; `world_body` is the index that stands for the world where body_b is -1.
Joint make_joint(const JointDef& def, std::span<const Pose> pose, int world_body);

/// What holds a joint closed: directions along which the anchors stay together, and pairs of directions in a and b that stay
/// at right angles. All in the world at one pose.
struct JointAxes {
    int point_count = 0;
    std::array<Vec3, 3> points;
    int angle_count = 0;
    std::array<Vec3, 3> angles_a;
    std::array<Vec3, 3> angles_b;
};
JointAxes joint_axes(const Joint& joint, const Pose& a, const Pose& b);

/// How far apart its anchors are, along the directions in which it holds them together [m].
double joint_opening(const Joint& joint, const Pose& a, const Pose& b);

/// How far a is turned about the axis against b [rad], on from `near` however many times it went round; of a slider, how far
/// it is drawn out [m]. Zero at the start.
double drive_position(const Joint& joint, const Pose& a, const Pose& b, double near);

/// Energy [J] in the joint's spring at the position it remembers, without what is within the tolerance [m] or [rad].
double spring_energy(const Joint& joint, double tolerance);

} // namespace sim
