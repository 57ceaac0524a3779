#pragma once
/// A physics engine with a scene loaded, as a study runs it: ours, and the peers that the benchmarks link.
#include "sim/base/step_report.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <functional>
#include <string>
#include <vector>

namespace study {

struct Engine {
    std::function<sim::StepReport()> step;   ///< advances by the scene's time step
    std::function<sim::Snapshot()> snapshot; ///< bodies in the order of the scene
    std::function<double()> overlap;         ///< [m] now; empty if the reports hold it
};

/// What is set at one point of a sweep.
struct Setting {
    std::string value;                  ///< as it is printed: "1/500 s"
    std::vector<std::string> overrides; ///< of the scene: "simulation.time_step=\"1/500\""
    std::string variant;                ///< words for the engine alone; ours has none
};

/// What a user can turn, and how far.
struct Knob {
    std::string name; ///< "time step"
    std::vector<Setting> settings;
    bool starts_at_base = true; ///< the scene's own settings are on its curve too
};

struct EngineKind {
    std::string name; ///< "tumble"
    /// `variant` as in Setting. Throws sim::Error (usage) for a scene that the engine cannot run.
    std::function<Engine(const sim::SceneDef&, const std::string& variant)> make;
    std::function<std::vector<Knob>(const sim::SceneDef&)> knobs;
    Setting base; ///< the point all its knobs are turned from
};

/// This program's, on one thread.
EngineKind our_engine();

/// "1/500": exact.
std::string fraction_text(const sim::Rational& value);

/// Settings with the scene's time step times each of the factors, and `more` set too.
std::vector<Setting> time_steps(const sim::SceneDef& scene, const std::vector<sim::Rational>& factors,
                                const std::vector<std::string>& more = {});

} // namespace study
