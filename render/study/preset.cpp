#include "render/study/preset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace study {

std::vector<std::string> scaled_settings(const sim::SceneDef& scene, const sim::Rational& time) {
    const sim::StepSettings& step = scene.step;
    const sim::Rational h = sim::make_rational(step.time_step.num * time.num, step.time_step.den * time.den);
    const double tolerance = std::pow(time.value(), std::log(10.0) / std::log(4.0));
    return {fmt::format("simulation.time_step=\"{}/{}\"", h.num, h.den),
            fmt::format("simulation.tolerance={:.6g}", tolerance * step.tolerance),
            fmt::format("simulation.velocity_tolerance={:.6g}", tolerance / time.value() * step.velocity_tolerance)};
}

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
        return scaled_settings(scene, {4, 1});
    }
    std::vector<std::string> overrides = scaled_settings(scene, {1, 4});
    const auto moving = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                      [](const sim::BodyDef& body) { return !body.is_static(); });
    if (moving <= most_that_stop) {
        overrides.emplace_back("simulation.impacts=\"stop\"");
    }
    return overrides;
}

} // namespace study
