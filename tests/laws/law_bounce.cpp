/// Rebounds: heights fall by e^2 each, and the end of the bouncing is rest.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

sim::SceneDef ball_scene(Rational h, double e, double height, sim::ImpactHandling impacts) {
    sim::SceneDef scene = law_scene(h);
    scene.step.impacts = impacts;
    add_plane(scene, Quat::Identity(), material(e, 0.0));
    add_sphere(scene, 0.1, {0, 0, 0.1 + height}, material(e, 0.0));
    return scene;
}

/// Apex above the floor [m] of each flight, from the height and the speed of an instant in the middle of it.
std::vector<double> apexes(const sim::SceneDef& scene, double rest, double duration) {
    std::vector<double> found;
    sim::World world(scene);
    double v_before = 0.0;
    bool rising = false;
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
        const double v = s.bodies[1].velocity.z(), z = s.bodies[1].position.z() - rest;
        rising = rising || v > std::max(0.0, v_before);
        if (rising && v <= 0.0) {
            found.push_back(z + v * v / (2 * g));
            rising = false;
        }
        v_before = v;
        return true;
    });
    return found;
}

double worst_rebound_error(Rational h, double e, sim::ImpactHandling impacts) {
    const double height = 1.0;
    const std::vector<double> found = apexes(ball_scene(h, e, height, impacts), 0.1, 10.0);
    double worst = found.size() < 10 ? 1.0 : 0.0;
    for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), 10); ++i) {
        const double expected = height * std::pow(e, 2.0 * static_cast<double>(i + 1));
        worst = std::max(worst, std::abs(found[i] / expected - 1.0));
    }
    return worst;
}

TEST(law_bounce, ten_rebounds_reach_e_squared) {
    for (double e : {0.7, 0.8, 0.9, 1.0}) {
        for (const Rational h : {microseconds(10000), microseconds(1000)}) {
            // 0.7^20 of 1 m is 0.8 mm, struck at 0.13 m/s: above the resting threshold of 0.044 m/s.
            const double stopped = worst_rebound_error(h, e, sim::ImpactHandling::stop);
            record({"bounce, e " + std::to_string(e).substr(0, 3) + ", impacts stopped",
                    "ten heights, relative", h.value(), stopped, 1e-6});
            EXPECT_LT(stopped, 1e-6) << "e " << e << " h " << h.value();
        }
        // Contacts placed ahead: the touch is up to a step early, at a height of up to v h, so that each
        // bounce may gain or lose g v h of v^2 / 2, and the last of the ten have v of 0.2 m/s: stated, and
        // bounded at 1 ms.
        const double ahead = worst_rebound_error(microseconds(1000), e, sim::ImpactHandling::ahead);
        record({"bounce, e " + std::to_string(e).substr(0, 3) + ", contacts ahead", "ten heights, relative",
                1e-3, ahead, no_value});
        EXPECT_LT(ahead, 0.2) << "e " << e;
    }
}

/// Time of the k-th touch: the first fall, then flights of 2 e^i v0 / g.
TEST(law_bounce, the_touches_come_at_the_times_of_the_closed_form) {
    const double e = 0.8, height = 1.0, v0 = std::sqrt(2 * g * height);
    const sim::SceneDef scene = ball_scene(microseconds(1000), e, height, sim::ImpactHandling::stop);
    double touch = v0 / g, v = v0;
    for (int k = 1; k <= 8; ++k) {
        v *= e;
        const double middle = touch + v / g; // apex of the flight after the k-th touch
        const double t = std::floor(middle / 1e-3) * 1e-3;
        const sim::Snapshot s = run_to(scene, t);
        const double expected = 0.1 + v * (s.time - touch) - 0.5 * g * (s.time - touch) * (s.time - touch);
        EXPECT_NEAR(s.bodies[1].position.z(), expected, 1e-6) << "flight " << k;
        touch += 2 * v / g;
    }
}

TEST(law_bounce, the_end_of_bouncing_is_rest_without_sinking) {
    for (const auto impacts : {sim::ImpactHandling::stop, sim::ImpactHandling::ahead}) {
        for (const Rational h : {microseconds(1000), microseconds(10000)}) {
            const sim::SceneDef scene = ball_scene(h, 0.6, 0.5, impacts);
            sim::World world(scene);
            Vec3 before = Vec3::Zero();
            double fastest = 0.0, deepest = 0.0;
            run(world, scene, 5.0, [&](const sim::Snapshot& s, const sim::StepReport&) {
                deepest = std::max(deepest, 0.1 - s.bodies[1].position.z());
                if (s.time > 4.0) {
                    fastest = std::max(fastest, (s.bodies[1].position - before).norm() / h.value());
                    EXPECT_LE(std::abs(s.bodies[1].position.z() - 0.1), scene.step.tolerance);
                }
                before = s.bodies[1].position;
                return true;
            });
            const std::string name = std::string("end of bouncing, ") +
                                     (impacts == sim::ImpactHandling::stop ? "impacts stopped" : "contacts ahead");
            record({name, "speed at the half step from 4 to 5 s [m/s]", h.value(), fastest, 1e-9});
            record({name, "deepest in 5 s [m]", h.value(), deepest, scene.step.tolerance});
            EXPECT_LT(fastest, 1e-9) << "h " << h.value();
            EXPECT_LE(deepest, scene.step.tolerance) << "h " << h.value();
        }
    }
}

TEST(law_bounce, a_cube_with_e_048_comes_to_rest_at_40_ms) {
    for (const auto impacts : {sim::ImpactHandling::stop, sim::ImpactHandling::ahead}) {
        sim::SceneDef scene = law_scene(microseconds(40000));
        scene.step.impacts = impacts;
        scene.step.tolerance = 1e-6;
        scene.step.velocity_tolerance = 1e-6;
        add_plane(scene, Quat::Identity(), material(0.48, 0.1));
        add_box(scene, Vec3::Constant(0.5), {{0, 0, 1.0}, Quat::Identity()}, material(0.48, 0.1));
        const sim::Snapshot before = run_to(scene, 9.96), after = run_to(scene, 10.0);
        EXPECT_NEAR(after.bodies[1].position.z(), 0.5, 1e-6);
        EXPECT_NEAR((after.bodies[1].position - before.bodies[1].position).norm() / 0.04, 0.0, 1e-9);
        EXPECT_NEAR(after.bodies[1].orientation.angularDistance(Quat::Identity()), 0.0, 1e-6);
    }
}

/// A cube that lands flat has four equal contacts; it must rebound flat, at e times its speed.
TEST(law_bounce, a_flat_cube_rebounds_flat) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    scene.step.impacts = sim::ImpactHandling::stop;
    const double e = 0.48, height = 2.0;
    add_plane(scene, Quat::Identity(), material(e, 0.1));
    add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5 + height}, Quat::Identity()}, material(e, 0.1));
    const std::vector<double> found = apexes(scene, 0.5, 2.5);
    ASSERT_GE(found.size(), 4u);
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(found[i] / (height * std::pow(e, 2.0 * (i + 1))), 1.0, 1e-6) << "bounce " << i;
    }
    EXPECT_NEAR(run_to(scene, 1.5).bodies[1].angular_velocity.norm(), 0.0, 1e-9);
}

} // namespace
