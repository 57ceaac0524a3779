/// The films as they are: in each step that is looked at and not reported, no overlap beyond the scene's tolerance but what a
/// reported one left, which parts; by a check that shares no code with sim/. None gains energy.
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <set>
#include <utility>

namespace {

using namespace laws;

/// Runs the scene for `duration` [s], all of it unless given, looking at every `every`-th step. settings: as of --set. may_jam: steps
/// that do not converge are allowed. Returns whether all steps converged.
bool judge_film(const std::string& film, int every, std::optional<double> shorter = {},
                const std::vector<std::string>& settings = {}, bool may_jam = false) {
    const sim::SceneDef scene = sim::load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / (film + ".toml"), settings);
    const double duration = shorter.value_or(scene.output.duration.value());
    sim::World world(scene);
    double overlap = 0.0, own = 0.0, gain = 0.0;
    int unconverged = 0, looks = 0;
    bool was_reported = false;
    double before = 0.0; // [m] overlap after the step before
    run(world, scene, duration, [&](const sim::Snapshot& s, const sim::StepReport& report) {
        unconverged += report.at_iteration_limit ? 1 : 0;
        gain = std::max(gain, report.energy_gain);
        // What is planned in a step shows once the bodies have moved, in the next one.
        const bool is_reported = std::exchange(was_reported, report.at_iteration_limit) || report.at_iteration_limit;
        const double left = std::exchange(before, report.max_penetration);
        if (!is_reported && left > scene.step.tolerance) {
            EXPECT_LE(report.max_penetration, left) << film << ", step " << s.step;
        } else if (!is_reported) {
            own = std::max(own, report.max_penetration);
            if (s.step % every == 0) {
                ++looks;
                overlap = std::max(overlap, largest_overlap(scene, s));
            }
        }
        return true;
    });
    const std::string name = fmt::format("film {}, {} s{}", film, duration, settings.empty() ? "" : ", " + settings.front());
    const double h = scene.step.time_step.value();
    record({name, fmt::format("overlap, {} steps looked at [m]", looks), h, overlap, scene.step.tolerance});
    record({name, "overlap, every step, by the run itself [m]", h, own, scene.step.tolerance});
    record({name, "steps not converged", h, static_cast<double>(unconverged), may_jam ? no_value : 0.0});
    record({name, "energy gained [-]", h, gain, sim::energy_gain_allowed});
    EXPECT_LE(gain, sim::energy_gain_allowed) << name;
    // The check of hulls and rods rounds, or searches, to 1e-9 m.
    EXPECT_LE(overlap, scene.step.tolerance + 1e-9) << name;
    EXPECT_LE(own, scene.step.tolerance) << name;
    EXPECT_TRUE(may_jam || unconverged == 0) << name << ": " << unconverged;
    return unconverged == 0;
}

TEST(law_films, the_first_moments_of_each_keep_its_tolerance) {
    judge_film("rubble", 20, 1.7); // the first rocks have landed
    judge_film("dominoes", 20, 1.0);
    judge_film("coin", 50, 0.5);
    judge_film("gate", 100, 1.25); // the load lands
}

/// Four cubes in a row are as wide as the throat: some wedge there under a thousand times their weight, and come free again. In one
/// seed of forty, another one after each change of rounding, a few steps do not converge then.
TEST(law_films, DISABLED_the_funnel_keeps_its_tolerance_whatever_the_seed) {
    int jams = 0;
    for (int seed = 1; seed <= 8; ++seed) {
        jams += judge_film("funnel", 100, 2.5, {fmt::format("lattice.cube.seed={}", seed)}, true) ? 0 : 1;
    }
    EXPECT_LE(jams, 1);
}

/// Seeds in which, asked to part for ever, and with no work left for the plan, they gain up to nine tenths of the energy.
TEST(law_films, DISABLED_a_row_wedged_in_the_funnel_is_not_thrown) {
    for (const int seed : {15, 20, 44}) {
        const std::vector<std::string> settings{fmt::format("lattice.cube.seed={}", seed)};
        const sim::SceneDef scene = sim::load_scene(TUMBLE_SCENE_DIR "/funnel.toml", settings);
        sim::World world(scene);
        double gain = 0.0, overlap = 0.0;
        run(world, scene, 2.5, [&](const sim::Snapshot&, const sim::StepReport& report) {
            gain = std::max(gain, report.energy_gain);
            overlap = std::max(overlap, report.max_penetration);
            return true;
        });
        const std::string name = fmt::format("film funnel, 2.5 s, seed {}", seed);
        record({name, "energy gained [-]", scene.step.time_step.value(), gain, sim::energy_gain_allowed});
        EXPECT_LE(gain, sim::energy_gain_allowed) << name;
        EXPECT_LE(overlap, 10.0 * scene.step.tolerance) << name;
    }
}

/// Jams come late, and where they do changes with each change of rounding.
TEST(law_films, DISABLED_each_keeps_its_tolerance_to_its_end) {
    const std::set<std::filesystem::path> files(std::filesystem::directory_iterator(TUMBLE_SCENE_DIR), {});
    for (const std::filesystem::path& file : files) {
        if (file.extension() == ".toml") {
            judge_film(file.stem().string(), 50);
        }
    }
}

} // namespace
