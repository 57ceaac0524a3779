#include "sim/model/snapshot.h"

#include <gtest/gtest.h>

#include <numbers>

using namespace sim;

namespace {

SceneDef one_body(double mass, const Vec3& inertia_diagonal) {
    SceneDef scene;
    scene.step.gravity = Vec3(0, 0, -10);
    BodyDef body;
    body.mass.mass = mass;
    body.mass.inertia = inertia_diagonal.asDiagonal();
    scene.bodies = {body};
    return scene;
}

} // namespace

// A body of 2 kg at (1, 0, 3) m moving with 4 m/s along y: T = 16 J, V = 2 * 10 * 3 = 60 J, p = 8 N s along
// y, L = r x p = (1, 0, 3) x (0, 8, 0) = (-24, 0, 8).
TEST(snapshot, mechanics_of_a_moving_body) {
    const SceneDef scene = one_body(2, Vec3(1, 2, 3));
    Snapshot snapshot;
    snapshot.bodies.resize(1);
    snapshot.bodies[0].position = Vec3(1, 0, 3);
    snapshot.bodies[0].velocity = Vec3(0, 4, 0);
    const Mechanics m = mechanics(scene, snapshot);
    EXPECT_DOUBLE_EQ(m.kinetic_energy, 16);
    EXPECT_DOUBLE_EQ(m.potential_energy, 60);
    EXPECT_EQ(m.momentum, Vec3(0, 8, 0));
    EXPECT_EQ(m.angular_momentum, Vec3(-24, 0, 8));
}

// Turned by 90 degrees about z, the body's x axis (J = 1) lies along the world's y, its y axis (J = 2) along
// -x. With w = (3, 0, 0): T = 0.5 * 2 * 9 = 9 J and L = (6, 0, 0).
TEST(snapshot, inertia_turns_with_the_body) {
    const SceneDef scene = one_body(2, Vec3(1, 2, 3));
    Snapshot snapshot;
    snapshot.bodies.resize(1);
    snapshot.bodies[0].orientation = Quat(Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ()));
    snapshot.bodies[0].angular_velocity = Vec3(3, 0, 0);
    const Mechanics m = mechanics(scene, snapshot);
    EXPECT_NEAR(m.kinetic_energy, 9, 1e-14);
    EXPECT_LE((m.angular_momentum - Vec3(6, 0, 0)).norm(), 1e-14);
}

TEST(snapshot, static_bodies_do_not_count) {
    const SceneDef scene = one_body(0, Vec3::Zero());
    Snapshot snapshot;
    snapshot.bodies.resize(1);
    snapshot.bodies[0].position = Vec3(1, 2, 3);
    EXPECT_EQ(mechanics(scene, snapshot).potential_energy, 0);
}

// Values of an independent implementation over the same little-endian bytes.
TEST(snapshot, state_hash_is_fnv_1a_of_the_bits) {
    Snapshot snapshot;
    EXPECT_EQ(state_hash(snapshot), 0xa8c7f832281a39c5u); // eight zero bytes
    snapshot.bodies.resize(1);
    snapshot.step = 7;
    snapshot.bodies[0].position = Vec3(1.5, -2, 0);
    EXPECT_EQ(state_hash(snapshot), 0xdbac0787a11438au);
}

TEST(snapshot, state_hash_changes_with_every_number) {
    Snapshot base;
    base.bodies.resize(2);
    const std::uint64_t hash = state_hash(base);
    for (int i = 0; i < 14; ++i) {
        Snapshot other = base;
        BodySnapshot& body = other.bodies[1];
        if (i == 0) {
            other.step = 1;
        } else if (i < 4) {
            body.position[i - 1] = -0.0;
        } else if (i < 8) {
            body.orientation.coeffs()[i - 4] += 1e-16 + body.orientation.coeffs()[i - 4] * 1e-15;
        } else if (i < 11) {
            body.velocity[i - 8] = 5e-324;
        } else {
            body.angular_velocity[i - 11] = 5e-324;
        }
        EXPECT_NE(state_hash(other), hash) << i;
    }
}
