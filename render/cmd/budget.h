#pragma once
/// tumble run and tumble simulate with --budget: the most accurate settings, and the best pictures, for a time.
#include "render/cmd/options.h"
#include "sim/record/summary.h"

#include <string>

namespace cmd {

/// Measures parts of the scene and returns the scene with the settings that fit. result: what was found.
/// Throws Error: usage if the cheapest settings take longer, with what they would take; as the simulation does.
sim::SceneDef scene_within_budget(const std::string& input, const Options& options, bool has_pictures,
                                  sim::BudgetResult& result);

/// What was chosen, in one sentence.
std::string budget_text(const sim::SceneDef& scene, const sim::BudgetResult& result);

} // namespace cmd
