#include "render/study/preset.h"

#include <fmt/format.h>

#include <algorithm>

namespace study {

namespace {

/// The scene's step and tolerance times these, and its velocity tolerance as the tolerance over the step.
std::vector<std::string> scaled(const sim::StepSettings& step, const sim::Rational& time, double tolerance) {
    const sim::Rational h = sim::make_rational(step.time_step.num * time.num, step.time_step.den * time.den);
    return {fmt::format("simulation.time_step=\"{}/{}\"", h.num, h.den),
            fmt::format("simulation.tolerance={}", tolerance * step.tolerance),
            fmt::format("simulation.velocity_tolerance={}", tolerance / time.value() * step.velocity_tolerance)};
}

} // namespace

std::optional<Preset> find_preset(std::string_view name) {
    const auto found = std::find(preset_names.begin(), preset_names.end(), name);
    return found == preset_names.end() ? std::nullopt
                                       : std::optional(static_cast<Preset>(found - preset_names.begin()));
}

std::vector<std::string> preset_overrides(const sim::SceneDef& scene, Preset preset) {
    if (preset == Preset::standard) {
        return {};
    }
    if (preset == Preset::preview) {
        return scaled(scene.step, {4, 1}, 10.0);
    }
    std::vector<std::string> overrides = scaled(scene.step, {1, 4}, 0.1);
    const auto moving = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                      [](const sim::BodyDef& body) { return !body.is_static(); });
    if (moving <= most_that_stop) {
        overrides.emplace_back("simulation.impacts=\"stop\"");
    }
    return overrides;
}

} // namespace study
