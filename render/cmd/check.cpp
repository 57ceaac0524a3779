/// tumble check: reads and validates scenes, and prints what they contain.
#include "render/cmd/options.h"
#include "render/cmd/pilot.h"
#include "render/cmd/progress.h"
#include "render/cmd/simulation.h"
#include "render/overlay/overlay.h"
#include "render/study/law.h"
#include "sim/model/film_clock.h"
#include "sim/scene/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <sys/resource.h>

namespace cmd {

namespace {

constexpr double pilot_seconds = 1.0;

/// [bytes] of a body in a record of a trajectory: pose and velocities.
constexpr double record_bytes = 13 * sizeof(double);

/// Time, disk and memory of a run, from a pilot.
std::string estimate_text(const sim::SceneDef& scene, const Options& options) {
    const SimulationPilot pilot = pilot_simulation(scene, thread_count(options), pilot_seconds);
    const PictureCost picture = pilot_pictures(scene, pilot, !options.no_png, !options.no_video);
    const auto frames = static_cast<double>(frame_count_of(scene));
    const double simulation = pilot.whole_time();
    const double pictures = frames * picture.wall;
    // A step takes its time for contacts, and of a film that begins in the air a pilot sees few.
    const std::string condition =
        pilot.is_whole() ? "" : fmt::format(" if contacts become no more than the pilot's {}", pilot.states.back()->contact_count);
    const int every = scene.output.record_every;
    const double records = every > 0 ? static_cast<double>(sim::step_count_of(scene)) / every : frames;
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    constexpr double mega = 1e6;
    return fmt::format(
        "{}: estimate, of a pilot that simulated {:.0f} % of it: simulation {}{}, pictures {}, both at the same time {} or more; "
        "{:.3g} MB of frames and film, {:.3g} MB of trajectory; {:.3g} MB of memory\n",
        scene.name, 100.0 * static_cast<double>(pilot.seconds.size()) / pilot_parts, duration_text(simulation), condition,
        duration_text(pictures), duration_text(std::max(simulation, pictures)), frames * picture.bytes / mega,
        records * static_cast<double>(scene.bodies.size()) * record_bytes / mega, 1024.0 * static_cast<double>(used.ru_maxrss) / mega);
}

} // namespace

void check_scenes(const Options& options) {
    for (const std::string& input : options.inputs) {
        const sim::SceneDef scene = load_scene(input, options);
        study::require_study(scene);
        render::check_overlay(scene);
        if (!options.is_quiet) {
            std::fputs(sim::describe_scene(scene).c_str(), stdout);
        }
        if (options.is_estimated) {
            std::fputs(estimate_text(scene, options).c_str(), stdout);
        }
    }
}

} // namespace cmd
