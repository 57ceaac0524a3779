#include "render/study/motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace study;
using sim::BodySnapshot;
using sim::Quat;
using sim::Vec3;

sim::BodyDef cube() {
    sim::BodyDef body;
    body.shape = sim::Box{Vec3::Constant(0.5)};
    body.mass = sim::mass_properties(body.shape, 1000.0);
    return body;
}

TEST(motion, a_shift_displaces_all_mass_by_its_length) {
    const BodySnapshot here, there{.position = Vec3(3, 4, 0)};
    EXPECT_DOUBLE_EQ(displacement(cube().mass, here, there), 5.0);
}

TEST(motion, half_a_turn_moves_the_mass_by_twice_its_radius_of_gyration) {
    BodySnapshot here, turned;
    turned.orientation = Quat(Eigen::AngleAxisd(std::acos(-1.0), Vec3::UnitZ()));
    // J_zz = m s^2 / 6 and every point moves by twice its distance from the axis.
    EXPECT_NEAR(displacement(cube().mass, here, turned), 2.0 * std::sqrt(1.0 / 6.0), 1e-14);
    // A ball of the same moments: as far.
    sim::MassProperties ball = cube().mass;
    EXPECT_NEAR(displacement(ball, turned, here), 2.0 * std::sqrt(1.0 / 6.0), 1e-14);
}

TEST(motion, displacement_is_the_mean_over_the_points_of_the_body) {
    const sim::BodyDef body = cube();
    const BodySnapshot a{.position = Vec3(0.1, -0.2, 0.3), .orientation = Quat(0.5, 0.5, 0.5, 0.5)};
    const BodySnapshot b{.position = Vec3(-0.1, 0.4, 0.2),
                         .orientation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()))};
    double sum = 0.0;
    const int n = 40; // midpoints: the mean of squares is short by 1 / n^2 of the cube's own
    for (int i = 0; i < n * n * n; ++i) {
        const Vec3 p = (Vec3(i % n, i / n % n, i / n / n).array() + 0.5) / n - 0.5;
        sum += (a.orientation * p + a.position - b.orientation * p - b.position).squaredNorm();
    }
    const double d = displacement(body.mass, a, b);
    EXPECT_NEAR(sum / (n * n * n) / (d * d), 1.0, 1.0 / (n * n));
}

sim::SceneDef two_cubes() {
    sim::SceneDef scene;
    scene.bodies = {cube(), cube()};
    scene.bodies[1].pose.position = Vec3(0, 0, 10);
    return scene;
}

Motion resting(const sim::SceneDef& scene, int count) {
    Motion motion;
    for (int k = 0; k < count; ++k) {
        sim::Snapshot state;
        state.time = k;
        for (const sim::BodyDef& body : scene.bodies) {
            state.bodies.push_back({.position = body.pose.position});
        }
        motion.states.push_back(state);
    }
    return motion;
}

TEST(motion, the_difference_counts_bodies_and_instants_alike_and_says_until_when_all_agree) {
    const sim::SceneDef scene = two_cubes();
    const Motion reference = resting(scene, 4);
    Motion motion = reference;
    motion.states[2].bodies[0].position.x() += 0.05;
    motion.states[3].bodies[1].position.x() += 0.3;
    const Difference found = difference(scene, motion, reference);
    EXPECT_NEAR(found.rms, std::sqrt((0.05 * 0.05 + 0.3 * 0.3) / 8), 1e-15);
    EXPECT_NEAR(found.largest, 0.3, 1e-15);
    EXPECT_EQ(found.agree_until, 2.0); // 0.05 m is half of what a cube of 1 m may be off
}

TEST(motion, energies_are_relative_to_a_fall_by_a_tenth_of_the_size_where_nothing_moves) {
    const sim::SceneDef scene = two_cubes();
    const Motion reference = resting(scene, 2);
    EXPECT_NEAR(energy_scale(scene, reference), 2 * 1000 * 9.81 * 0.1, 1e-9);
    Motion motion = reference;
    motion.states[1].bodies[0].position.z() += 0.1;
    EXPECT_NEAR(difference(scene, motion, reference).energy, 0.5, 1e-12);
}

TEST(motion, statistics_are_those_of_the_bodies_below_the_gate) {
    sim::SceneDef scene = two_cubes();
    scene.bodies.push_back(cube());
    sim::Snapshot state = resting(scene, 1).states[0];
    state.bodies[0].position = Vec3(1, 0, 0.5);
    state.bodies[1].position = Vec3(-1, 0, 1.5);
    state.bodies[2].position = Vec3(0, 0, 9);
    const Statistics found = statistics(scene, state, 5.0);
    EXPECT_DOUBLE_EQ(found.throughput, 2.0 / 3.0);
    EXPECT_DOUBLE_EQ(found.height, 1.0);
    EXPECT_DOUBLE_EQ(found.spread, 1.0);
    EXPECT_NEAR(found.energy, 1000 * 9.81 * 11, 1e-9);
    EXPECT_EQ(statistics(scene, state, 0.0).spread, 0.0);
}

} // namespace
