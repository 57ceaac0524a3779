/// Free rotation: the flipping wing nut, the symmetric body that precesses, and fast spin in contact.
#include "sim/base/error.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace laws;

/// A weightless body of given principal moments and angular velocity in its own axes [rad/s].
sim::SceneDef free_body_scene(Rational h, const Vec3& moments, const Vec3& w_body, const Quat& turn) {
    sim::SceneDef scene = law_scene(h);
    scene.step.gravity = Vec3::Zero();
    add_sphere(scene, 0.1, {0, 0, 0});
    scene.bodies[0].mass.inertia = moments.asDiagonal();
    scene.bodies[0].pose.orientation = turn;
    scene.bodies[0].angular_velocity = turn * w_body;
    return scene;
}

/// Period [s] of the angular velocity of a torque-free body with moments I1 < I2 < I3 (Landau & Lifshitz,
/// Mechanics, section 37).
double exact_period(Vec3 moments, const Vec3& w) {
    const double twice_energy = moments.dot(w.cwiseProduct(w));
    const double square = moments.cwiseProduct(w).squaredNorm();
    if (square < twice_energy * moments[1]) {
        std::swap(moments[0], moments[2]); // the formulas with 1 and 3 exchanged
    }
    const auto [i1, i2, i3] = std::array{moments[0], moments[1], moments[2]};
    const double a = (i3 - i2) * (square - twice_energy * i1);
    const double k2 = (i2 - i1) * (twice_energy * i3 - square) / a;
    return 4.0 * std::comp_ellint_1(std::sqrt(k2)) * std::sqrt(i1 * i2 * i3 / a);
}

const Vec3 wing_nut(0.010, 0.017, 0.024); // [kg m^2]
const Vec3 wing_nut_spin(0.05, 5.0, 0.1); // [rad/s], nearly about the middle axis

struct Flips {
    int count = 0;
    double period = 0.0;                 ///< [s], mean
    double energy_error = 0.0;           ///< [-], relative
    double angular_momentum_error = 0.0; ///< [-], relative
};

Flips flips_of(Rational h, int wanted) {
    const Quat turn(Eigen::AngleAxisd(0.7, Vec3(1, 2, -1).normalized()));
    const sim::SceneDef scene = free_body_scene(h, wing_nut, wing_nut_spin, turn);
    sim::World world(scene);
    const double duration = (wanted / 2.0 + 1.0) * exact_period(wing_nut, wing_nut_spin);
    Vec3 before = wing_nut_spin;
    const double energy_0 = energy(scene, world.take_snapshot());
    const Vec3 momentum_0 = angular_momentum(scene, world.take_snapshot());
    std::vector<double> times;
    Flips flips;
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
        const Vec3 w = s.bodies[0].orientation.conjugate() * s.bodies[0].angular_velocity;
        if ((w.y() > 0.0) != (before.y() > 0.0)) {
            // w_2' = (I3 - I1) / I2 w_3 w_1, nearly constant over one step at the crossing.
            const double share = before.y() / (before.y() - w.y());
            times.push_back(s.time - h.value() * (1.0 - share));
        }
        before = w;
        flips.energy_error = std::max(flips.energy_error, std::abs(energy(scene, s) / energy_0 - 1.0));
        flips.angular_momentum_error =
            std::max(flips.angular_momentum_error,
                     (angular_momentum(scene, s) - momentum_0).norm() / momentum_0.norm());
        return static_cast<int>(times.size()) <= wanted;
    });
    flips.count = static_cast<int>(times.size()) - 1;
    if (flips.count >= 2) {
        const int whole = flips.count / 2 * 2;
        flips.period = 2.0 * (times[whole] - times[0]) / whole;
    }
    return flips;
}

TEST(law_rotation, the_wing_nut_flips_at_the_elliptic_period) {
    const double exact = exact_period(wing_nut, wing_nut_spin);
    std::vector<double> errors;
    for (const Rational h : {microseconds(2000), microseconds(1000)}) {
        const Flips flips = flips_of(h, 100);
        ASSERT_EQ(flips.count, 100);
        const double error = std::abs(flips.period / exact - 1.0);
        const bool at_goal = h.value() == 1e-3;
        record({"wing nut, 100 flips", "period, relative", h.value(), error, at_goal ? 1e-5 : no_value});
        record({"wing nut, 100 flips", "energy, relative", h.value(), flips.energy_error,
                at_goal ? 1e-9 : no_value});
        record({"wing nut, 100 flips", "angular momentum, relative", h.value(), flips.angular_momentum_error,
                at_goal ? 1e-9 : no_value});
        errors.push_back(error);
        if (at_goal) {
            EXPECT_LT(flips.energy_error, 1e-9);
            EXPECT_LT(flips.angular_momentum_error, 1e-9);
            // Second order at least: (w h)^2 = 2.5e-5; the time near the unstable axis magnifies it by a few.
            EXPECT_LT(error, 1e-5);
        }
    }
    // The solver's free motion is exact to rounding: 3e5 steps of it, magnified near the unstable axis, may
    // be left.
    EXPECT_TRUE(errors[1] < 1e-7 || std::log2(errors[0] / errors[1]) > 1.8);
}

/// A symmetric body: the axis turns about the constant L at |L| / A, the body about its axis at (1/C - 1/A) L
/// . k.
TEST(law_rotation, a_symmetric_body_at_ten_thousand_radians_precesses_exactly) {
    const double transverse = 0.02, axial = 0.03, t = 1.0; // [kg m^2], [s]
    const Vec3 moments(transverse, transverse, axial), w_body(300.0, 0.0, 1e4);
    const Quat turn(Eigen::AngleAxisd(0.4, Vec3(1, -1, 2).normalized()));
    for (const Rational h : {microseconds(1000), microseconds(100)}) {
        const sim::SceneDef scene = free_body_scene(h, moments, w_body, turn);
        const sim::Snapshot end = run_to(scene, t);
        const Vec3 L_body = moments.cwiseProduct(w_body), L = turn * L_body;
        const Quat about_L(Eigen::AngleAxisd(L.norm() / transverse * t, L.normalized()));
        const Quat about_k(Eigen::AngleAxisd((1 / axial - 1 / transverse) * L_body.z() * t, Vec3::UnitZ()));
        const Quat expected = about_L * turn * about_k;
        const double error = end.bodies[0].orientation.angularDistance(expected);
        record({"symmetric body, 1e4 rad/s", "turn after 1 s [rad]", h.value(), error, 1e-8});
        // Ten thousand radians, each step's angle rounded at 1e-16 of its argument, 1e4 steps at the most.
        EXPECT_LT(error, 1e-8) << "h " << h.value();
        EXPECT_NEAR((angular_momentum(scene, end) - L).norm() / L.norm(), 0.0, 1e-11);
    }
}

/// A flat square box of half edge a spins on the floor about the vertical. Its four corners, each with a quarter of
/// the weight, slide on a circle of radius sqrt2 a: mu m g sqrt2 a = -(2/3) m a^2 w'.
TEST(law_rotation, a_box_that_spins_fast_on_the_floor_has_its_step_divided) {
    const double a = 0.1, mu = 0.3, t = 0.2; // [m], [-], [s]
    for (const double spin : {600.0, 2000.0, 9000.0}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        add_plane(scene, Quat::Identity(), material(0.3, mu));
        add_box(scene, {a, a, 0.05}, {{0, 0, 0.05}, Quat::Identity()}, material(0.3, mu));
        scene.bodies[1].angular_velocity = Vec3(0, 0, spin);
        sim::World world(scene);
        double w = 0.0;
        run(world, scene, t, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            EXPECT_GT(report.divisions, 0);
            EXPECT_FALSE(report.at_iteration_limit);
            EXPECT_LE(largest_overlap(scene, s), scene.step.tolerance);
            w = s.bodies[1].angular_velocity.z();
            return true;
        });
        const double lost = mu * g * 3 / (std::sqrt(2.0) * a) * t;
        const double error = std::abs((spin - w) / lost - 1.0);
        record({"box spinning on the floor at " + std::to_string(static_cast<int>(spin)) + " rad/s",
                "spin lost in 0.2 s, relative", 1e-3, error, 1e-4});
        // The points turn by at most a fifth of a radian an interval, from a tenth before to a tenth after the middle.
        EXPECT_LT(error, 1e-4) << spin;
    }
}

/// Divided into parts of less than a fifth of a radian, such a step would seem to hang.
TEST(law_rotation, a_spin_in_contact_that_a_step_cannot_be_divided_for_stops_the_run_and_says_so) {
    for (const double spin : {2e6, 2.1e6, 1e12}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        add_plane(scene, Quat::Identity(), material(0.0, 0.3));
        add_box(scene, Vec3::Constant(0.1), {{0, 0, 0.1}, Quat::Identity()}, material(0.0, 0.3));
        scene.bodies[1].name = "nut";
        scene.bodies[1].angular_velocity = Vec3(0, 0, spin);
        try {
            sim::World world(scene);
            EXPECT_LT(spin, 2.048e6);
        } catch (const sim::Error& error) {
            EXPECT_GT(spin, 2.048e6);
            EXPECT_EQ(error.code(), sim::ExitCode::stopped);
            EXPECT_EQ(std::string(error.what()),
                      fmt::format("body 'nut' spins at {:.3g} rad/s in contact or in a joint in step 0, expected at most 2.05e+06 "
                                  "rad/s: 2048 rad a step (contacts)",
                                  spin));
        }
    }
}

/// The same from above, tumbling: an impact of corners and edges at a thousand times their approach.
TEST(law_rotation, a_box_that_falls_with_a_fast_spin_gains_no_energy_and_enters_nothing) {
    for (const auto impacts : {sim::ImpactHandling::stop, sim::ImpactHandling::ahead}) {
        for (const double spin : {700.0, 2000.0}) {
            sim::SceneDef scene = law_scene(microseconds(1000));
            scene.step.impacts = impacts;
            scene.step.tolerance = 1e-6;
            add_plane(scene, Quat::Identity(), material(0.5, 0.3));
            add_box(scene, {0.1, 0.15, 0.05}, {{0, 0, 0.3}, Quat::Identity()}, material(0.5, 0.3));
            scene.bodies[1].angular_velocity = spin * Vec3(0.6, 0.0, 0.8);
            sim::World world(scene);
            const double start = energy(scene, world.take_snapshot());
            int collisions = 0, unconverged = 0;
            run(world, scene, 0.3, [&](const sim::Snapshot& s, const sim::StepReport& report) {
                collisions += report.collisions;
                unconverged += report.at_iteration_limit ? 1 : 0;
                EXPECT_LE(energy(scene, s), start * (1 + 1e-9));
                EXPECT_LE(largest_overlap(scene, s), report.at_iteration_limit ? 1.0 : scene.step.tolerance);
                return true;
            });
            EXPECT_GT(collisions, 0);
            EXPECT_EQ(unconverged, 0) << spin;
        }
    }
}

/// A ball's contact stays where it is however fast it spins: no division, and nothing lost.
TEST(law_rotation, a_ball_with_a_fast_backspin_loses_nothing_in_whole_steps) {
    const double radius = 0.1, mu = 0.3, t = 0.2;
    for (const double spin : {600.0, 9000.0}) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        add_plane(scene, Quat::Identity(), material(0.0, mu));
        add_sphere(scene, radius, {0, 0, radius}, material(0.0, mu));
        scene.bodies[1].angular_velocity = Vec3(0, spin, 0);
        sim::World world(scene);
        sim::Snapshot end;
        run(world, scene, t, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            EXPECT_EQ(report.divisions, 0);
            end = s;
            return true;
        });
        EXPECT_NEAR(end.bodies[1].velocity.x(), mu * g * t, 1e-10); // slides all the time
        EXPECT_NEAR(end.bodies[1].position.x(), 0.5 * mu * g * t * t, 1e-10);
        EXPECT_NEAR(end.bodies[1].angular_velocity.y(), spin - 2.5 * mu * g * t / radius, 1e-8);
    }
}

} // namespace
