/// Motion that is asked to be within a length of the true one: held against closed forms, and against runs that are finer.
#include "render/study/law.h"
#include "tests/support/accuracy_search.h"

#include <gtest/gtest.h>

namespace {

using namespace study;

std::string scene_file(const std::string& name) {
    return std::string(TUMBLE_SCENE_DIR) + "/" + name + ".toml";
}

double error_by_law(const test::SearchedRun& run) {
    std::vector<double> times;
    for (const sim::Snapshot& state : run.motion.states) {
        times.push_back(state.time);
    }
    const Motion truth = law_motion(run.scene, sim::study_of(run.scene).law, times);
    return difference(run.scene, run.motion, truth).rms;
}

constexpr double asked_for[] = {1e-3, 1e-4, 1e-5, 1e-6}; // [m]

TEST(accuracy, is_reached_where_the_motion_has_a_closed_form) {
    for (const char* name : {"sliding_block", "bouncing_ball", "rolling_ball", "tower", "free_rotation"}) {
        const std::string file = scene_file(std::string("laws/") + name);
        for (const double asked : asked_for) {
            AccuracySearch search(sim::load_scene(file), asked);
            const test::SearchedRun run = test::search(file, search);
            EXPECT_EQ(search.end(), AccuracyEnd::reached) << name << " " << asked;
            EXPECT_LE(search.estimate(), asked) << name << " " << asked;
            EXPECT_LE(error_by_law(run), asked) << name;
        }
    }
}

TEST(accuracy, is_reached_by_a_chain_of_pendulums) {
    const std::string file = scene_file("laws/pendulum_chain");
    const sim::SceneDef scene = sim::load_scene(file);
    for (const double asked : {1e-3, 1e-4, 1e-5}) {
        AccuracySearch search(scene, asked);
        const test::SearchedRun run = test::search(file, search);
        EXPECT_EQ(search.end(), AccuracyEnd::reached) << asked;
        EXPECT_GT(search.order(), 1.5) << "the scheme's is 2";
        const auto steps = static_cast<std::int64_t>(8 * sim::step_count(run.scene.output.duration, run.scene.step.time_step)) /
                           (search.instants() - 1);
        const sim::Rational finer = sim::make_rational(run.scene.step.time_step.num, 8 * run.scene.step.time_step.den);
        const test::SearchedRun truth = test::run_scene(
            file, {"simulation.time_step=\"" + std::to_string(finer.num) + "/" + std::to_string(finer.den) + "\""}, steps,
            search.instants());
        EXPECT_LE(difference(scene, run.motion, truth.motion).rms, asked);
    }
}

/// The top stands on its stem or not by what the last digits of its spin are.
TEST(accuracy, says_until_when_motion_that_is_sensitive_to_everything_is_determined) {
    const std::string file = scene_file("tippe_top");
    AccuracySearch search(sim::load_scene(file), 1e-3);
    const test::SearchedRun run = test::search(file, search);
    EXPECT_EQ(search.end(), AccuracyEnd::chaotic);
    EXPECT_GT(search.runs().back().determined_until, 0.5);
    EXPECT_LT(search.runs().back().determined_until, 3.0);
    EXPECT_EQ(run.scene.step.time_step, sim::load_scene(file).step.time_step) << "its own settings";
    EXPECT_LE(run.scene.step.tolerance, 1e-3);
}

/// Two steps that a fast spin divides into the same intervals would agree, and tell nothing.
TEST(accuracy, the_next_step_is_shorter_than_what_the_last_was_divided_into) {
    const sim::SceneDef scene = sim::load_scene(scene_file("laws/free_rotation"));
    AccuracySearch search(scene, 1e-3);
    Motion motion{.states = std::vector<sim::Snapshot>(static_cast<std::size_t>(search.instants())), .interval = 1e-3};
    EXPECT_FALSE(search.add(motion));
    EXPECT_EQ(search.overrides().front(), "simulation.time_step=\"1/1920\"") << "1/60 by two, until it is 0.7e-3 s at most";
}

TEST(accuracy, a_step_that_is_too_long_for_the_scene_is_passed_over) {
    AccuracySearch search(sim::load_scene(scene_file("laws/tower")), 1e-3);
    EXPECT_TRUE(search.add_stopped("spins too fast"));
    EXPECT_EQ(search.overrides().front(), "simulation.time_step=\"1/120\"");
    EXPECT_EQ(search.runs().front().stopped, "spins too fast");
    for (int i = 0; i < 4; ++i) {
        search.add_stopped("spins too fast");
    }
    EXPECT_FALSE(search.add_stopped("spins too fast")) << "the scene's own step does not help either";
}

} // namespace
