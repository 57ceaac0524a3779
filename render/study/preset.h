#pragma once
/// Settings of a simulation that trade accuracy for speed together, chosen from the studies.
#include "sim/model/scene_def.h"

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace study {

/// preview: four times the scene's time step and ten times its tolerance; of many bodies up to a hundred times, and eight times
/// the step where its tolerance of velocities is loose. standard: the scene's own settings.
/// accurate: a quarter of the time step, a tenth of the tolerance, and few bodies stop at their impacts: contacts
/// placed ahead of them act up to a step early, which is then the largest error. Tolerances of velocities go as those of
/// lengths over the time step.
enum class Preset { preview, standard, accurate };
inline constexpr std::array<const char*, 3> preset_names{"preview", "standard", "accurate"};

/// Moving bodies up to which `accurate` stops at impacts: each costs a solve of its own.
inline constexpr int most_that_stop = 32;
bool has_few_bodies(const sim::SceneDef& scene);

/// The scene with its time step times `time`, its tolerances in step with it: ten times at four times the step, as the presets
/// have it. "dotted.key=value".
std::vector<std::string> scaled_settings(const sim::SceneDef& scene, const sim::Rational& time);

std::optional<Preset> find_preset(std::string_view name);

/// What a preset sets of a scene: "dotted.key=value".
std::vector<std::string> preset_overrides(const sim::SceneDef& scene, Preset preset);

} // namespace study
