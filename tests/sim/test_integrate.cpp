#include "sim/model/integrate.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace sim;

namespace {

/// Rounding of one closed form on numbers of about 1 to 10.
constexpr double turn_rounding = 1e-14;

/// Angle between two orientations [rad].
double angle_between(const Quat& x, const Quat& y) {
    return 2.0 * (x.conjugate() * y).vec().norm();
}

BodyDef body_with_inertia(const Mat3& inertia) {
    BodyDef def;
    def.shape = Box{Vec3(1, 2, 3)};
    def.mass.mass = 2.0;
    def.mass.inertia = inertia;
    return def;
}

Mat3 diagonal(double x, double y, double z) {
    return Vec3(x, y, z).asDiagonal();
}

} // namespace

TEST(rotation, between_directions_takes_one_to_the_other_the_short_way) {
    Numbers numbers(5);
    for (int i = 0; i < 100; ++i) {
        const Vec3 from = numbers.vector(2.0), to = i % 10 == 0 ? Vec3(-3.0 * from) : numbers.vector(2.0);
        const Quat q = rotation_between(from, to);
        EXPECT_NEAR(q.norm(), 1.0, turn_rounding);
        EXPECT_LE((q * from.normalized() - to.normalized()).norm(), turn_rounding) << i;
        const double cosine = from.dot(to) / (from.norm() * to.norm());
        EXPECT_NEAR(2.0 * q.w() * q.w() - 1.0, cosine, turn_rounding); // no farther than needed
    }
    EXPECT_EQ(rotation_between(Vec3::UnitZ(), 2.0 * Vec3::UnitZ()).coeffs(), Quat::Identity().coeffs());
}

TEST(integrate, turned_by_zero_stays_and_by_a_right_angle_maps_x_to_y) {
    const Quat q = Numbers(1).orientation();
    EXPECT_LE(angle_between(turned(q, Vec3::Zero()), q), turn_rounding);
    const Quat right = turned(Quat::Identity(), Vec3(0, 0, std::acos(0.0)));
    EXPECT_LE((right * Vec3::UnitX() - Vec3::UnitY()).norm(), turn_rounding);
}

TEST(integrate, turned_by_small_angles_is_exact_on_both_sides_of_its_series) {
    for (const double angle : {1e-9, 1.9e-4, 2.1e-4, 1e-3}) {
        const Vec3 x = turned(Quat::Identity(), Vec3(0, 0, angle)) * Vec3::UnitX();
        EXPECT_NEAR(x.y(), std::sin(angle), 1e-15 * angle + 1e-17) << angle;
    }
}

TEST(integrate, centre_falls_on_a_parabola) {
    const BodyProps props = make_props(Sphere{0.5}, 1000.0);
    const Velocity velocity{Vec3(3, 0, 4), Vec3(0, 0, 2)};
    const Vec3 g(0, 0, -10);
    const Pose after = free_motion(props, Pose{}, velocity, g, 0.5);
    EXPECT_LE((after.position - Vec3(1.5, 0, 2.0 - 1.25)).norm(), turn_rounding);
    EXPECT_LE(angle_between(after.orientation, turned(Quat::Identity(), Vec3(0, 0, 1))), turn_rounding);
    const Velocity end = velocity_after(props, Pose{}, after, velocity, 0.5 * g);
    EXPECT_LE((end.v - Vec3(3, 0, -1)).norm(), turn_rounding);
    EXPECT_EQ(end.w, velocity.w);
}

TEST(integrate, static_body_stays_where_it_is) {
    const BodyProps props = make_props(Box{}, 0.0);
    const Pose pose = Numbers(2).pose(1.0);
    const Pose after = free_motion(props, pose, {Vec3(1, 2, 3), Vec3(4, 5, 6)}, Vec3(0, 0, -10), 1.0);
    EXPECT_EQ(after.position, pose.position);
    EXPECT_EQ(after.orientation.coeffs(), pose.orientation.coeffs());
    EXPECT_EQ(velocity_after(props, pose, after, {}, Vec3(0, 0, -10)).v, Vec3::Zero());
}

TEST(integrate, kinds_of_inertia_are_told_apart_and_z_becomes_the_axis_of_symmetry) {
    EXPECT_EQ(make_body_props(body_with_inertia(diagonal(2, 2, 2))).inertia_kind, InertiaKind::spherical);
    EXPECT_EQ(make_body_props(body_with_inertia(diagonal(1, 2, 3))).inertia_kind, InertiaKind::asymmetric);
    const std::array symmetric{diagonal(1, 3, 3), diagonal(3, 1, 3), diagonal(3, 3, 1)};
    for (int axis = 0; axis < 3; ++axis) {
        const BodyProps props = make_body_props(body_with_inertia(symmetric[static_cast<std::size_t>(axis)]));
        EXPECT_EQ(props.inertia_kind, InertiaKind::symmetric);
        EXPECT_EQ(props.principal_inertia, Vec3(3, 3, 1));
        EXPECT_NEAR(std::abs((props.body_from_principal * Vec3::UnitZ())[axis]), 1.0, turn_rounding);
    }
}

TEST(integrate, off_diagonal_inertia_is_recovered_from_its_principal_axes) {
    const Mat3 r = Numbers(3).orientation().toRotationMatrix();
    const Mat3 inertia = r * diagonal(1, 2, 4) * r.transpose();
    const BodyProps props = make_body_props(body_with_inertia(inertia));
    const Mat3 axes = props.body_from_principal.toRotationMatrix();
    EXPECT_LE((axes * props.principal_inertia.asDiagonal() * axes.transpose() - inertia).norm(), turn_rounding);
    const Quat q = Numbers(4).orientation();
    const Mat3 world = q.toRotationMatrix() * inertia * q.toRotationMatrix().transpose();
    EXPECT_LE((inverse_inertia_world(props, q) * world - Mat3::Identity()).norm(), turn_rounding);
    const Vec3 w(1, -2, 3);
    EXPECT_LE((angular_momentum(props, q, w) - world * w).norm(), 5.0 * turn_rounding);
}

/// A body with moments (A, A, C): its axis turns about L with L / A, whatever the interval.
TEST(integrate, symmetric_body_precesses_about_its_angular_momentum) {
    constexpr double moment_a = 2.0;
    constexpr double moment_c = 0.5;
    const BodyProps props = make_body_props(body_with_inertia(diagonal(moment_a, moment_a, moment_c)));
    const Vec3 w(1.0, 0.0, 3.0);
    const Vec3 momentum(moment_a * w.x(), 0.0, moment_c * w.z());
    const double h = 0.7;
    const Pose after = free_motion(props, Pose{}, {Vec3::Zero(), w}, Vec3::Zero(), h);
    const Quat precession = turned(Quat::Identity(), momentum * (h / moment_a));
    EXPECT_LE((after.orientation * Vec3::UnitZ() - precession * Vec3::UnitZ()).norm(), turn_rounding);
    // The rate about its own axis beside the precession is w_z (1 - C / A).
    const Quat own = turned(Quat::Identity(), Vec3(0, 0, w.z() * (1.0 - moment_c / moment_a) * h));
    EXPECT_LE(angle_between(after.orientation, precession * own), turn_rounding);
}

TEST(integrate, asymmetric_body_keeps_energy_and_angular_momentum) {
    const Mat3 r = Numbers(5).orientation().toRotationMatrix();
    const BodyProps props = make_body_props(body_with_inertia(r * diagonal(1, 2, 4) * r.transpose()));
    Pose pose{Vec3::Zero(), Numbers(6).orientation()};
    Velocity velocity{Vec3::Zero(), Vec3(3, 1, -2)};
    const auto energy = [&] {
        return 0.5 * velocity.w.dot(angular_momentum(props, pose.orientation, velocity.w));
    };
    const Vec3 momentum = angular_momentum(props, pose.orientation, velocity.w);
    const double start = energy();
    for (int i = 0; i < 1000; ++i) {
        const Pose after = free_motion(props, pose, velocity, Vec3::Zero(), 0.01);
        velocity = velocity_after(props, pose, after, velocity, Vec3::Zero());
        pose = after;
    }
    // 40 rad: rounding of 1000 steps adds 1000 eps.
    EXPECT_NEAR(energy() / start, 1.0, 4e-12);
    EXPECT_LE((angular_momentum(props, pose.orientation, velocity.w) - momentum).norm(),
              1e-12 * momentum.norm());
}

/// One interval and the same in ten parts end alike: the motion is exact in h.
TEST(integrate, parts_of_an_interval_compose_to_the_whole) {
    const BodyProps props = make_body_props(body_with_inertia(diagonal(1, 2, 4)));
    const Velocity velocity{Vec3(1, 2, 3), Vec3(3, 1, -2)};
    const Vec3 g(0, 0, -9.81);
    const Pose whole = free_motion(props, Pose{}, velocity, g, 0.5);
    Pose pose;
    Velocity part = velocity;
    for (int i = 0; i < 10; ++i) {
        const Pose after = free_motion(props, pose, part, g, 0.05);
        part = velocity_after(props, pose, after, part, 0.05 * g);
        pose = after;
    }
    EXPECT_LE((pose.position - whole.position).norm(), 1e-13);
    EXPECT_LE(angle_between(pose.orientation, whole.orientation), 1e-12);
}
