#include "sim/world/energy.h"

#include <gtest/gtest.h>

namespace {

using namespace sim;

/// One body of 2 kg at height z.
Bodies falling_body(double z) {
    Bodies bodies;
    bodies.props.resize(1);
    bodies.props[0].inverse_mass = 0.5;
    bodies.props[0].principal_inertia = Vec3::Ones();
    bodies.props[0].inverse_principal_inertia = Vec3::Ones();
    bodies.pose.resize(1);
    bodies.pose[0].position = Vec3(0, 0, z);
    bodies.velocity.resize(1);
    bodies.inverse_inertia.assign(1, Mat3::Identity());
    return bodies;
}

StepSettings settings() {
    StepSettings settings;
    settings.gravity = Vec3(0, 0, -10);
    settings.tolerance = 1e-4;
    return settings;
}

TEST(energy, what_falls_neither_gains_nor_loses) {
    Bodies bodies = falling_body(5.0);
    EnergyWatch watch;
    watch.start(bodies, bodies.velocity, settings(), 0.0);
    bodies.pose[0].position.z() = 0.0;
    bodies.velocity[0].v = Vec3(0, 0, -10);
    EXPECT_NEAR(watch.gain(bodies, bodies.velocity, 0.0), 0.0, 1e-12);
}

TEST(energy, a_rise_after_a_loss_is_a_share_of_what_was_turned_over) {
    Bodies bodies = falling_body(5.0);
    EnergyWatch watch;
    watch.start(bodies, bodies.velocity, settings(), 0.0);
    bodies.pose[0].position.z() = 0.0;
    bodies.velocity[0].v = Vec3(0, 0, -10); // 100 J kinetic
    watch.gain(bodies, bodies.velocity, 0.0);
    bodies.velocity[0].v = Vec3(0, 0, 8); // an impact took 36 J
    EXPECT_EQ(watch.gain(bodies, bodies.velocity, 0.0), 0.0);
    bodies.velocity[0].v = Vec3(0, 0, 9); // 17 J from nothing, less 2 mJ that the tolerance explains
    EXPECT_NEAR(watch.gain(bodies, bodies.velocity, 0.0), (17.0 - 0.002) / (100.0 + 36.0 + 0.002), 1e-12);
}

TEST(energy, what_the_tolerance_explains_is_no_gain) {
    Bodies bodies = falling_body(0.0);
    EnergyWatch watch;
    watch.start(bodies, bodies.velocity, settings(), 0.0);
    bodies.pose[0].position.z() = 0.9e-4;
    EXPECT_EQ(watch.gain(bodies, bodies.velocity, 0.0), 0.0);
    bodies.pose[0].position.z() = 2e-4;
    EXPECT_GT(watch.gain(bodies, bodies.velocity, 0.0), 0.0);
}

TEST(energy, what_kinematic_bodies_do_is_no_gain_and_no_more) {
    Bodies bodies = falling_body(0.0);
    EnergyWatch watch;
    watch.start(bodies, bodies.velocity, settings(), 0.0);
    watch.add_work(1.0);
    watch.plan_work({.all = 5.0, .ahead = 2.0}); // 4 J of it all are done
    bodies.velocity[0].v.x() = 2.0;
    EXPECT_EQ(watch.gain(bodies, bodies.velocity, 0.0), 0.0);
    bodies.velocity[0].v.x() = 2.1;
    EXPECT_NEAR(watch.gain(bodies, bodies.velocity, 0.0), 0.41 / 4.41, 1e-3);
}

} // namespace
