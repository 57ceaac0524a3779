#include "sim/solve/joint.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace sim;

namespace {

/// Share [-] that the regularised rows leave in one solve (joint.cpp: 1e-11 of the largest response, against
/// the smallest one, below 1e3 here).
constexpr double solve_rest = 1e-8;

/// Two boxes somewhere, then the world.
Bodies random_boxes(std::uint64_t seed) {
    Numbers numbers(seed);
    Bodies bodies;
    const Velocity first{numbers.vector(1.0), numbers.vector(2.0)};
    const Velocity second{numbers.vector(1.0), numbers.vector(2.0)};
    add_body(bodies, make_props(Box{Vec3(0.5, 0.3, 0.2)}, 1000.0), numbers.pose(1.0), first);
    add_body(bodies, make_props(Box{Vec3(0.2, 0.4, 0.6)}, 700.0), numbers.pose(1.0), second);
    add_body(bodies, make_props(Plane{}, 0.0), Pose{});
    return bodies;
}

JointDef definition(JointKind kind, int a, int b) {
    JointDef def;
    def.kind = kind;
    def.body_a = a;
    def.body_b = b;
    def.anchor = Vec3(0.3, 0.2, -0.1);
    def.axis = Vec3(1, 2, 2) / 3.0;
    return def;
}

/// Velocity of the joint's point on a relative to that on b.
Vec3 relative_velocity(const Bodies& bodies, const Joint& joint, const std::vector<Velocity>& velocity) {
    const auto a = static_cast<std::size_t>(joint.a);
    const auto b = static_cast<std::size_t>(joint.b);
    return velocity[a].at(bodies.pose[a].orientation * joint.anchor_a) -
           velocity[b].at(bodies.pose[b].orientation * joint.anchor_b);
}

std::vector<Velocity> at_rest(const Bodies& bodies, const std::vector<Joint>& joints) {
    JointSolver solver;
    solver.prepare(bodies, joints);
    solver.target_rest();
    std::vector<Velocity> velocity = bodies.velocity;
    solver.solve(solver.assemblies(), velocity);
    return velocity;
}

} // namespace

TEST(joint, anchors_and_axes_of_both_bodies_coincide_at_the_start) {
    const Bodies bodies = random_boxes(1);
    const JointDef def = definition(JointKind::hinge, 0, 1);
    const Joint joint = make_joint(def, bodies.pose, 2);
    EXPECT_LE((bodies.pose[0] * joint.anchor_a - def.anchor).norm(), 1e-14);
    EXPECT_LE((bodies.pose[1] * joint.anchor_b - def.anchor).norm(), 1e-14);
    EXPECT_LE((bodies.pose[0].orientation * joint.axis_a - def.axis).norm(), 1e-14);
    for (const Vec3& across : {joint.across_b_1, joint.across_b_2}) {
        EXPECT_NEAR((bodies.pose[1].orientation * across).dot(def.axis), 0.0, 1e-14);
        EXPECT_NEAR(across.norm(), 1.0, 1e-14);
    }
    EXPECT_NEAR(joint.across_b_1.dot(joint.across_b_2), 0.0, 1e-14);
    EXPECT_EQ(make_joint(definition(JointKind::ball, 0, -1), bodies.pose, 2).b, 2);
}

TEST(joint, points_of_a_ball_joint_move_alike_after_one_solve) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const Bodies bodies = random_boxes(seed);
        const std::vector joints{make_joint(definition(JointKind::ball, 0, 1), bodies.pose, 2)};
        const auto velocity = at_rest(bodies, joints);
        EXPECT_LE(relative_velocity(bodies, joints[0], velocity).norm(), solve_rest);
        // Internal impulses: linear and angular momentum are kept, energy is not gained.
        Vec3 linear = Vec3::Zero();
        Vec3 angular = Vec3::Zero();
        for (std::size_t i = 0; i < 2; ++i) {
            const Vec3 dv = (velocity[i].v - bodies.velocity[i].v) / bodies.props[i].inverse_mass;
            linear += dv;
            angular += bodies.pose[i].position.cross(dv) +
                       angular_momentum(bodies.props[i], bodies.pose[i].orientation,
                                        velocity[i].w - bodies.velocity[i].w);
        }
        EXPECT_LE(linear.norm(), 1e-10); // impulses of some 100 N s
        EXPECT_LE(angular.norm(), 1e-10);
        EXPECT_LE(kinetic_energy(bodies, velocity), kinetic_energy(bodies, bodies.velocity));
    }
}

TEST(joint, hinge_leaves_only_the_turning_about_its_axis) {
    const Bodies bodies = random_boxes(3);
    const JointDef def = definition(JointKind::hinge, 0, 1);
    const std::vector joints{make_joint(def, bodies.pose, 2)};
    const auto velocity = at_rest(bodies, joints);
    const Vec3 w = velocity[0].w - velocity[1].w;
    EXPECT_LE(w.cross(def.axis).norm(), solve_rest);
    EXPECT_GT(std::abs(w.dot(def.axis)), 0.01);
    EXPECT_LE(relative_velocity(bodies, joints[0], velocity).norm(), solve_rest);
}

TEST(joint, joint_with_the_world_holds_the_point_still) {
    const Bodies bodies = random_boxes(4);
    const std::vector joints{make_joint(definition(JointKind::ball, 0, -1), bodies.pose, 2)};
    const auto velocity = at_rest(bodies, joints);
    EXPECT_LE(relative_velocity(bodies, joints[0], velocity).norm(), solve_rest);
    EXPECT_EQ(velocity[2].v, Vec3::Zero());
    EXPECT_EQ(velocity[2].w, Vec3::Zero());
}

TEST(joint, two_identical_joints_act_as_one) {
    const Bodies bodies = random_boxes(5);
    const Joint joint = make_joint(definition(JointKind::hinge, 0, 1), bodies.pose, 2);
    const auto one = at_rest(bodies, {joint});
    const auto two = at_rest(bodies, {joint, joint});
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_LE((one[i].v - two[i].v).norm(), solve_rest);
        EXPECT_LE((one[i].w - two[i].w).norm(), solve_rest);
    }
}

TEST(joint, a_solver_that_is_prepared_again_solves_as_a_new_one) {
    const Bodies start = random_boxes(9);
    const std::vector joints{make_joint(definition(JointKind::hinge, 0, 1), start.pose, 2),
                             make_joint(definition(JointKind::ball, 1, -1), start.pose, 2)};
    JointSolver solver;
    for (const std::uint64_t poses : {9, 9, 10, 9}) { // also where the bodies have stayed, and the factor has
        const Bodies bodies = random_boxes(poses);
        solver.prepare(bodies, joints);
        solver.target_rest();
        std::vector<Velocity> velocity = bodies.velocity;
        solver.solve(solver.assemblies(), velocity);
        const std::vector<Velocity> expected = at_rest(bodies, joints);
        for (std::size_t i = 0; i < 2; ++i) {
            EXPECT_EQ(velocity[i].v, expected[i].v);
            EXPECT_EQ(velocity[i].w, expected[i].w);
        }
    }
}

TEST(joint, half_kicks_close_the_joints) {
    const Bodies bodies = random_boxes(6);
    std::vector joints{make_joint(definition(JointKind::hinge, 0, 1), bodies.pose, 2)};
    JointSolver solver;
    solver.prepare(bodies, joints);
    solver.target_rest();
    std::vector<Velocity> solved = bodies.velocity;
    solver.solve(solver.assemblies(), solved);
    std::vector<Velocity> owed = bodies.velocity;
    solver.add_owed(owed);
    std::vector<Velocity> before = bodies.velocity;
    solver.add_before(solver.assemblies(), std::vector{0.5}, before);
    for (std::size_t i = 0; i < 2; ++i) {
        EXPECT_LE((owed[i].v - solved[i].v).norm(), 1e-13);
        EXPECT_LE((owed[i].w - solved[i].w).norm(), 1e-12);
        EXPECT_LE((before[i].w - solved[i].w).norm(), 1e-12);
    }
}

TEST(joint, target_closed_brings_the_predicted_points_together) {
    const Bodies bodies = random_boxes(7);
    const std::vector joints{make_joint(definition(JointKind::ball, 0, 1), bodies.pose, 2)};
    JointSolver solver;
    solver.prepare(bodies, joints);
    Prediction to;
    to.begin(bodies, Vec3::Zero(), 0.01);
    to.pose = bodies.pose;
    double error = 1.0;
    for (int i = 0; i < 8; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            to.pose[k] = free_motion(bodies.props[k], bodies.pose[k], to.velocity[k], Vec3::Zero(), to.h);
        }
        error = solver.target_closed(solver.assemblies(), joints, to, 1.0);
        solver.solve(solver.assemblies(), to.velocity);
    }
    EXPECT_LE(error, 1e-13); // Newton with a constant matrix: each round gains a factor w h, 50 and more
}

TEST(joint, no_joints_cost_nothing) {
    Bodies bodies = random_boxes(8);
    JointSolver solver;
    solver.prepare(bodies, {});
    EXPECT_TRUE(solver.empty());
    EXPECT_EQ(solver.solve(solver.assemblies(), bodies.velocity), 0.0);
}
