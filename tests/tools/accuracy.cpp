/// accuracy: what --accuracy finds in scenes with a closed form or a finer run to be held against: its true error, and its
/// cost beside that of the cheapest setting that a hand may pick. A table in Markdown.
#include "render/study/engine.h"
#include "render/study/law.h"
#include "tests/support/accuracy_search.h"

#include <fmt/format.h>

#include <limits>
#include <optional>

namespace {

/// The motion that others are held against: by the scene's law, or of steps that are 16 times shorter than the finest.
std::optional<study::Motion> truth_of(const std::string& file, const test::SearchedRun& run, const std::string& step,
                                      std::int64_t steps) {
    const sim::Law law = sim::study_of(run.scene).law;
    if (law == sim::Law::none) {
        return test::run_scene(file,
                               {"simulation.time_step=\"" + step + "\"", "simulation.impacts=\"stop\"",
                                "simulation.tolerance=1e-8", "simulation.velocity_tolerance=1e-9"},
                               steps, static_cast<int>(run.motion.states.size()))
            .motion;
    }
    std::vector<double> times;
    for (const sim::Snapshot& state : run.motion.states) {
        times.push_back(state.time);
    }
    return study::law_motion(run.scene, law, times);
}

/// Processor time of the cheapest of many settings whose error is at most `asked` [m].
double cheapest(const std::string& file, const test::SearchedRun& like, const study::Motion& truth, double asked,
                std::int64_t instant_steps) {
    double least = std::numeric_limits<double>::infinity();
    const int instants = static_cast<int>(like.motion.states.size());
    for (int parts = 1; parts <= 256; parts *= 2) {
        const std::string step = fmt::format("1/{}", 60 * parts);
        for (const double tolerance : {0.5 * asked, 0.1 * asked}) {
            for (const char* impacts : {"ahead", "stop"}) {
                try {
                    const test::SearchedRun run = test::run_scene(
                        file,
                        {"simulation.time_step=\"" + step + "\"", fmt::format("simulation.tolerance={}", tolerance),
                         fmt::format("simulation.velocity_tolerance={}", 0.1 * tolerance),
                         fmt::format("simulation.impacts=\"{}\"", impacts)},
                        instant_steps * parts, instants);
                    if (study::difference(run.scene, run.motion, truth).rms <= asked) {
                        least = std::min(least, run.cost);
                    }
                } catch (const sim::Error&) { // a step too long for the scene
                }
            }
        }
    }
    return least;
}

void print_row(const std::string& file, double asked) {
    const sim::SceneDef scene = sim::load_scene(file);
    study::AccuracySearch search(scene, asked);
    const std::int64_t instant_steps = search.steps_between(); // of the first step, 1/60 s
    const test::SearchedRun run = test::search(file, search);
    if (search.end() != study::AccuracyEnd::reached) {
        fmt::print("| {} | {:g} | determined until {:.2f} s of {:g} s | | {:.4f} | | |\n", scene.name, asked,
                   search.runs().back().determined_until, scene.output.duration.value(), run.cost);
        return;
    }
    const std::optional<study::Motion> truth = truth_of(file, run, "1/245760", instant_steps * 4096);
    const double hand = cheapest(file, run, *truth, asked, instant_steps);
    fmt::print("| {} | {:g} | {:.1e} | {:.1e} | {:.4f} | {:.4f} | {:.1f} |\n", scene.name, asked, search.estimate(),
               study::difference(run.scene, run.motion, *truth).rms, run.cost, hand, run.cost / hand);
}

} // namespace

int main(int argc, char** argv) {
    fmt::print("| scene | asked [m] | estimate [m] | true error [m] | cost of all runs [s] | of the cheapest by hand [s] | "
               "ratio |\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for (int i = 1; i < argc; ++i) {
        for (const double asked : {1e-3, 1e-4, 1e-5, 1e-6}) {
            print_row(argv[i], asked);
        }
    }
}
