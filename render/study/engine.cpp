#include "render/study/engine.h"

#include "render/study/preset.h"
#include "sim/scene/model.h"
#include "sim/scene/study.h"
#include "sim/world/world.h"

#include <fmt/format.h>

#include <memory>

namespace study {

namespace {

using sim::Rational;

const std::vector<Rational> all_factors{{8, 1}, {4, 1}, {2, 1}, {1, 2}, {1, 4}};
const std::vector<Rational> statistical_factors{{8, 1}, {4, 1}, {2, 1}}; // finer ones are within the spread
const std::vector<Rational> few_factors{{4, 1}, {2, 1}, {1, 1}, {1, 2}};

/// Both tolerances together: one alone would leave the other to end the iteration.
Knob tolerances(const sim::SceneDef& scene) {
    Knob knob{"tolerance", {}, true};
    for (const double factor : {100.0, 10.0, 0.1, 0.01}) {
        const double tolerance = factor * scene.step.tolerance;
        knob.settings.push_back({fmt::format("{:.2g} m", tolerance),
                                 {fmt::format("simulation.tolerance={}", tolerance),
                                  fmt::format("simulation.velocity_tolerance={}",
                                              factor * scene.step.velocity_tolerance)},
                                 ""});
    }
    return knob;
}

Knob iteration_limits(const sim::SceneDef& scene) {
    Knob knob{"iteration limit", {}, true};
    for (const int limit : {3, 10, 30, 100, 300}) {
        if (limit < scene.step.iteration_limit) {
            knob.settings.push_back({fmt::format("{} sweeps", limit),
                                     {fmt::format("simulation.iteration_limit={}", limit)},
                                     ""});
        }
    }
    return knob;
}

Knob presets(const sim::SceneDef& scene) {
    Knob knob{"preset", {}, true};
    for (const Preset preset : {Preset::preview, Preset::accurate}) { // the scene's own settings are the third
        knob.settings.push_back(
            {preset_names[static_cast<std::size_t>(preset)], preset_overrides(scene, preset), ""});
    }
    return knob;
}

std::vector<Knob> our_knobs(const sim::SceneDef& scene) {
    const sim::StepSettings& step = scene.step;
    const auto toggled = [](const char* key, bool value) { return fmt::format("simulation.{}={}", key, !value); };
    const bool is_statistical = !sim::study_of(scene).seed_key.empty();
    const bool stops = sim::impact_handling(scene) == sim::ImpactHandling::stop;
    return {
        presets(scene),
        {"time step", time_steps(scene, is_statistical ? statistical_factors : all_factors), true},
        tolerances(scene),
        iteration_limits(scene),
        {step.warm_start ? "no warm start" : "warm start",
         time_steps(scene, few_factors, {toggled("warm_start", step.warm_start)}), false},
        {stops ? "contacts ahead of impacts" : "stop at impacts",
         time_steps(scene, few_factors, {fmt::format("simulation.impacts=\"{}\"", stops ? "ahead" : "stop")}),
         false},
    };
}

Engine make_ours(const sim::SceneDef& scene, const std::string&) {
    const auto world = std::make_shared<sim::World>(scene, 1);
    return {[world] { return world->step(); }, [world] { return world->take_snapshot(); }, {}};
}

} // namespace

EngineKind our_engine() {
    return {"tumble", make_ours, our_knobs, {"the scene's own settings", {}, ""}};
}

std::string fraction_text(const Rational& value) {
    return value.den == 1 ? fmt::format("{}", value.num) : fmt::format("{}/{}", value.num, value.den);
}

std::vector<Setting> time_steps(const sim::SceneDef& scene, const std::vector<Rational>& factors,
                                const std::vector<std::string>& more) {
    std::vector<Setting> settings;
    const Rational& h = scene.step.time_step;
    for (const Rational& factor : factors) {
        const std::string text = fraction_text(sim::make_rational(h.num * factor.num, h.den * factor.den));
        Setting setting{text + " s", {fmt::format("simulation.time_step=\"{}\"", text)}, ""};
        // A velocity tolerance of more than the tolerance in one step would be refused.
        const double most = scene.step.tolerance / (h.value() * factor.value());
        if (scene.step.velocity_tolerance > most) {
            setting.overrides.push_back(fmt::format("simulation.velocity_tolerance={}", 0.5 * most));
        }
        setting.overrides.insert(setting.overrides.end(), more.begin(), more.end());
        settings.push_back(std::move(setting));
    }
    return settings;
}

} // namespace study
