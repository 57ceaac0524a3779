/// Rest at the settings of the funnel, read from its scene: the solver that is fast there must also stand still there.
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

namespace {

using namespace laws;

sim::SceneDef funnel_settings() {
    sim::SceneDef scene;
    scene.name = "law";
    scene.step = sim::load_scene(TUMBLE_SCENE_DIR "/funnel.toml").step;
    return scene;
}

/// How far the block creeps in `duration` [s], from two seconds on. Put down without the impulses that carry it, it slips
/// at first, and stays there.
void judge_block(double duration) {
    for (const double mu : {0.1, 0.5}) {
        sim::SceneDef scene = funnel_settings();
        const Quat turn(Eigen::AngleAxisd(0.99 * std::atan(mu), Vec3::UnitY()));
        add_plane(scene, turn, material(0.48, mu));
        add_box(scene, Vec3::Constant(0.5), {turn * Vec3(0, 0, 0.5), turn}, material(0.48, mu));
        sim::World world(scene);
        double crept = 0.0, slipped = 0.0;
        Vec3 start = scene.bodies[1].pose.position;
        run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport&) {
            const Vec3& position = s.bodies[1].position;
            slipped = std::max(slipped, (position - scene.bodies[1].pose.position).norm());
            start = s.time <= 2.0 ? position : start;
            crept = std::max(crept, std::abs((position - start).dot(turn * Vec3::UnitX())));
            return true;
        });
        const std::string name = fmt::format("funnel's settings, block at 99 %, mu {}", mu);
        record({name, "slip when put down [m]", 1e-3, slipped, no_value});
        record({name, fmt::format("creep from 2 to {} s [m]", duration), 1e-3, crept, 1e-6});
        EXPECT_LT(crept, 1e-6) << "mu " << mu;
        EXPECT_LT(slipped, scene.step.tolerance) << "mu " << mu;
    }
}

TEST(law_funnel_settings, a_block_at_99_percent_of_the_friction_angle_does_not_creep) {
    judge_block(5.0);
}

TEST(law_funnel_settings, DISABLED_a_block_at_99_percent_of_the_friction_angle_does_not_creep_in_a_minute) {
    judge_block(60.0);
}

/// Cubes on each other, each put down without the impulses that carry it, or dropped by `gap` [m] onto the one below: how far any
/// is at most from where it is to stand, once a second has passed, and the fastest at the half step in the last half second.
void judge_tower(int count, double gap, double duration) {
    for (const double mu : {0.1, 0.5}) {
        sim::SceneDef scene = funnel_settings();
        add_plane(scene, Quat::Identity(), material(0.48, mu));
        for (int i = 0; i < count; ++i) {
            add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5 + i + (i + 1) * gap}, Quat::Identity()}, material(0.48, mu));
        }
        sim::World world(scene);
        sim::Snapshot before = world.take_snapshot();
        double drift = 0.0, fastest = 0.0;
        const double h = scene.step.time_step.value();
        run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            EXPECT_FALSE(report.at_iteration_limit);
            for (std::size_t i = 1; i < s.bodies.size(); ++i) {
                const double away = (s.bodies[i].position - Vec3(0, 0, static_cast<double>(i) - 0.5)).norm();
                drift = s.time > 1.0 ? std::max(drift, away) : 0.0;
                const double speed = (s.bodies[i].position - before.bodies[i].position).norm() / h;
                fastest = s.time > duration - 0.5 ? std::max(fastest, speed) : 0.0;
            }
            before = s;
            return true;
        });
        // Each gap may be as large as the tolerance where it is closed by a fall.
        const double allowed = gap > 0.0 ? count * scene.step.tolerance : 1e-4;
        const std::string name = fmt::format("funnel's settings, tower of {}, mu {}, gaps of {} m", count, mu, gap);
        record({name, fmt::format("drift in {} s [m]", duration), 1e-3, drift, allowed});
        record({name, fmt::format("fastest at the half step after {} s [m/s]", duration), 1e-3, fastest, 1e-4});
        EXPECT_LT(drift, allowed) << name;
        EXPECT_LT(fastest, 1e-4) << name;
    }
}

TEST(law_funnel_settings, towers_of_20_and_40_stand_still) {
    judge_tower(20, 0.0, 3.0);
    judge_tower(40, 0.0, 3.0);
}

TEST(law_funnel_settings, towers_whose_cubes_fall_by_a_millimetre_come_to_rest) {
    judge_tower(20, 1e-3, 4.0);
    judge_tower(40, 1e-3, 4.0);
}

/// Once it stands, what a step took from the velocities is in the next one's guess, and must be too little to be swept again.
TEST(law_funnel_settings, a_tower_that_stands_is_swept_once_a_step) {
    for (const double tolerance : {funnel_settings().step.velocity_tolerance, 1e-7}) {
        sim::SceneDef scene = funnel_settings();
        scene.step.velocity_tolerance = tolerance;
        add_plane(scene, Quat::Identity(), material(0.0, 0.5));
        for (int i = 0; i < 60; ++i) {
            add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5 + i}, Quat::Identity()}, material(0.0, 0.5));
        }
        sim::World world(scene);
        int steps = 0, sweeps = 0;
        run(world, scene, 2.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            steps += s.time > 1.0 ? 1 : 0;
            sweeps += s.time > 1.0 ? report.contact_iterations : 0;
            return true;
        });
        const double taken = static_cast<double>(sweeps) / steps;
        record({fmt::format("funnel's settings at {:g} m/s, tower of 60", tolerance), "sweeps a step at rest", 1e-3, taken, 1.5});
        EXPECT_LE(taken, 1.5) << tolerance;
    }
}

/// Where each active set takes up one more box, none of a solve takes up all, and the tower sinks.
TEST(law_funnel_settings, a_tower_that_is_put_down_is_borne_at_once) {
    for (const int count : {20, 40, 100}) {
        sim::SceneDef scene = funnel_settings();
        add_plane(scene, Quat::Identity(), material(0.0, 0.5));
        for (int i = 0; i < count; ++i) {
            add_box(scene, Vec3::Constant(0.5), {{0, 0, 0.5 + i}, Quat::Identity()}, material(0.0, 0.5));
        }
        sim::World world(scene);
        int sweeps = 0; // of ten steps
        double fastest = 0.0;
        run(world, scene, 0.01, [&](const sim::Snapshot& s, const sim::StepReport& report) {
            sweeps += report.contact_iterations;
            fastest = std::max(fastest, s.bodies.back().velocity.norm());
            return true;
        });
        const std::string name = fmt::format("funnel's settings, tower of {} put down", count);
        record({name, "sweeps of ten steps", 1e-3, static_cast<double>(sweeps), 15.0});
        record({name, "fastest in them [m/s]", 1e-3, fastest, 1e-6});
        EXPECT_LE(sweeps, 15) << name;
        EXPECT_LE(fastest, 1e-6) << name;
    }
}

TEST(law_funnel_settings, DISABLED_towers_of_20_and_40_stand_still_for_a_minute) {
    judge_tower(20, 0.0, 60.0);
    judge_tower(40, 0.0, 60.0);
}

/// `count` cubes let fall as a loose block of 5 x 5 a layer.
sim::SceneDef pile_scene(int count, unsigned seed) {
    sim::SceneDef scene = funnel_settings();
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const sim::MaterialDef surface = material(0.48, 0.5);
    add_plane(scene, Quat::Identity(), surface);
    for (int i = 0; i < count; ++i) {
        const Vec3 axis = Vec3(uniform(random), uniform(random), uniform(random)).normalized();
        const Vec3 at(1.3 * (i % 5), 1.3 * (i / 5 % 5), 1.0 + 1.3 * (i / 25));
        add_box(scene, Vec3::Constant(0.5), {at, Quat(Eigen::AngleAxisd(0.2 * uniform(random), axis))}, surface);
    }
    return scene;
}

/// The fastest at the half step within the last half second of `duration` [s].
double fastest_at_the_end(const std::string& what, const sim::SceneDef& scene, double duration) {
    sim::World world(scene);
    sim::Snapshot before;
    double fastest = 0.0, overlap = 0.0;
    const double h = scene.step.time_step.value();
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        if (s.step % 10 == 0 && !report.at_iteration_limit) {
            overlap = std::max(overlap, largest_overlap(scene, s));
        }
        for (std::size_t i = 1; i < s.bodies.size() && s.time > duration - 0.5; ++i) {
            fastest = std::max(fastest, (s.bodies[i].position - before.bodies[i].position).norm() / h);
        }
        before = s;
        return true;
    });
    record({"funnel's settings, pile of " + what, fmt::format("fastest at the half step after {} s [m/s]", duration), 1e-3,
            fastest, 1e-4});
    EXPECT_LE(overlap, 1e-4 + 1e-9) << what;
    return fastest;
}

/// Piles of 100: in all but `restless` of them nothing moves after 20 s.
void judge_piles(unsigned seeds, int restless) {
    int moving = 0;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        const double fastest = fastest_at_the_end(fmt::format("100 cubes, seed {}", seed), pile_scene(100, seed), 20.0);
        moving += fastest < 1e-4 ? 0 : 1;
        EXPECT_LT(fastest, 1e-2) << seed;
    }
    EXPECT_LE(moving, restless);
}

TEST(law_funnel_settings, a_pile_of_100_cubes_comes_to_rest) {
    judge_piles(1, 0);
}

/// A cube that hangs by an edge may take longer.
TEST(law_funnel_settings, DISABLED_twenty_piles_of_100_cubes_come_to_rest) {
    judge_piles(20, 1);
}

} // namespace
