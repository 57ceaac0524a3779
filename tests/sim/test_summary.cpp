#include "sim/record/summary.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <limits>

using namespace sim;

namespace {

StepReport report(int contacts, int iterations, double penetration) {
    StepReport r;
    r.collisions = 2 * contacts;
    r.contacts = contacts;
    r.contact_iterations = iterations;
    r.max_penetration = penetration;
    r.stage_ms = {1, 2, 3, 4, 5.5};
    return r;
}

} // namespace

TEST(summary, totals_are_means_a_step_and_largest_values) {
    Summary summary;
    summary.totals.add(report(10, 5, 1e-6), 2.5e-6);
    summary.totals.add(report(30, 8, 3e-6), 2.5e-6);
    StepReport limited = report(20, 2, 2e-6);
    limited.at_iteration_limit = true;
    summary.totals.add(limited, 2.5e-6);
    summary.totals.add(report(0, 0, 0), 2.5e-6);
    const nlohmann::json json = nlohmann::json::parse(summary_to_json(SceneDef{}, summary));
    EXPECT_EQ(json["steps"], 4);
    EXPECT_EQ(json["contacts_per_step"], 15.0);
    EXPECT_EQ(json["collisions_per_step"], 30.0);
    EXPECT_EQ(json["iterations_per_step"], 3.75);
    EXPECT_EQ(json["steps_at_iteration_limit"], 1);
    EXPECT_EQ(json["steps_above_tolerance"], 1);
    EXPECT_EQ(json["max_penetration_m"], 3e-6);
    EXPECT_EQ(json["max_contacts"], 30);
    EXPECT_EQ(json["stage_ms_per_step"]["broad_phase"], 1.0);
    EXPECT_EQ(json["stage_ms_per_step"]["integrate"], 5.5);
}

TEST(summary, settings_energies_hash_and_files_are_reported) {
    SceneDef scene;
    scene.name = "a scene";
    scene.output.fps = {24000, 1001};
    scene.overrides = {"step.tolerance=1e-6"};
    Summary summary;
    summary.threads = 3;
    summary.start.kinetic_energy = 1;
    summary.start.potential_energy = 2;
    summary.end.momentum = Vec3(1, 2, 3);
    summary.state_hash = 0xabc;
    summary.files = {{"a.mp4", 12, "00"}};
    const nlohmann::json json = nlohmann::json::parse(summary_to_json(scene, summary));
    EXPECT_EQ(json["scene"], "a scene");
    EXPECT_EQ(json["settings"]["time_step_s"], 1e-3);
    EXPECT_EQ(json["settings"]["fps"], "24000/1001");
    EXPECT_EQ(json["settings"]["threads"], 3);
    EXPECT_EQ(json["settings"]["overrides"][0], "step.tolerance=1e-6");
    EXPECT_EQ(json["start"]["energy_J"], 3.0);
    EXPECT_EQ(json["end"]["momentum_N_s"], (std::vector<double>{1, 2, 3}));
    EXPECT_EQ(json["state_hash"], "0000000000000abc");
    EXPECT_EQ(json["files"][0]["name"], "a.mp4");
    EXPECT_EQ(json["files"][0]["bytes"], 12);
}

TEST(summary, no_steps_bad_text_and_infinite_numbers_still_give_json) {
    SceneDef scene;
    scene.title = "\xff";
    Summary summary;
    summary.end.kinetic_energy = std::numeric_limits<double>::infinity();
    const nlohmann::json json = nlohmann::json::parse(summary_to_json(scene, summary));
    EXPECT_EQ(json["contacts_per_step"], 0.0);
    EXPECT_TRUE(json["end"]["kinetic_energy_J"].is_null());
}

TEST(summary, other_pictures_replace_what_concerns_them_and_nothing_else) {
    SceneDef scene;
    Summary summary;
    summary.threads = 3;
    summary.state_hash = 0xabc;
    summary.renderer = "before";
    summary.files = {{"trajectory.h5", 12, "00"}, {"a.mp4", 1, "11"}};
    const std::string text = summary_to_json(scene, summary);
    ASSERT_TRUE(files_of_summary(text));
    EXPECT_EQ(files_of_summary(text)->at(1).name, "a.mp4");
    EXPECT_EQ(files_of_summary(summary_with_files(text, {summary.files[0]}))->size(), 1u);
    scene.output.width = 77;
    Summary drawn;
    drawn.renderer = "now";
    drawn.files = {{"b.mp4", 2, "22"}};
    const nlohmann::json json = nlohmann::json::parse(summary_with_pictures(text, scene, drawn));
    EXPECT_EQ(json["renderer"], "now");
    EXPECT_EQ(json["settings"]["width_px"], 77);
    EXPECT_EQ(json["settings"]["threads"], 3);
    EXPECT_EQ(json["state_hash"], "0000000000000abc");
    ASSERT_EQ(json["files"].size(), 1u);
    EXPECT_EQ(json["files"][0]["sha256"], "22");
    for (const char* bad : {"", "{", "[1]", "{\"files\": [1], \"settings\": {\"threads\": 1}}", "{\"files\": []}"}) {
        EXPECT_FALSE(files_of_summary(bad)) << bad;
    }
}
