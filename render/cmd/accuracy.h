#pragma once
/// tumble run and tumble simulate with --accuracy: settings are found by running the scene.
#include "render/cmd/options.h"
#include "render/cmd/simulation.h"
#include "render/cmd/workplace.h"
#include "sim/record/summary.h"

#include <memory>
#include <string>

namespace cmd {

/// Throws Error (usage) if other options set what --accuracy or --budget finds, or what these cannot go with.
void require_no_settings(const Options& options);

/// Simulates the scene again and again, see study::AccuracySearch; each run is recorded in the workplace, and the
/// record of the last one stays. scene: that of `input`, then with the settings found. result: what was found.
/// Throws Error as the simulation does.
std::unique_ptr<Simulation> simulate_to_accuracy(const std::string& input, sim::SceneDef& scene, const Options& options,
                                                 const Workplace& workplace, sim::AccuracyResult& result);

/// One sentence for the user.
std::string accuracy_text(const sim::AccuracyResult& result, const sim::StepTotals& totals);

} // namespace cmd
