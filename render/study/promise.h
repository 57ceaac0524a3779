#pragma once
/// What the presets promise of a scene, beside what was reached.
#include "render/study/preset.h"
#include "render/study/table.h"
#include "sim/record/summary.h"

#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace study {

/// Of a run or of a point; NaN: not known.
struct Reached {
    static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

    Difference error{unknown, unknown, unknown, unknown, unknown};
    double cost = unknown;    ///< [s] processor time a simulated second
    double overlap = unknown; ///< [m]
};

/// Of every scene: largest overlap, the preset's tolerance; error and cost are those that studies found (study.promises). Of
/// bodies that rest (law tower): none moves by more than the tolerance. Of a ball that bounces (its law): heights, relative
/// to the first. scene: with the preset's settings.
std::vector<sim::Promise> promises_of(const sim::SceneDef& scene, Preset preset, const Reached& reached);

/// "error 1e-5 m (promised 2e-5), overlap ...".
std::string promises_text(const std::vector<sim::Promise>& promises);

/// Cost depends on the machine and is never missed, nor is what is not known.
bool is_kept(const sim::Promise& promise);

/// The presets among the first engine's points of a table that are done, each with its promises.
std::vector<std::pair<Preset, std::vector<sim::Promise>>> preset_promises(const Plan& plan, const Table& table);

/// promises.csv.
std::string promises_csv(const Plan& plan, const Table& table);

} // namespace study
