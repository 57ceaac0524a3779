/// The film of the wrecking ball: how fast it is when it hits, against a stiff pendulum; the chain; and what the wall takes.
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

namespace {

using namespace laws;

/// The chain is straight when it is let go, and stays so nearly.
struct StiffPendulum {
    Vec3 hook;
    double moment = 0.0;  ///< of masses about the hook [kg m]
    double inertia = 0.0; ///< [kg m^2]
    double fall = 0.0;    ///< cosine of the angle at which it is let go

    StiffPendulum(const sim::SceneDef& scene, std::size_t link, std::size_t ball) : hook(scene.joints[0].anchor) {
        for (std::size_t i = link; i <= ball; ++i) {
            const sim::BodyDef& body = scene.bodies[i];
            const double length = (body.pose.position - hook).norm();
            moment += body.mass.mass * length;
            inertia += body.mass.mass * length * length + body.mass.inertia(1, 1);
        }
        fall = cosine(scene.bodies[ball].pose.position);
    }
    double cosine(const Vec3& at) const { return (hook.z() - at.z()) / (hook - at).norm(); }
    /// Of the ball there [m/s].
    double speed(const Vec3& at) const {
        return (hook - at).norm() * std::sqrt(2.0 * g * moment * std::max(cosine(at) - fall, 0.0) / inertia);
    }
};

TEST(law_wrecking_ball, it_hits_as_fast_as_it_fell_and_the_wall_takes_what_it_loses) {
    const sim::SceneDef scene = sim::load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / "wrecking_ball.toml");
    const auto find = [&](const char* name) {
        return static_cast<std::size_t>(std::ranges::find(scene.bodies, name, &sim::BodyDef::name) - scene.bodies.begin());
    };
    const std::size_t ball = find("ball");
    const StiffPendulum pendulum(scene, find("link 1"), ball);
    sim::World world(scene);
    const double start = energy(scene, world.take_snapshot());
    double fastest = 0.0, drift = 0.0, error = 0.0, joint_gap = 0.0, gain = 0.0, overlap = 0.0, end = 0.0;
    run(world, scene, 1.3, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        const Vec3& at = s.bodies[ball].position;
        end = s.bodies[ball].velocity.norm();
        if (at.x() < -0.53) { // 5 mm before the wall
            fastest = std::max(fastest, end);
            error = end / pendulum.speed(at) - 1.0;
            drift = std::max(drift, std::abs(energy(scene, s) - start) / (scene.bodies[ball].mass.mass * g));
        }
        joint_gap = std::max(joint_gap, largest_joint_gap(scene, s));
        gain = std::max(gain, report.energy_gain);
        overlap = std::max(overlap, report.max_penetration);
        return true;
    });
    const double h = scene.step.time_step.value();
    record({"film wrecking_ball", "speed as it hits, against a stiff pendulum [-]", h, std::abs(error), 0.01});
    record({"film wrecking_ball", "energy until it hits, as height [m]", h, drift, 1e-4});
    record({"film wrecking_ball", "gap of a joint [m]", h, joint_gap, 1e-6});
    EXPECT_LT(std::abs(error), 0.01);
    EXPECT_LT(drift, 1e-4);
    EXPECT_LT(joint_gap, 1e-6);
    EXPECT_LE(overlap, scene.step.tolerance);
    EXPECT_LT(gain, 1e-3);
    EXPECT_LT(end, 0.85 * fastest);
}

} // namespace
