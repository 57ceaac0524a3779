#include "render/cmd/budget.h"

#include "render/cmd/pilot.h"
#include "render/cmd/simulation.h"
#include "render/study/engine.h"
#include "render/study/preset.h"
#include "sim/base/cores.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

namespace cmd {

namespace {

using Clock = std::chrono::steady_clock;
using sim::Error;
using sim::ExitCode;
using sim::Rational;

/// Times [-] the scene's own time step, the coarsest first: from 4 to 1/64 in eighths of each power of two, so that at most a
/// fifth of a time is left because the next shorter step would not fit.
constexpr auto step_factors = [] {
    constexpr std::int64_t coarsest = 4, finest = 64, eighths = 4;
    std::array<Rational, 8 * eighths + 1> factors;
    std::size_t count = 0;
    for (std::int64_t part = 1; part < coarsest * finest; part *= 2) {
        for (std::int64_t eighth = 8; eighth > eighths; --eighth) {
            factors[count++] = sim::make_rational(coarsest * eighth, 8 * part);
        }
    }
    factors[count++] = {1, finest};
    return factors;
}();
static_assert(step_factors.front() == Rational{4, 1} && step_factors.back() == Rational{1, 64});

/// Shares [-] of the budget that pilots of the coarsest and of the scene's own settings may take.
constexpr double coarse_share = 0.2;
constexpr double own_share = 0.1;

/// Expected times up to this share [-] of what is left fit: the rest is what measurements miss.
constexpr double fitting_share = 0.95;

/// Where a run begins and ends: libraries, shaders, hashes [s].
constexpr double beginning = 0.5;

/// Longer steps cost more each: the scene's own settings take so many times [-] what the coarsest do, at least and at most.
constexpr double least_ratio = 1.5;
constexpr double largest_ratio = 6.0;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What has been measured of a scene.
struct Costs {
    double coarse = 0.0;     ///< [s] simulation at step_factors[0]
    double own = 0.0;        ///< [s] with the scene's own settings
    double processors = 1.0; ///< [-] that a simulation keeps busy
    std::int64_t frames = 0;

    /// Wall time of the simulation alone [s]: a power of the step between the two that were measured, and as many times
    /// that of the scene's own as there are steps where they are shorter.
    double simulation(double factor) const {
        const double power = std::log(own / coarse) / std::log(step_factors[0].value());
        return factor < 1.0 ? own / factor : own * std::pow(factor, -power);
    }

    /// Wall time of the whole run [s]. Simulation and pictures go on at the same time, as far as there are cores.
    double expected(const Rational& factor, const PictureCost& picture) const {
        const double simulated = simulation(factor.value());
        const double pictures = static_cast<double>(frames) * picture.wall;
        const double cores = sim::core_count();
        const double processor =
            simulated * processors + static_cast<double>(frames) * picture.processor;
        return beginning + std::max({simulated, pictures, processor / cores});
    }
};

std::vector<std::string> picture_override(const std::string& preset) {
    return preset.empty() ? std::vector<std::string>{} : std::vector<std::string>{"output.preset=\"" + preset + "\""};
}

/// Of the scene's own settings beside the coarsest ones: in the parts of the film that both pilots have done.
double ratio_of(const SimulationPilot& coarse, const SimulationPilot& own) {
    const std::size_t parts = std::min(coarse.seconds.size(), own.seconds.size());
    if (parts == 0) {
        return step_factors[0].value();
    }
    return std::clamp(own.seconds[parts - 1] / coarse.seconds[parts - 1], least_ratio, largest_ratio);
}

} // namespace

sim::SceneDef scene_within_budget(const std::string& input, const Options& options, bool has_pictures,
                                  sim::BudgetResult& result) {
    const Clock::time_point start = Clock::now();
    const sim::SceneDef own = load_scene(input, options);
    const auto settings = [&](const Rational& factor) { return study::scaled_settings(own, factor); };
    const SimulationPilot coarse = pilot_simulation(load_scene(input, options, settings(step_factors[0])),
                                                    thread_count(options), coarse_share * options.budget);
    const SimulationPilot fine = pilot_simulation(own, thread_count(options), own_share * options.budget);
    const Costs costs{.coarse = coarse.whole_time(),
                      .own = fine.is_whole() ? fine.whole_time() : coarse.whole_time() * ratio_of(coarse, fine),
                      .processors = coarse.processors,
                      .frames = frame_count_of(own)};

    // The best pictures that leave time for the scene's own settings, else the cheapest.
    const bool is_chosen = !has_pictures || !picture_preset(options).empty();
    std::string pictures;
    PictureCost picture;
    const auto left = [&] { return fitting_share * (options.budget - seconds_since(start)); };
    for (const char* preset : {"final", "standard", "draft"}) {
        pictures = is_chosen ? "" : preset;
        if (has_pictures) {
            const sim::SceneDef drawn = load_scene(input, options, picture_override(pictures));
            picture = pilot_pictures(drawn, coarse, !options.no_png, !options.no_video);
        }
        if (is_chosen || costs.expected({1, 1}, picture) <= left()) {
            break;
        }
    }
    const double cheapest = costs.expected(step_factors[0], picture);
    if (cheapest > left()) {
        throw Error(ExitCode::usage,
                    fmt::format("{}: --budget {:g} s is too little: the coarsest settings{} take about {:.3g} s, and {:.2g} s went "
                                "into measuring that",
                                own.name, options.budget, has_pictures ? " and the cheapest pictures" : "", cheapest,
                                seconds_since(start)));
    }
    Rational factor = step_factors[0];
    for (const Rational& finer : step_factors) {
        factor = costs.expected(finer, picture) <= left() ? finer : factor;
    }
    std::vector<std::string> overrides = settings(factor);
    std::ranges::copy(picture_override(pictures), std::back_inserter(overrides));
    sim::SceneDef scene = load_scene(input, options, overrides);
    result = {.asked = options.budget,
              .expected = costs.expected(factor, picture),
              .measuring = seconds_since(start),
              .pictures = pictures};
    return scene;
}

std::string budget_text(const sim::SceneDef& scene, const sim::BudgetResult& result) {
    return fmt::format("{}: {:g} s allow steps of {} s, a tolerance of {:.2g} m{}: {:.3g} s expected, {:.2g} s went into measuring that",
                       scene.name, result.asked, study::fraction_text(scene.step.time_step), scene.step.tolerance,
                       result.pictures.empty() ? "" : " and pictures of the preset " + result.pictures, result.expected,
                       result.measuring);
}

} // namespace cmd
