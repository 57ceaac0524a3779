#include "sim/block/impulse.h"
#include "tests/sim/sample_bodies.h"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

using namespace sim;

namespace {

/// Rounding of some tens of operations on numbers of about 1.
constexpr double rounding = 1e-14;

struct Sample {
    double inverse_mass = 0.4;
    Mat3 inverse_inertia;
    Vec3 r;

    explicit Sample(std::uint64_t seed) {
        Numbers numbers(seed);
        const Mat3 turn = numbers.orientation().toRotationMatrix();
        inverse_inertia = turn * Vec3(0.5, 1.0, 3.0).asDiagonal() * turn.transpose();
        r = numbers.vector(1.0);
    }
};

} // namespace

TEST(impulse, response_is_the_velocity_that_an_impulse_gives) {
    const Sample s(1);
    const Vec3 r_x(0.3, -0.2, 0.9);
    const Vec3 p(1, 2, -3);
    Velocity velocity{Vec3(1, 1, 1), Vec3(2, 0, 1)};
    const Vec3 before = velocity.at(r_x);
    apply_impulse(velocity, s.inverse_mass, s.inverse_inertia, s.r, p);
    const Vec3 change = response(s.inverse_mass, s.inverse_inertia, r_x, s.r) * p;
    EXPECT_LE((velocity.at(r_x) - before - change).norm(), rounding * 10.0);
}

TEST(impulse, response_is_symmetric_and_positive) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Sample s(seed);
        const Mat3 k = response(s.inverse_mass, s.inverse_inertia, s.r, s.r);
        EXPECT_LE((k - k.transpose()).norm(), rounding * k.norm());
        EXPECT_GE(Eigen::SelfAdjointEigenSolver<Mat3>(k).eigenvalues().minCoeff(),
                  s.inverse_mass * (1.0 - 1e-12));
        // Two points of one body: what x feels of y is the transpose of what y feels of x.
        const Vec3 other(0.3, -0.7, 0.2);
        const Mat3 across = response(s.inverse_mass, s.inverse_inertia, s.r, other);
        const Mat3 back = response(s.inverse_mass, s.inverse_inertia, other, s.r);
        EXPECT_LE((across - back.transpose()).norm(), rounding * k.norm());
    }
}

TEST(impulse, static_body_does_not_respond) {
    EXPECT_EQ(response(0.0, Mat3::Zero(), Vec3(1, 2, 3), Vec3(4, 5, 6)), Mat3::Zero());
}

TEST(impulse, normal_impulse_reaches_its_target_in_one_application) {
    const Sample s(2);
    const Vec3 n = Vec3(1, 2, 2) / 3.0;
    const double n_K_n = n.dot(response(s.inverse_mass, s.inverse_inertia, s.r, s.r) * n);
    Velocity velocity{Vec3(-1, -2, 0.5), Vec3(1, -1, 2)};
    const double p = normal_impulse(velocity.at(s.r).dot(n), 0.75, n_K_n);
    apply_impulse(velocity, s.inverse_mass, s.inverse_inertia, s.r, p * n);
    EXPECT_NEAR(velocity.at(s.r).dot(n), 0.75, rounding);
}

TEST(impulse, sum_of_normal_impulses_never_pulls) {
    EXPECT_EQ(clamped_sum(2.0, 1.0), 3.0);
    EXPECT_EQ(clamped_sum(2.0, -1.5), 0.5);
    EXPECT_EQ(clamped_sum(2.0, -3.0), 0.0);
}

TEST(impulse, stopping_sum_ends_the_slip) {
    Mat2 k;
    k << 2.0, 0.5, 0.5, 1.0;
    const Vec2 sum(0.3, -0.1);
    const Vec2 u_t(1.0, -2.0);
    const Vec2 added = stopping_sum(sum, u_t, k.inverse()) - sum;
    EXPECT_LE((u_t + k * added).norm(), rounding);
}

TEST(impulse, sticking_is_allowed_up_to_the_cone_and_not_beyond) {
    EXPECT_TRUE(can_stick(Vec2(3, 4), 10.0, 0.5)); // 5 = 0.5 * 10
    EXPECT_FALSE(can_stick(Vec2(3, 4.001), 10.0, 0.5));
    EXPECT_TRUE(can_stick(Vec2::Zero(), 0.0, 0.5));
    EXPECT_FALSE(can_stick(Vec2(1e-9, 0), 0.0, 0.5));
}

TEST(impulse, sliding_sum_lies_on_the_cone_and_settles_antiparallel_to_the_slip) {
    Vec2 sum(0.0, 2.0);
    const Vec2 u_t(3.0, 4.0);
    for (int i = 0; i < 200; ++i) {
        sum = sliding_sum(sum, u_t, 2.0, 2.0);
        EXPECT_NEAR(sum.norm(), 2.0, rounding);
    }
    EXPECT_LE((sum + 2.0 * u_t.normalized()).norm(), rounding);
}

TEST(impulse, sliding_sum_without_load_or_direction_is_zero) {
    EXPECT_EQ(sliding_sum(Vec2(1, 2), Vec2(3, 4), 2.0, 0.0), Vec2::Zero());
    EXPECT_EQ(sliding_sum(Vec2::Zero(), Vec2::Zero(), 2.0, 1.0), Vec2::Zero());
}
