/// Chains that a load pulls taut, at the settings that a scene has if it says nothing of them: a rope bridge, a drawbridge. What is
/// light in them is thrown to and fro as fast as whips; no energy comes of it.
#include "tests/laws/law_scene.h"

#include <gtest/gtest.h>

namespace {

using namespace laws;

/// A box of these half extents from `start` to `end`, its axis x along them.
int add_bar(sim::SceneDef& scene, const Vec3& half, const Vec3& start, const Vec3& end, double mass) {
    const Vec3 along = (end - start).normalized();
    return add_box(scene, half, {0.5 * (start + end), sim::rotation_between(Vec3::UnitX(), along)}, {}, mass / (8.0 * half.prod()));
}

void expect_no_gain(const sim::SceneDef& scene, const std::string& law) {
    sim::World world(scene);
    double gain = 0.0;
    run(world, scene, 2.0, [&](const sim::Snapshot&, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        return true;
    });
    record({law, "gain of energy in 2 s, relative", scene.step.time_step.value(), gain, sim::energy_gain_allowed});
    EXPECT_LE(gain, sim::energy_gain_allowed) << law;
}

/// Ten planks of 5 kg, joined at their corners, sag by half a metre; a ball of 100 kg falls on them.
TEST(law_taut, a_ball_falls_on_a_rope_bridge) {
    constexpr int planks = 10;
    constexpr double length = 0.4, width = 1.4, slope = 0.5; // [m], [m], [rad] of the ends
    const double radius = 0.5 * planks * length / slope;
    const auto end_of = [&](int k) -> Vec3 {
        const double angle = slope * (2.0 * k / planks - 1.0);
        return {radius * std::sin(angle), 0, radius * (1.0 - std::cos(angle))};
    };
    sim::SceneDef scene;
    const int frame = add_frame(scene);
    int before = frame;
    const auto hang = [&](int plank, const Vec3& at) {
        for (const double side : {-0.5, 0.5}) {
            add_joint(scene, sim::JointKind::ball, {plank, before}, at + side * width * Vec3::UnitY());
        }
        before = plank;
    };
    for (int k = 0; k < planks; ++k) {
        hang(add_bar(scene, {0.44 * length, 0.5 * width + 0.1, 0.03}, end_of(k), end_of(k + 1), 5.0), end_of(k));
    }
    hang(frame, end_of(planks));
    const double ball = 0.4; // [m]
    add_sphere(scene, ball, {0.3, 0, 0.36 + ball}, {}, 100.0 / (4.0 / 3.0 * pi * ball * ball * ball));
    expect_no_gain(scene, "a ball falls on a rope bridge");
}

/// Of 50 kg, on a hinge and two chains of six links of 1 kg. A box of two tons is dropped on it.
TEST(law_taut, a_load_falls_on_a_drawbridge) {
    constexpr int links = 6;
    sim::SceneDef scene;
    const int post = add_frame(scene);
    const int bridge = add_bar(scene, {1.5, 0.8, 0.05}, {0.05, 0, 2}, {3.05, 0, 2}, 50.0);
    add_joint(scene, sim::JointKind::hinge, {bridge, post}, {0, 0, 2});
    for (const double side : {-0.7, 0.7}) {
        const Vec3 top(0, side, 4.8), bottom(2.8, side, 2.05);
        int before = post;
        for (int k = 0; k < links; ++k) {
            const Vec3 start = top + k * (bottom - top) / links;
            const int link = add_bar(scene, {0.3, 0.02, 0.02}, start, start + (bottom - top) / links, 1.0);
            add_joint(scene, sim::JointKind::ball, {link, before}, start);
            before = link;
        }
        add_joint(scene, sim::JointKind::ball, {bridge, before}, bottom);
    }
    add_box(scene, Vec3::Constant(0.3), {{2, 0.2, 2.55}, Quat::Identity()}, {}, 2000.0 / 0.216);
    expect_no_gain(scene, "a load falls on a drawbridge");
}

} // namespace
