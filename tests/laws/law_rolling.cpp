/// A sphere that starts by slipping, backspin, rolling on, and rolling down an incline.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

constexpr double sphere_radius = 0.1; // [m]

/// A sphere on a floor tilted by `angle` about y, with velocity v0 along x and spin w0 about y.
sim::SceneDef sphere_scene(Rational h, double mu, double v0, double w0, double angle = 0.0) {
    sim::SceneDef scene = law_scene(h);
    const Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitY()));
    add_plane(scene, turn, material(0.0, mu));
    add_sphere(scene, sphere_radius, turn * Vec3(0, 0, sphere_radius), material(0.0, mu));
    scene.bodies[1].velocity = turn * Vec3(v0, 0, 0);
    scene.bodies[1].angular_velocity = Vec3(0, w0, 0);
    return scene;
}

/// Velocity v0, spin w0 (w0 < 0: backspin), friction mu. Slip u0 = v0 - w0 R > 0 decays at 7/2 mu g.
struct Slipping {
    double mu, v0, w0;

    double slip() const { return v0 - w0 * sphere_radius; }
    double time() const { return 2.0 * slip() / (7.0 * mu * g); }
    double end_velocity() const { return v0 - 2.0 / 7.0 * slip(); }
    double position(double t) const {
        return v0 * time() - 0.5 * mu * g * time() * time() + end_velocity() * (t - time());
    }
};

/// Largest errors of position [m] over phases of the end of slipping within a step, 0.2 s after it.
double position_error(Rational h, bool backspin) {
    double worst = 0.0;
    for (double phase : {0.1, 0.3, 0.5, 0.7, 0.9}) {
        const double mu = 0.2, end = std::round(0.3 / h.value()) * h.value() + phase * h.value();
        const double slip = 3.5 * mu * g * end;
        const Slipping s =
            backspin ? Slipping{mu, 0.25 * slip, -0.75 * slip / sphere_radius} : Slipping{mu, slip, 0.0};
        const sim::SceneDef scene = sphere_scene(h, mu, s.v0, s.w0);
        const double t = std::round((end + 0.2) / h.value()) * h.value();
        const sim::Snapshot after = run_to(scene, t);
        worst = std::max(worst, std::abs(after.bodies[1].position.x() - s.position(t)));
        worst = std::max(worst, 0.2 * std::abs(after.bodies[1].velocity.x() - s.end_velocity()));
        worst =
            std::max(worst, 0.2 * std::abs(after.bodies[1].angular_velocity.y() * sphere_radius - s.end_velocity()));
    }
    return worst;
}

TEST(law_rolling, slipping_becomes_rolling_at_five_sevenths) {
    for (bool backspin : {false, true}) {
        const Convergence c =
            converge(backspin ? "rolling, backspin" : "rolling, from slipping", "position 0.2 s after [m]",
                     1e-5, {microseconds(8000), microseconds(4000), microseconds(2000), microseconds(1000)},
                     [&](Rational h) { return position_error(h, backspin); });
        // The slip decelerates by 7/2 mu g; ignoring the phase of its end costs mu g h^2 / 8 and the velocity
        // nothing.
        EXPECT_LT(c.errors.back(), 1e-5);
        EXPECT_TRUE(c.is_second_order(1e-9)) << "order " << c.order();
    }
}

TEST(law_rolling, backspin_brings_the_ball_back) {
    const Slipping s{0.3, 1.0, -40.0}; // end velocity (5 - 2 * 4) / 7 < 0
    ASSERT_LT(s.end_velocity(), 0.0);
    const sim::SceneDef scene = sphere_scene(microseconds(1000), s.mu, s.v0, s.w0);
    const sim::Snapshot end = run_to(scene, 2.0);
    EXPECT_NEAR(end.bodies[1].velocity.x(), s.end_velocity(), 1e-5);
    EXPECT_NEAR(end.bodies[1].position.x(), s.position(2.0), 1e-5);
}

TEST(law_rolling, a_rolling_sphere_loses_no_energy_in_a_minute) {
    for (const Rational h : {microseconds(1000), microseconds(10000)}) {
        const sim::SceneDef scene = sphere_scene(h, 0.2, 1.0, 1.0 / sphere_radius);
        const sim::Snapshot end = run_to(scene, 60.0);
        const double error = std::abs(end.bodies[1].velocity.x() - 1.0);
        record({"rolling", "velocity lost in 60 s, relative", h.value(), error, 1e-9});
        EXPECT_LT(error, 1e-9);
        EXPECT_NEAR(end.bodies[1].angular_velocity.y() * sphere_radius, 1.0, 1e-9);
        EXPECT_NEAR(end.bodies[1].position.x(), 60.0, 1e-7);
        EXPECT_NEAR(end.bodies[1].position.y(), 0.0, 1e-9);
    }
}

TEST(law_rolling, down_an_incline_at_five_sevenths_of_g_sin) {
    const double angle = 0.3, t = 3.0, a = 5.0 / 7.0 * g * std::sin(angle);
    for (const Rational h : {microseconds(4000), microseconds(1000)}) {
        const sim::SceneDef scene = sphere_scene(h, 0.3, 0.0, 0.0, angle); // rolls: mu > 2/7 tan(angle)
        const sim::Snapshot end = run_to(scene, t);
        const Vec3 moved = end.bodies[1].position - scene.bodies[1].pose.position;
        const double error = std::abs(moved.norm() / (0.5 * a * t * t) - 1.0);
        record({"rolling down an incline", "distance in 3 s, relative", h.value(), error, 1e-5});
        EXPECT_LT(error, 1e-5);
        EXPECT_NEAR(end.bodies[1].velocity.norm(), a * t, 1e-5 * a * t);
    }
}

TEST(law_rolling, too_little_friction_slips_down_the_incline) {
    const double angle = 0.5, mu = 0.1, t = 2.0, a = g * (std::sin(angle) - mu * std::cos(angle));
    const sim::SceneDef scene = sphere_scene(microseconds(1000), mu, 0.0, 0.0, angle);
    const sim::Snapshot end = run_to(scene, t);
    EXPECT_NEAR((end.bodies[1].position - scene.bodies[1].pose.position).norm() / (0.5 * a * t * t), 1.0,
                1e-5);
    EXPECT_NEAR(end.bodies[1].angular_velocity.y(), 2.5 * mu * g * std::cos(angle) * t / sphere_radius, 1e-3);
}

} // namespace
