/// Impacts of spheres and boxes against their closed forms; momentum and energy.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

#include <random>

namespace {

using namespace laws;

sim::SceneDef weightless_scene(Rational h) {
    sim::SceneDef scene = law_scene(h);
    scene.step.gravity = Vec3::Zero();
    scene.step.impacts = sim::ImpactHandling::stop;
    return scene;
}

TEST(law_impact, two_spheres_head_on_for_three_restitutions_and_unequal_masses) {
    for (const double e : {0.0, 0.5, 1.0}) {
        for (const double ratio : {1.0, 0.3, 7.0}) {
            for (const auto impacts : {sim::ImpactHandling::stop, sim::ImpactHandling::ahead}) {
                sim::SceneDef scene = weightless_scene(microseconds(1000));
                scene.step.impacts = impacts;
                add_sphere(scene, 0.1, {0, 0, 0}, material(e, 0.2), 1000.0);
                add_sphere(scene, 0.1, {0.25, 0, 0}, material(e, 0.2), 1000.0 * ratio);
                scene.bodies[0].velocity = Vec3(2, 0, 0);
                scene.bodies[1].velocity = Vec3(-1, 0, 0);
                const sim::Snapshot end = run_to(scene, 0.1);
                const double m0 = 1.0, m1 = ratio, common = (2 * m0 - m1) / (m0 + m1);
                const double v0 = common - e * 3.0 * m1 / (m0 + m1), v1 = common + e * 3.0 * m0 / (m0 + m1);
                // One impulse in closed form: a few roundings, and the tolerance of the solve.
                EXPECT_NEAR(end.bodies[0].velocity.x(), v0, 1e-10) << e << " " << ratio;
                EXPECT_NEAR(end.bodies[1].velocity.x(), v1, 1e-10) << e << " " << ratio;
                EXPECT_NEAR(end.bodies[0].velocity.tail<2>().norm(), 0.0, 1e-12);
                // The touch is at 0.05 m / 3 m/s; stopped at its time, the positions are those of the closed
                // form.
                const double touch = 0.05 / 3.0, exact = 2 * touch + v0 * (0.1 - touch);
                const double error = std::abs(end.bodies[0].position.x() - exact);
                EXPECT_LT(error, impacts == sim::ImpactHandling::stop ? 1e-8 : 3.0 * 1e-3);
                if (ratio == 0.3 && e == 0.5) {
                    record({impacts == sim::ImpactHandling::stop ? "two spheres, impacts stopped"
                                                                 : "two spheres, ahead",
                            "position after the impact [m]", 1e-3, error,
                            impacts == sim::ImpactHandling::stop ? 1e-8 : no_value});
                }
            }
        }
    }
}

/// A sphere meets a plane with normal speed v_n, tangential velocity v_t and spin w about the horizontal axis
/// across it. Impulses: p_n = (1 + e) m v_n; to stop the slip u = v_t - w R takes 2/7 m u; friction gives it
/// if it is below mu p_n.
TEST(law_impact, oblique_sphere_on_a_plane_sticks_or_slips_as_the_closed_form) {
    const double radius = 0.1, v_n = 2.0;
    int stuck = 0, slipped = 0;
    double worst_stuck = 0.0, worst_slipped = 0.0; // [m/s]
    for (const double e : {0.0, 0.6, 1.0}) {
        for (const double mu : {0.0, 0.1, 0.4}) {
            for (const double v_t : {0.3, 1.5, 6.0}) {
                for (const double w : {0.0, 30.0, -30.0}) {
                    sim::SceneDef scene = weightless_scene(microseconds(1000));
                    add_plane(scene, Quat::Identity(), material(e, mu));
                    add_sphere(scene, radius, {0, 0, radius + 0.01}, material(e, mu));
                    scene.bodies[1].velocity = Vec3(v_t, 0, -v_n);
                    scene.bodies[1].angular_velocity = Vec3(0, w, 0);
                    const sim::Snapshot end = run_to(scene, 0.02);
                    const double slip = v_t - w * radius, needed = 2.0 / 7.0 * std::abs(slip);
                    const double given =
                        std::min(needed, mu * (1 + e) * v_n) * (slip > 0.0 ? -1.0 : 1.0); // [m/s]
                    (needed <= mu * (1 + e) * v_n ? stuck : slipped) += 1;
                    EXPECT_NEAR(end.bodies[1].velocity.z(), e * v_n, 1e-10);
                    if (e > 0.0) { // with e = 0 it stays on the plane and goes on to slip without weight: the
                                   // same
                        const double error = std::max(std::abs(end.bodies[1].velocity.x() - v_t - given),
                                                      std::abs(end.bodies[1].velocity.z() - e * v_n));
                        double& worst = needed <= mu * (1 + e) * v_n ? worst_stuck : worst_slipped;
                        worst = std::max(worst, error);
                        EXPECT_NEAR(end.bodies[1].velocity.x(), v_t + given, 1e-10)
                            << e << " " << mu << " " << v_t;
                        EXPECT_NEAR(end.bodies[1].angular_velocity.y(), w - 2.5 * given / radius, 1e-8);
                    }
                }
            }
        }
    }
    record({"sphere in oblique impacts, sticking", "velocity after [m/s]", 1e-3, worst_stuck, 1e-10});
    record({"sphere in oblique impacts, slipping", "velocity after [m/s]", 1e-3, worst_slipped, 1e-10});
    EXPECT_GT(stuck, 10);
    EXPECT_GT(slipped, 10);
}

/// Two equal spheres meet off centre; along the line of centres as head on, across it by friction.
TEST(law_impact, oblique_spheres_exchange_the_closed_form_impulse) {
    const double radius = 0.1, e = 0.7;
    for (const double mu : {0.0, 0.05, 0.5}) {
        const double offset = 0.12; // [m] between the lines of flight
        sim::SceneDef scene = weightless_scene(microseconds(1000));
        add_sphere(scene, radius, {0, 0, 0}, material(e, mu));
        add_sphere(scene, radius, {0.3, offset, 0}, material(e, mu));
        scene.bodies[0].velocity = Vec3(2, 0, 0);
        const double mass = scene.bodies[0].mass.mass;
        const sim::Snapshot end = run_to(scene, 0.2);
        const double sine = offset / (2 * radius), cosine = std::sqrt(1 - sine * sine);
        const Vec3 n(-cosine, -sine, 0), t(sine, -cosine, 0); // from 1 to 0, and across
        const Vec3 u(2, 0, 0);
        const double p_n = -(1 + e) * u.dot(n) * mass / 2;
        const double needed = u.dot(t) * mass / 7; // t K t = 2 (1/m + R^2 / (2/5 m R^2)) = 7 / m
        const double p_t = -std::min(needed, mu * p_n);
        const Vec3 p = p_n * n + p_t * t;
        EXPECT_NEAR((end.bodies[0].velocity - (u + p / mass)).norm(), 0.0, 1e-6);
        EXPECT_NEAR((end.bodies[1].velocity + p / mass).norm(), 0.0, 1e-6);
        const double inertia = 0.4 * mass * radius * radius;
        EXPECT_NEAR((end.bodies[0].angular_velocity - (-radius * n).cross(p) / inertia).norm(), 0.0, 1e-5);
    }
}

TEST(law_impact, tumbling_boxes_keep_momentum_and_angular_momentum) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const auto vector = [&](double scale) {
        return Vec3(scale * uniform(random), scale * uniform(random), scale * uniform(random));
    };
    for (int i = 0; i < 20; ++i) {
        sim::SceneDef scene = weightless_scene(microseconds(1000));
        const double e = 0.5 + 0.5 * uniform(random), mu = 0.5 + 0.5 * uniform(random);
        add_box(scene, {0.3, 0.2, 0.4}, {{-0.8, 0, 0}, Quat::UnitRandom()}, material(e, mu));
        add_box(scene, {0.2, 0.5, 0.3}, {{0.8, 0.1, 0.2}, Quat::UnitRandom()}, material(e, mu));
        for (int b = 0; b < 2; ++b) {
            const Vec3 axis = vector(1.0);
            scene.bodies[b].pose.orientation =
                Quat(Eigen::AngleAxisd(3.0 * uniform(random), axis.normalized()));
            scene.bodies[b].velocity = vector(0.5) + Vec3(b == 0 ? 2 : -2, 0, 0);
            scene.bodies[b].angular_velocity = vector(3.0);
        }
        sim::World world(scene);
        const sim::Snapshot start = world.take_snapshot();
        int collisions = 0;
        sim::Snapshot end;
        double energy_before = energy(scene, start);
        run(world, scene, 1.5, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            collisions += report.collisions;
            // Without weight nothing but an impact changes the energy, and that never up: rounding of 1e-16 a
            // step, and the order-two error of free rotation.
            EXPECT_LE(energy(scene, s), energy_before * (1 + 1e-7))
                << "case " << i << " e " << e << " mu " << mu;
            energy_before = energy(scene, s);
            end = s;
            return true;
        });
        const double scale = momentum(scene, start).norm() + scene.bodies[0].mass.mass;
        EXPECT_NEAR((momentum(scene, end) - momentum(scene, start)).norm() / scale, 0.0, 1e-11);
        EXPECT_NEAR((angular_momentum(scene, end) - angular_momentum(scene, start)).norm() / scale, 0.0,
                    1e-6);
        EXPECT_GT(collisions, 0) << "case " << i;
    }
}

/// Newton's law with friction can add energy; a tilted cube with e = 1 and mu = 0.1 is known to gain 1.8 % if
/// nothing is done. The energy after an impact may not exceed the energy before it, whatever the pose and the
/// friction.
TEST(law_impact, an_oblique_impact_never_adds_energy) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    double most_gained = 0.0;
    for (int i = 0; i < 200; ++i) {
        const double e = i % 2 == 0 ? 1.0 : 0.6 + 0.4 * uniform(random),
                     mu = 0.1 + 0.5 * std::abs(uniform(random));
        for (const auto impacts : {sim::ImpactHandling::stop, sim::ImpactHandling::ahead}) {
            std::mt19937_64 pose(1000 + i);
            sim::SceneDef scene = weightless_scene(microseconds(1000));
            scene.step.impacts = impacts;
            add_plane(scene, Quat::Identity(), material(e, mu));
            const auto vector = [&](double scale) {
                return Vec3(scale * uniform(pose), scale * uniform(pose), scale * uniform(pose));
            };
            const Quat turn(Eigen::AngleAxisd(3.0 * uniform(pose), vector(1.0).normalized()));
            add_box(scene, Vec3::Constant(0.5), {{0, 0, 1.0}, turn}, material(e, mu));
            scene.bodies[1].velocity = vector(4.0) + Vec3(0, 0, -5);
            scene.bodies[1].angular_velocity = vector(2.0);
            const double before = energy(scene, sim::World(scene).take_snapshot());
            const double after = energy(scene, run_to(scene, 0.5));
            most_gained = std::max(most_gained, after / before - 1.0);
            // A cube's rotation is free of the gyroscopic term, so no integration error hides here.
            EXPECT_LT(after / before - 1.0, 1e-9) << "case " << i << " e " << e << " mu " << mu;
        }
    }
    record({"oblique impacts of a cube", "largest gain of energy, relative", 1e-3, most_gained, 1e-9});
}

TEST(law_impact, a_block_at_rest_that_is_struck_slides_and_comes_to_rest_again) {
    sim::SceneDef scene = law_scene(microseconds(250));
    scene.step.tolerance = 1e-6;
    add_plane(scene, Quat::Identity(), material(0.0, 0.3));
    const int struck = add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5}, Quat::Identity()}, material(0.0, 0.3));
    const int other = add_box(scene, Vec3::Constant(0.5), {{-1.2, 0.45, 0.5}, Quat::Identity()}, material(0.0, 0.3));
    scene.bodies[static_cast<std::size_t>(other)].velocity = Vec3(1.8, 0, 0);
    // Both have stopped by mu g t = 1.8 m/s, t = 0.61 s.
    sim::World world(scene);
    double moved = 0.0, speed = 0.0;
    run(world, scene, 1.2, [&](const sim::Snapshot& s, const sim::StepReport&) {
        const sim::BodySnapshot& body = s.bodies[static_cast<std::size_t>(struck)];
        moved = body.position.x();
        speed = s.time > 0.9 ? std::max(speed, body.velocity.norm()) : 0.0;
        return true;
    });
    EXPECT_GT(moved, 0.05);
    record({"block struck off its centre", "largest speed once it has stopped [m/s]", 2.5e-4, speed, 1e-9});
    EXPECT_LT(speed, 1e-9);
}

} // namespace
