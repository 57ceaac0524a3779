#pragma once
/// A search for an accuracy as the program does it, without its files.
#include "render/study/accuracy.h"
#include "sim/base/error.h"
#include "sim/record/summary.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"

#include <ctime>
#include <string>
#include <vector>

namespace test {

/// One run, at the instants of a search.
struct SearchedRun {
    sim::SceneDef scene;
    study::Motion motion;
    double cost = 0.0; ///< [s] processor time of the steps
};

/// steps: between two of `instants` states. Throws sim::Error.
inline SearchedRun run_scene(const std::string& file, const std::vector<std::string>& overrides, std::int64_t steps,
                             int instants) {
    SearchedRun run{.scene = sim::load_scene(file, overrides), .motion = {}};
    sim::World world(run.scene, 1);
    run.motion.states.push_back(world.take_snapshot());
    sim::StepTotals totals;
    const std::clock_t start = std::clock();
    while (static_cast<int>(run.motion.states.size()) < instants) {
        for (std::int64_t i = 0; i < steps; ++i) {
            totals.add(world.step(), run.scene.step.tolerance);
        }
        run.motion.states.push_back(world.take_snapshot());
    }
    run.motion.interval = totals.interval();
    run.cost = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return run;
}

/// The last run, with the cost of all. Throws sim::Error.
inline SearchedRun search(const std::string& file, study::AccuracySearch& of) {
    double cost = 0.0;
    for (SearchedRun run;;) {
        try {
            run = run_scene(file, of.overrides(), of.steps_between(), of.instants());
        } catch (const sim::Error& error) {
            if (!of.add_stopped(error.what())) {
                throw;
            }
            continue;
        }
        cost += run.cost;
        if (of.add(run.motion)) {
            run.cost = cost;
            return run;
        }
    }
}

} // namespace test
