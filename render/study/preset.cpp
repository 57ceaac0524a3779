#include "render/study/preset.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace study {

namespace {

/// In a preview of many bodies tolerances are this many times [-] the scene's, and overlaps at most this share [-] of half the
/// thinnest side of a moving body: nobody sees them, and statistics of a heap do not tell them.
constexpr double crowd_factor = 100.0;
constexpr double crowd_share = 0.05;

/// How many times [-] as long its time step is; and that of crowds whose velocities may be wrong by this share [-] of a tolerance
/// a step: with tighter ones, as dominoes have them, sweeps cost more than the longer step saves.
constexpr sim::Rational longer{4, 1};
constexpr sim::Rational longer_of_loose_crowds{8, 1};
constexpr double loose_share = 0.01;

double half_thinnest_side(const sim::SceneDef& scene) {
    double least = std::numeric_limits<double>::infinity();
    for (const sim::BodyDef& body : scene.bodies) {
        if (!body.is_static()) {
            const sim::Bounds box = sim::bounds(body.shape, sim::Pose{});
            least = std::min(least, 0.5 * (box.upper - box.lower).minCoeff());
        }
    }
    return least;
}

/// tolerance: times [-] the scene's.
std::vector<std::string> scaled(const sim::SceneDef& scene, const sim::Rational& time, double tolerance) {
    const sim::StepSettings& step = scene.step;
    const sim::Rational h = sim::make_rational(step.time_step.num * time.num, step.time_step.den * time.den);
    return {fmt::format("simulation.time_step=\"{}/{}\"", h.num, h.den),
            fmt::format("simulation.tolerance={:.6g}", tolerance * step.tolerance),
            fmt::format("simulation.velocity_tolerance={:.6g}", tolerance / time.value() * step.velocity_tolerance)};
}

double tolerance_factor(const sim::Rational& time) {
    return std::pow(time.value(), std::log(10.0) / std::log(4.0));
}

std::vector<std::string> crowd_preview(const sim::SceneDef& scene) {
    const sim::StepSettings& step = scene.step;
    const bool is_loose = step.velocity_tolerance * step.time_step.value() >= loose_share * step.tolerance;
    const double hidden = crowd_share * half_thinnest_side(scene) / step.tolerance;
    return scaled(scene, is_loose ? longer_of_loose_crowds : longer,
                  std::clamp(hidden, tolerance_factor(longer), crowd_factor));
}

} // namespace

bool has_few_bodies(const sim::SceneDef& scene) {
    return std::ranges::count_if(scene.bodies, [](const sim::BodyDef& body) { return !body.is_static(); }) <= most_that_stop;
}

std::vector<std::string> scaled_settings(const sim::SceneDef& scene, const sim::Rational& time) {
    return scaled(scene, time, tolerance_factor(time));
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
        return has_few_bodies(scene) ? scaled_settings(scene, longer) : crowd_preview(scene);
    }
    std::vector<std::string> overrides = scaled_settings(scene, {1, 4});
    if (has_few_bodies(scene)) {
        overrides.emplace_back("simulation.impacts=\"stop\"");
    }
    return overrides;
}

} // namespace study
