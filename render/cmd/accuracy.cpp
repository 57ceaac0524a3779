#include "render/cmd/accuracy.h"

#include "render/cmd/elsewhere.h"
#include "render/cmd/supervise.h"
#include "render/study/accuracy.h"
#include "render/study/engine.h"
#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cmd {

namespace {

using sim::Error;
using sim::ExitCode;

/// What the search sets.
constexpr std::array<const char*, 4> keys_found{"simulation.time_step", "simulation.tolerance",
                                                "simulation.velocity_tolerance", "simulation.impacts"};

std::string text_of(const sim::Rational& time_step) {
    return study::fraction_text(time_step) + " s";
}

/// The whole simulation, with progress.
void simulate(Simulation& simulation, const std::string& label, const Workplace& workplace, ProgressStyle style) {
    render::ThreadGroup threads; // ends before what its threads use
    threads.start([&] { simulation.advance(threads); });
    Progress progress(label, "steps", std::max<std::int64_t>(1, simulation.last_step()), style);
    supervise(
        threads, progress, [&] { return simulation.steps_done(); }, &workplace);
}

const char* word_of(study::AccuracyEnd end) {
    return end == study::AccuracyEnd::reached ? "reached" : end == study::AccuracyEnd::chaotic ? "chaotic" : "missed";
}

sim::AccuracyResult result_of(const study::AccuracySearch& search, double processor_time) {
    sim::AccuracyResult result{.asked = search.asked(),
                               .outcome = word_of(search.end()),
                               .estimate = search.estimate(),
                               .order = search.order(),
                               .processor_time = processor_time};
    for (const study::AccuracyRun& run : search.runs()) {
        result.runs.push_back({run.time_step, run.tolerance, run.difference, run.determined_until,
                               run.mean_difference, run.stopped});
    }
    return result;
}

} // namespace

void require_no_settings(const Options& options) {
    const auto refuse = [&](const std::string& other, const char* why) {
        throw Error(ExitCode::usage,
                    fmt::format("{} {}: not with {}", options.accuracy > 0.0 ? "--accuracy" : "--budget", why, other));
    };
    constexpr const char* finds = "finds time step, tolerances and the handling of impacts itself";
    for (const std::string& assignment : options.assignments) {
        const std::string key = assignment.substr(0, assignment.find('='));
        if (std::ranges::find(keys_found, key) != keys_found.end()) {
            refuse("--set " + key, finds);
        }
    }
    if (options.accuracy > 0.0 && options.budget > 0.0) {
        refuse("--budget", finds);
    }
    if (!options.time_step.empty() || !options.tolerance.empty() || !simulation_preset(options).empty()) {
        refuse(!options.time_step.empty() ? "--time-step" : !options.tolerance.empty() ? "--tolerance"
                                                                                       : "a preset of the simulation",
               finds);
    }
    constexpr const char* whole = "runs the whole scene several times";
    for (const auto& [is_given, option] :
         {std::pair(!options.frames.empty(), "--frames"), std::pair(options.is_resumed, "--resume"),
          std::pair(options.checkpoint_period.has_value(), "--checkpoint"),
          std::pair(is_elsewhere(options.placement), "--on")}) {
        if (is_given) {
            refuse(option, whole);
        }
    }
}

std::unique_ptr<Simulation> simulate_to_accuracy(const std::string& input, sim::SceneDef& scene, const Options& options,
                                                 const Workplace& workplace, sim::AccuracyResult& result) {
    study::AccuracySearch search(scene, options.accuracy);
    std::unique_ptr<Simulation> simulation;
    double processor_time = 0.0;
    for (bool is_done = false; !is_done;) {
        simulation.reset(); // with its record, before the next one is begun
        try {
            scene = load_scene(input, options, search.overrides());
            simulation = std::make_unique<Simulation>(scene, sim::World(scene, thread_count(options)), nullptr);
            simulation->record_to(workplace.folder() / trajectory_name);
            if (search.end() != study::AccuracyEnd::chaotic) {
                simulation->keep_states(search.steps_between(), search.instants());
            }
            simulate(*simulation, fmt::format("{}, step {}", scene.name, text_of(scene.step.time_step)), workplace,
                     progress_style(options));
        } catch (const Error& error) {
            // Too long a step may be refused, or stop: a shorter one does not.
            const bool is_of_settings = error.code() == ExitCode::usage || error.code() == ExitCode::stopped;
            if (!is_of_settings || !search.add_stopped(error.what())) {
                throw;
            }
            continue;
        }
        processor_time += simulation->processor_time();
        is_done = search.add({simulation->take_kept_states(), simulation->summary().totals.interval()});
    }
    simulation->finish_record();
    result = result_of(search, processor_time);
    return simulation;
}

std::string accuracy_text(const sim::AccuracyResult& result, const sim::StepTotals& totals) {
    const sim::AccuracyResult::Run& last = result.runs.back();
    const std::string cost =
        fmt::format("{} runs, {:.2g} s of processor time", result.runs.size() + (result.outcome == "chaotic" ? 1 : 0),
                    result.processor_time);
    const std::string left = fmt::format("about {:.1e} m are left (order {:.1f}) with steps of {}", result.estimate,
                                         result.order, text_of(last.time_step));
    if (result.outcome == "reached") {
        return fmt::format("accuracy {:g} m: {}; {}", result.asked, left, cost);
    }
    if (result.outcome == "missed") {
        return fmt::format("accuracy {:g} m is not reached: {}; {}", result.asked, left, cost);
    }
    return fmt::format("accuracy {:g} m: holds until {:.3g} s; after that runs part whatever the step, their common "
                       "centre of mass by up to {:.1e} m, and overlaps alone are held to it (largest {:.1e} m); {}",
                       result.asked, last.determined_until, last.mean_difference, totals.max_penetration, cost);
}

} // namespace cmd
