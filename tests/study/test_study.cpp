/// Plans, points and tables of studies of the scenes of the laws.
#include "render/study/law.h"
#include "render/study/promise.h"
#include "render/study/table.h"
#include "sim/base/error.h"
#include "sim/scene/file.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>

namespace {

using namespace study;

std::string law_file(const std::string& name) {
    return std::string(TUMBLE_SCENE_DIR) + "/laws/" + name + ".toml";
}

Plan plan_of(const std::string& name, std::vector<std::string> knobs, std::vector<std::string> overrides = {}) {
    const std::array engines{our_engine()};
    return make_plan({.scene = law_file(name), .overrides = std::move(overrides), .knobs = std::move(knobs)}, engines);
}

Point base_point(const Plan& plan) {
    const Motion truth = law_motion(plan.scene, plan.def.law, plan.times());
    Motion motion;
    std::atomic<std::int64_t> steps = 0;
    const Point point = run_task({plan, plan.tasks.front(), our_engine(), steps}, &truth, motion);
    EXPECT_GE(steps, plan.tasks.front().steps);
    return point;
}

TEST(study, the_scenes_of_the_laws_follow_them) {
    // Second order in h = 1 ms: a h^2 / 8 where friction ends within a step.
    for (const auto& [name, bound] : {std::pair("sliding_block", 2e-6), std::pair("rolling_ball", 2e-6),
                                      std::pair("tower", 1e-5), std::pair("free_rotation", 1e-9)}) {
        const Point point = base_point(plan_of(name, {"tolerance"}));
        EXPECT_EQ(point.status, Status::done) << point.message;
        EXPECT_LT(point.error.largest, bound) << name;
        EXPECT_GT(point.cpu, 0.0);
    }
    const Point ball = base_point(plan_of("bouncing_ball", {"tolerance"}, {"simulation.impacts=\"stop\""}));
    EXPECT_LT(ball.error.largest, 1e-6);
}

TEST(study, presets_keep_what_they_promise_of_towers_and_bounces) {
    const std::array engines{our_engine()};
    for (const auto& [name, key] : {std::pair("tower", "moved_m"), std::pair("bouncing_ball", "bounce_heights")}) {
        const Plan plan = plan_of(name, {"preset"});
        const Motion truth = law_motion(plan.scene, plan.def.law, plan.times());
        std::vector<Point> points;
        for (const Task& task : plan.tasks) {
            Motion motion;
            std::atomic<std::int64_t> steps = 0;
            points.push_back(run_task({plan, task, engines[0], steps}, &truth, motion));
        }
        const auto presets = preset_promises(plan, make_table(plan, engines, points, {}));
        ASSERT_EQ(presets.size(), preset_names.size());
        for (std::size_t i = 0; i < presets.size(); ++i) {
            EXPECT_EQ(presets[i].first, static_cast<Preset>(i));
            ASSERT_EQ(presets[i].second.size(), 4u);
            EXPECT_STREQ(presets[i].second.back().key, key);
            for (const sim::Promise& promise : presets[i].second) {
                EXPECT_GE(promise.reached, 0.0);
                EXPECT_TRUE(is_kept(promise)) << name << " " << preset_names[i] << ": " << promises_text({promise});
            }
        }
    }
}

TEST(study, a_bounce_of_another_height_is_a_difference_and_a_later_one_is_none) {
    const sim::SceneDef ball = sim::load_scene(law_file("bouncing_ball"));
    sim::SceneDef lively = ball;
    lively.bodies.at(1).material.restitution = 0.9; // e^2 from 0.64 to 0.72, of a first fall of 1 m
    std::vector<double> times, later;
    for (int k = 0; k < 100; ++k) { // up to the second bounce
        times.push_back(0.01 * k);
        later.push_back(0.01 * k + 1e-3);
    }
    const Motion truth = law_motion(ball, sim::Law::bouncing_ball, times);
    EXPECT_LT(difference(ball, law_motion(ball, sim::Law::bouncing_ball, later), truth).heights, 1e-12);
    EXPECT_NEAR(difference(ball, law_motion(lively, sim::Law::bouncing_ball, times), truth).heights, 0.08, 0.001);
}

TEST(study, every_scene_takes_every_preset_and_every_time_step) {
    for (const char* folder : {TUMBLE_SCENE_DIR, TUMBLE_SCENE_DIR "/laws"}) {
        for (const auto& entry : std::filesystem::directory_iterator(folder)) {
            if (entry.path().extension() != ".toml") {
                continue;
            }
            const sim::SceneDef scene = sim::load_scene(entry.path());
            for (const Preset preset : {Preset::preview, Preset::standard, Preset::accurate}) {
                EXPECT_NO_THROW(sim::load_scene(entry.path(), preset_overrides(scene, preset))) << entry.path();
            }
            for (const Setting& setting : time_steps(scene, {{8, 1}, {1, 4}})) {
                EXPECT_NO_THROW(sim::load_scene(entry.path(), setting.overrides)) << entry.path() << setting.value;
            }
        }
    }
}

TEST(study, previews_of_crowds_take_longer_steps_where_velocities_may_be_wrong) {
    for (const auto& [name, longer] : {std::pair("office_toy", 4), std::pair("dominoes", 4), std::pair("funnel", 8)}) {
        const std::string path = std::string(TUMBLE_SCENE_DIR) + "/" + name + ".toml";
        const sim::SceneDef scene = sim::load_scene(path);
        const sim::SceneDef preview = sim::load_scene(path, preset_overrides(scene, Preset::preview));
        EXPECT_NEAR(preview.step.time_step.value(), longer * scene.step.time_step.value(), 1e-15) << name;
        EXPECT_GT(preview.step.tolerance, scene.step.tolerance) << name;
    }
}

TEST(study, a_wrong_law_is_refused_with_what_it_expects) {
    const sim::SceneDef scene = sim::load_scene(law_file("tower"));
    using enum sim::Law;
    for (const sim::Law law : {sliding_block, bouncing_ball, rolling_ball, free_rotation}) {
        EXPECT_THROW(law_motion(scene, law, std::vector{0.0, 0.1}), sim::Error) << static_cast<int>(law);
    }
}

TEST(study, instants_lie_on_steps_of_every_point) {
    const Plan plan = plan_of("pendulum_chain", {});
    ASSERT_EQ(plan.references.size(), 1u);
    EXPECT_GT(plan.count, 50);
    EXPECT_LE(plan.duration(), plan.scene.output.duration.value() + 1e-12);
    std::set<std::string> names;
    for (const Task& task : plan.tasks) {
        EXPECT_EQ(task.refusal, "");
        const sim::Rational steps =
            sim::make_rational(plan.spacing.num * task.time_step.den, plan.spacing.den * task.time_step.num);
        EXPECT_EQ(steps.den, 1) << task.name;
        EXPECT_EQ(task.steps, steps.num * (plan.count - 1)) << task.name;
        EXPECT_TRUE(names.insert(task.name).second) << task.name;
    }
    EXPECT_LT(plan.references[0].time_step.value(), 1e-3 / 8);
}

TEST(study, a_knob_that_does_not_exist_is_an_error) {
    EXPECT_THROW(plan_of("tower", {"colour"}), sim::Error);
}

TEST(study, a_duration_too_short_for_the_steps_is_an_error) {
    EXPECT_THROW(plan_of("tower", {}, {"output.duration=0.02"}), sim::Error);
}

TEST(study, a_setting_that_the_scene_refuses_is_a_point_of_its_own) {
    const Plan plan = plan_of("tower", {"time step"}, {"simulation.time_step=0.2", "output.duration=30"});
    const Task& largest = plan.tasks.at(1); // 1.6 s, where a step is at most 1 s
    EXPECT_NE(largest.refusal, "");
    Motion motion;
    std::atomic<std::int64_t> steps = 0;
    const Point point = run_task({plan, largest, our_engine(), steps}, nullptr, motion);
    EXPECT_EQ(point.status, Status::refused);
    EXPECT_NE(point.message.find("time_step"), std::string::npos) << point.message;
}

TEST(study, points_survive_their_file_and_a_changed_key_does_not) {
    Point point;
    point.status = Status::too_dear;
    point.message = "not \"done\"";
    point.cpu = 0.1;
    point.error = {1e-17, 2, 3, 4, 5};
    point.at_limit = 7;
    point.series = {{1, 2, 3, 4}};
    const std::string text = point_to_json(point, "key");
    const auto again = point_from_json(text, "key");
    ASSERT_TRUE(again);
    EXPECT_EQ(point_to_json(*again, "key"), text);
    EXPECT_FALSE(point_from_json(text, "another"));
    EXPECT_FALSE(point_from_json(text.substr(0, text.size() / 2), "key"));
    EXPECT_FALSE(point_from_json("{\"key\": \"key\"}", "key"));
}

Point point_at(double cost, double error) {
    Point point;
    point.cpu = cost;
    point.simulated = 1.0;
    point.error.rms = error;
    return point;
}

TEST(study, the_front_holds_what_nothing_beats) {
    const Plan plan = plan_of("tower", {"tolerance"});
    ASSERT_EQ(plan.tasks.size(), 5u);
    std::vector<Point> points{point_at(2, 2), point_at(1, 4), point_at(3, 2), point_at(4, 1), point_at(1, 1)};
    points[4].status = Status::stopped;
    const std::array engines{our_engine()};
    const Table table = make_table(plan, engines, points, {});
    std::vector<bool> front;
    for (const Row& row : table.rows) {
        front.push_back(row.is_on_front);
    }
    EXPECT_EQ(front, (std::vector<bool>{true, true, false, true, false}));
    const std::string csv = table_csv(plan, table);
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 6);
    EXPECT_NE(csv.find("\"tumble\",\"tolerance\",\"1e-07 m\",stopped,,,,"), std::string::npos) << csv;
}

TEST(study, the_page_says_where_another_engine_is_on_the_front) {
    const Plan plan = plan_of("tower", {"tolerance"});
    Table table;
    table.rows = {{.engine = "tumble", .cost = 2.0, .error = 1.0}, {.engine = "Bullet", .cost = 3.0, .error = 2.0}};
    EXPECT_EQ(losses_text(plan, table),
              "No point of another engine is on the front: each is beaten in error and cost by one of tumble.");
    table.rows.push_back({.engine = "ODE", .knob = "time step", .value = "1/125 s", .cost = 0.5, .error = 3.0});
    table.rows.back().is_on_front = true;
    EXPECT_EQ(losses_text(plan, table), "Where tumble loses: nothing reaches a smaller error at less cost than ODE, "
                                        "time step, 1/125 s (0.5 s, error 3 m).");
    table.rows.resize(1);
    EXPECT_EQ(losses_text(plan, table), "");
}

TEST(study, statistical_errors_are_those_of_the_means_over_the_seeds) {
    const std::array engines{our_engine()};
    const Plan plan = make_plan({.scene = law_file("tower"),
                                 .overrides = {"study.seed_key=lattice.box.seed", "study.law=none"},
                                 .knobs = {"tolerance"},
                                 .seeds = 2},
                                engines);
    ASSERT_EQ(plan.tasks.size(), 10u);
    EXPECT_NE(plan.tasks[0].overrides, plan.tasks[1].overrides);
    std::vector<Point> points(10, point_at(1, 0)), references(2, point_at(1, 0));
    for (Point& point : points) {
        point.series = {{0, 0, 0, 0}, {1, 2, 3, 4}};
    }
    references[0].series = {{0, 0, 0, 0}, {1, 2, 3, 4}};
    references[1].series = {{0, 0, 0, 0}, {3, 2, 3, 4}};
    const Table table = make_table(plan, engines, points, references);
    // Throughput: 1 where the mean is 2, of a range of 2, at one of two instants.
    EXPECT_NEAR(table.rows[0].statistics[0], 0.5 / std::sqrt(2.0), 1e-15);
    EXPECT_NEAR(table.rows[0].error, 0.25 / std::sqrt(2.0), 1e-15);
    // Variance 2, of two runs: sqrt(2 / 2 * 2 / 2^2 / 8).
    EXPECT_NEAR(table.noise, 0.25, 1e-15);
}

} // namespace
