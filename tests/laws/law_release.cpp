/// Bodies that are released: their flights, what they bring, and that what is poured comes to rest.
#include "sim/base/error.h"
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace {

using namespace laws;

sim::BodyDef& body_of(sim::SceneDef& scene, int index) {
    return scene.bodies[static_cast<std::size_t>(index)];
}

/// Balls out of one place, each thrown another way through the places of all that still wait: nothing touches.
TEST(law_release, each_flight_begins_with_its_release_and_is_exact) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    sim::Random random(5);
    for (int i = 0; i < 40; ++i) {
        sim::BodyDef& ball = body_of(scene, add_sphere(scene, 0.05, {0, 0, 1}));
        ball.release = 50 * i / 1000.0; // the end of a step, to the last bit
        ball.velocity = Vec3(2 * std::cos(2.4 * i), 2 * std::sin(2.4 * i), between(random, 4, 5));
        ball.angular_velocity = Vec3(0, 0, between(random, -9, 9));
    }
    sim::World world(scene);
    double path = 0.0, turn = 0.0, moved = 0.0, gain = 0.0, momentum_error = 0.0;
    run(world, scene, 2.5, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        Vec3 total = Vec3::Zero();
        for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
            const sim::BodyDef& ball = scene.bodies[i];
            const double t = std::max(s.time - ball.release, 0.0);
            const Vec3 place = ball.pose.position + t * ball.velocity + 0.5 * t * t * scene.step.gravity;
            const double error = (s.bodies[i].position - place).norm();
            (t > 0.0 ? path : moved) = std::max(t > 0.0 ? path : moved, error);
            const Quat turned(Eigen::AngleAxisd(t * ball.angular_velocity.z(), Vec3::UnitZ()));
            turn = std::max(turn, 2.0 * (turned * s.bodies[i].orientation.conjugate()).vec().norm());
            if (s.time >= ball.release) {
                total += ball.mass.mass * (ball.velocity + t * scene.step.gravity);
            }
        }
        momentum_error = std::max(momentum_error, (mechanics(scene, s).momentum - total).norm() / total.norm());
        return true;
    });
    record({"40 balls released one by one", "path [m]", 1e-3, path, 1e-11});
    record({"40 balls released one by one", "momentum, relative", 1e-3, momentum_error, 1e-12});
    EXPECT_LT(path, 1e-11);
    EXPECT_LT(turn, 1e-11);
    EXPECT_EQ(moved, 0.0);
    EXPECT_LT(momentum_error, 1e-12);
    EXPECT_LT(gain, 1e-12);
}

/// A box and a ball on it that are let fall later do what they would have done at once.
TEST(law_release, a_release_is_a_beginning) {
    const auto heap = [](double release) {
        sim::SceneDef scene = law_scene(microseconds(1000));
        const sim::MaterialDef surface = material(0.3, 0.4);
        add_plane(scene, Quat::Identity(), surface);
        add_box(scene, {0.2, 0.2, 0.2}, {{0, 0, 0.25}, Quat::Identity()}, surface);
        body_of(scene, add_sphere(scene, 0.1, {0.05, 0, 0.6}, surface)).velocity = Vec3(0.5, 0, 0);
        body_of(scene, 1).release = body_of(scene, 2).release = release;
        return scene;
    };
    const double release = 0.25, duration = 0.6;
    const sim::Snapshot at_once = run_to(heap(0.0), duration);
    const sim::Snapshot later = run_to(heap(release), release + duration);
    for (std::size_t i = 0; i < at_once.bodies.size(); ++i) {
        EXPECT_LT((at_once.bodies[i].position - later.bodies[i].position).norm(), 1e-6) << i;
        EXPECT_LT((at_once.bodies[i].velocity - later.bodies[i].velocity).norm(), 1e-5) << i;
    }
}

/// Layers of cubes into a tub: they come to rest in it.
TEST(law_release, what_is_poured_comes_to_rest) {
    sim::SceneDef scene = law_scene(microseconds(2000));
    scene.step.tolerance = 1e-4;
    scene.step.velocity_tolerance = 1e-3;
    const sim::MaterialDef surface = material(0.2, 0.4);
    add_plane(scene, Quat::Identity(), surface);
    for (const double side : {-1.0, 1.0}) {
        for (const Vec3& out : {Vec3(side, 0, 0), Vec3(0, side, 0)}) {
            const int wall = add_box(scene, Vec3(0.2, 0.2, 0.3) - 0.15 * out.cwiseAbs(), {0.25 * out + Vec3(0, 0, 0.3)}, surface);
            body_of(scene, wall).mass = {};
        }
    }
    const int first = static_cast<int>(scene.bodies.size());
    for (int k = 0; k < 12; ++k) {
        for (const double x : {-0.06, 0.0601}) {
            const Vec3 at(x + 0.03 * std::sin(k), 0.08 * std::cos(2.0 * k), 0.7); // so that no columns grow
            body_of(scene, add_box(scene, Vec3::Constant(0.045), {at}, surface)).release = 0.16 * k;
        }
    }
    sim::World world(scene);
    double gain = 0.0, overlap = 0.0, speed = 0.0;
    run(world, scene, 3.0, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        overlap = std::max(overlap, report.max_penetration);
        speed = 0.0;
        for (std::size_t i = static_cast<std::size_t>(first); i < s.bodies.size(); ++i) {
            speed = std::max(speed, s.bodies[i].velocity.norm());
            EXPECT_LT(s.bodies[i].position.head<2>().cwiseAbs().maxCoeff(), 0.2);
        }
        return !testing::Test::HasFailure();
    });
    record({"24 cubes poured into a tub", "speed after 3 s [m/s]", 2e-3, speed, 5e-3});
    record({"24 cubes poured into a tub", "gain of energy [-]", 2e-3, gain, no_value});
    EXPECT_LT(speed, 5e-3);
    EXPECT_LE(overlap, scene.step.tolerance);
}

TEST(law_release, a_place_that_is_taken_ends_the_run) {
    sim::SceneDef scene = law_scene(microseconds(1000));
    add_plane(scene);
    add_sphere(scene, 0.5, {0, 0, 0.5});
    body_of(scene, add_sphere(scene, 0.5, {0, 0, 1.25})).release = 0.1;
    try {
        run_to(scene, 0.2);
        ADD_FAILURE() << "no error";
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::stopped);
        EXPECT_NE(std::string(error.what()).find("is released at 0.1 s, but '"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("is in its place, 0.25 m deep"), std::string::npos) << error.what();
    }
}

/// The film: of three hundred balls none is left among the pins, and they heap up as Galton's do, most in the middle.
TEST(law_release, DISABLED_the_board_makes_a_bell) {
    const sim::SceneDef scene = sim::load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / "galton.toml");
    sim::World world(scene);
    double gain = 0.0;
    sim::Snapshot end;
    run(world, scene, scene.output.duration.value(), [&](const sim::Snapshot& s, const sim::StepReport& report) {
        gain = std::max(gain, report.energy_gain);
        EXPECT_LE(report.max_penetration, scene.step.tolerance);
        end = s;
        return true;
    });
    std::array<int, 3> thirds{};
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (!scene.bodies[i].is_static()) {
            EXPECT_LT(end.bodies[i].position.z(), 0.38) << scene.bodies[i].name;
            ++thirds[static_cast<std::size_t>((end.bodies[i].position.x() + 0.24) / 0.16)];
        }
    }
    record({"film galton", "gain of energy [-]", 1e-3, gain, 1e-3});
    record({"film galton", "balls in the middle third of the bins", 1e-3, static_cast<double>(thirds[1]), no_value});
    EXPECT_GT(thirds[1], 2 * std::max(thirds[0], thirds[2]));
    EXPECT_LT(gain, 1e-3);
}

/// Of balls wedged between two pins, by one that did not bear a load before, no velocity is told that they do not have.
TEST(law_release, DISABLED_the_board_gains_no_energy_at_other_steps) {
    for (const int per_second : {987, 993, 1004}) {
        sim::SceneDef scene = sim::load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / "galton.toml");
        scene.step.time_step = {1, per_second};
        sim::World world(scene);
        double gain = 0.0;
        run(world, scene, 8.0, [&](const sim::Snapshot&, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            return true;
        });
        record({fmt::format("film galton at 1/{} s", per_second), "gain of energy [-]", 1.0 / per_second, gain, 1e-3});
        EXPECT_LT(gain, 1e-3) << per_second;
    }
}

} // namespace
