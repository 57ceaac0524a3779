/// tumble run and tumble simulate: one scene after the other; within a scene, simulation, drawing, PNG and
/// film each in a thread.
#include "render/cmd/accuracy.h"
#include "render/cmd/budget.h"
#include "render/cmd/elsewhere.h"
#include "render/cmd/films.h"
#include "render/cmd/options.h"
#include "render/cmd/run_folder.h"
#include "render/cmd/run_record.h"
#include "render/cmd/simulation.h"
#include "render/cmd/supervise.h"
#include "render/gl/context.h"
#include "render/gl/shader.h"
#include "render/study/law.h"
#include "render/study/promise.h"
#include "sim/base/error.h"
#include "sim/scene/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <set>
#include <utility>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

using Clock = std::chrono::steady_clock;

/// What the preset of a run promised and what was reached.
sim::PresetResult preset_result(const sim::SceneDef& scene, const Simulation& simulation,
                                const Options& options) {
    const auto preset = study::find_preset(simulation_preset(options));
    if (!preset) {
        return {};
    }
    study::Reached reached;
    const sim::Summary summary = simulation.summary();
    reached.overlap = summary.totals.max_penetration;
    if (summary.simulated_time > 0.0) {
        reached.cost = simulation.processor_time() / summary.simulated_time;
    }
    if (!simulation.law_states().empty()) {
        std::vector<double> times;
        for (const sim::Snapshot& state : simulation.law_states()) {
            times.push_back(state.time);
        }
        const study::Motion truth = study::law_motion(scene, sim::study_of(scene).law, times);
        reached.error = study::difference(scene, {simulation.law_states()}, truth);
    }
    return {study::preset_names[static_cast<std::size_t>(*preset)], study::promises_of(scene, *preset, reached)};
}

void print_result(const sim::SceneDef& scene, const sim::Summary& summary, bool has_pictures,
                  const fs::path& folder) {
    const sim::StepTotals& totals = summary.totals;
    std::string line = scene.name + ": ";
    if (has_pictures) {
        line += fmt::format("{} frames, ", frame_count_of(scene));
    }
    line += fmt::format("{} steps in {}; largest overlap {:.2g} m", totals.steps,
                        duration_text(summary.wall_time), totals.max_penetration);
    const auto add_steps = [&](auto count, const char* where) {
        if (count > 0) {
            line += fmt::format("; {} step{} {}", count, count == 1 ? "" : "s", where);
        }
    };
    add_steps(totals.steps_above_tolerance, "above the tolerance");
    if (totals.max_energy_gain > sim::energy_gain_allowed) {
        line += fmt::format("; gained {:.3g} % of the energy that it turned over", 100.0 * totals.max_energy_gain);
    }
    add_steps(totals.steps_at_iteration_limit, "at the iteration limit");
    if (const double step = scene.step.time_step.value(); totals.interval() < 0.5 * step) { // mostly, not here and there
        line += fmt::format("; steps of {:.3g} s were divided into {:.2g} s", step, totals.interval());
    }
    line += fmt::format("; energy {:.4g} J to {:.4g} J; state {:016x}; in {}\n",
                        summary.start.kinetic_energy + summary.start.potential_energy,
                        summary.end.kinetic_energy + summary.end.potential_energy, summary.state_hash,
                        folder.string());
    if (!summary.preset.preset.empty()) {
        line += fmt::format("{}: preset {}: {}\n", scene.name, summary.preset.preset,
                            study::promises_text(summary.preset.promises));
    }
    if (summary.accuracy.asked > 0.0) {
        line += fmt::format("{}: {}\n", scene.name, accuracy_text(summary.accuracy, totals));
    }
    if (const sim::BudgetResult& budget = summary.budget; budget.asked > 0.0) {
        line += fmt::format("{}: took {:.3g} s of {:g} s\n", scene.name, budget.measuring + summary.wall_time, budget.asked);
    }
    std::fputs(line.c_str(), stdout);
    std::fflush(stdout);
}

/// What of the work is shown, and where it can be stopped.
struct Watch {
    std::string name;
    const Workplace* workplace = nullptr; ///< null: no folder is written to
    ProgressStyle style;
};

/// Runs simulation and film to their end, with progress.
void work(Simulation& simulation, render::Film* film, const FrameRange& frames, const Watch& watch) {
    const auto& [name, workplace, style] = watch;
    render::ThreadGroup threads; // ends before what its threads use
    if (film != nullptr) {
        film->start(threads);
    }
    threads.start([&] { simulation.advance(threads); });
    if (film != nullptr) {
        Progress progress(name, "frames", frames.end - frames.begin, style);
        supervise(
            threads, progress, [&] { return film->frames_done(); }, workplace);
    } else {
        Progress progress(name, "steps", std::max<std::int64_t>(1, simulation.last_step()), style);
        supervise(
            threads, progress, [&] { return simulation.steps_done(); }, workplace);
    }
}

/// --frames: these frames and nothing else, for tumble join. Other slices may be drawn into the folder
/// meanwhile. Returns the promise that was missed, as run_scene does.
std::string run_slice(sim::SceneDef& scene, const fs::path& folder, const Options& options) {
    const Clock::time_point start = Clock::now();
    const FrameRange frames = frame_range(options, frame_count_of(scene));
    sim::World world(scene, thread_count(options));
    const Workplace workplace(folder, run_names(scene.name), Sharing::with_slices);
    prepare_frames(workplace, scene, true, [&] { forget_run(workplace, scene.name); });
    render::Film film(scene, {.folder = folder,
                              .write_video = false,
                              .keep_frames = options.is_resumed,
                              .first_frame = frames.begin,
                              .write_bodies = options.has_body_ids});
    Simulation simulation(scene, std::move(world), &film);
    simulation.restrict_to(frames);
    work(simulation, &film, frames, {scene.name, &workplace, progress_style(options)});
    if (!options.is_quiet) {
        std::printf("%s: frames %lld to %lld in %s; in %s\n", scene.name.c_str(),
                    static_cast<long long>(frames.begin), static_cast<long long>(frames.end - 1),
                    duration_text(std::chrono::duration<double>(Clock::now() - start).count()).c_str(),
                    folder.c_str());
    }
    return simulation.missed_promise();
}

/// --out -: frames to standard output, and no files.
std::string run_piped(const sim::SceneDef& scene, const Options& options) {
    const FrameRange frames = frame_range(options, frame_count_of(scene));
    sim::World world(scene, thread_count(options));
    render::Film film(scene, piped_film(options, frames.begin));
    Simulation simulation(scene, std::move(world), &film);
    simulation.restrict_to(frames);
    work(simulation, &film, frames, {scene.name, nullptr, progress_style(options)});
    return simulation.missed_promise();
}

/// A scene to be run.
struct Task {
    std::string input; ///< its file
    sim::SceneDef scene;
    fs::path folder;
    sim::BudgetResult budget{};
};

/// What the run has made, once its simulation and film have ended.
sim::Summary summary_of(const Task& task, const Simulation& simulation, const render::Film* film, const Options& options) {
    sim::Summary summary = simulation.summary();
    summary.threads = thread_count(options);
    summary.preset = preset_result(task.scene, simulation, options);
    summary.budget = task.budget;
    summary.files.push_back(sim::describe_file(task.folder, trajectory_name));
    if (film != nullptr && !options.no_png) {
        summary.files.push_back(sim::describe_file(task.folder, run_record_name));
    }
    if (film != nullptr) {
        add_pictures(task.scene, *film, summary);
    }
    const auto frame_path = [&](std::int64_t frame) { return task.folder / render::frame_file_name(frame); };
    for (const sim::WrittenFile& file :
         render::make_stills(task.scene, film != nullptr ? stills_of(options) : render::StillsSettings{}, frame_path, task.folder)) {
        summary.files.push_back(file);
    }
    return summary;
}

/// Where a simulation starts: a world at t = 0, or what a run that was interrupted left.
struct Start {
    sim::World world;
    std::optional<Checkpoint> checkpoint;
};

/// Simulates with the scene's settings, or those of the checkpoint.
std::unique_ptr<Simulation> simulate(const Task& task, Start start, render::Film* film, const Workplace& workplace,
                                     const Options& options) {
    auto simulation = std::make_unique<Simulation>(task.scene, std::move(start.world), film);
    if (start.checkpoint) {
        simulation->go_on_from(std::move(*start.checkpoint), thread_count(options));
    }
    simulation->record_to(task.folder / trajectory_name);
    simulation->keep_checkpoints(task.folder, options.checkpoint_period);
    work(*simulation, film, {0, frame_count_of(task.scene)}, {task.scene.name, &workplace, progress_style(options)});
    return simulation;
}

/// Returns the promise that was missed by most; empty if none was.
std::string run_scene(Task& task, const Options& options, bool has_pictures) {
    const Clock::time_point start = Clock::now();
    sim::SceneDef& scene = task.scene;
    const fs::path& folder = task.folder;
    std::optional<sim::World> world; // first: a scene that cannot start leaves no folder
    if (options.accuracy == 0.0) {
        world.emplace(scene, thread_count(options));
    }
    const Workplace workplace(folder, run_names(scene.name));
    std::optional<Checkpoint> checkpoint = options.is_resumed ? read_checkpoint(folder, scene) : std::nullopt;
    if (checkpoint) {
        scene.overrides = checkpoint->overrides; // which mean the same
    }
    const bool has_png = has_pictures && !options.no_png;
    const auto forget = [&] { forget_run(workplace, scene.name, checkpoint.has_value()); };
    if (has_png) {
        prepare_frames(workplace, scene, options.is_resumed, forget);
    }
    forget();
    if (!has_png) {
        remove_pictures(workplace);
    }

    std::unique_ptr<render::Film> film;
    if (has_pictures) {
        film =
            std::make_unique<render::Film>(scene, render::FilmSettings{.folder = folder,
                                                                       .write_png = has_png,
                                                                       .write_video = !options.no_video,
                                                                       .keep_frames = options.is_resumed,
                                                                       .write_bodies = options.has_body_ids});
    }
    sim::AccuracyResult accuracy;
    const std::unique_ptr<Simulation> simulation =
        world ? simulate(task, {std::move(*world), std::move(checkpoint)}, film.get(), workplace, options)
              : simulate_to_accuracy(task.input, scene, options, workplace, accuracy);

    sim::Summary summary = summary_of(task, *simulation, film.get(), options);
    summary.accuracy = std::move(accuracy);
    summary.wall_time = std::chrono::duration<double>(Clock::now() - start).count();
    sim::write_file(folder / summary_name, sim::summary_to_json(scene, summary));
    workplace.remove_file(checkpoint_name);
    workplace.remove_file(states_name);
    if (!options.is_quiet) {
        print_result(scene, summary, has_pictures, folder);
        std::fputs(has_pictures && !options.no_video ? film_note(scene).c_str() : "", stdout);
    }
    return summary.accuracy.outcome == "missed" ? accuracy_text(summary.accuracy, summary.totals)
                                                 : simulation->missed_promise();
}

/// The film of a simulation that is already there.
void draw(const fs::path& folder, const Options& options) {
    Options drawing;
    drawing.inputs = {(folder / trajectory_name).string()};
    drawing.no_video = options.no_video;
    drawing.no_png = options.no_png;
    drawing.poster_time = options.poster_time;
    drawing.sheet_count = options.sheet_count;
    drawing.has_webp = options.has_webp;
    drawing.has_gif = options.has_gif;
    drawing.animation_width = options.animation_width;
    drawing.animation_rate = options.animation_rate;
    drawing.has_body_ids = options.has_body_ids;
    drawing.gl = options.gl;
    drawing.is_portable = options.is_portable;
    drawing.is_quiet = options.is_quiet;
    drawing.progress = options.progress;
    render_trajectory(drawing);
}

void run_all(const Options& options, bool has_pictures) {
    const bool has_pipe = is_piped(options);
    render::configure_gl(options.is_portable);
    if (options.accuracy > 0.0 || options.budget > 0.0) {
        require_no_settings(options);
    }
    // All are read before the first is run: a mistake in the last one shows at once.
    const fs::path out = options.out.empty() ? "out" : options.out;
    std::vector<sim::SceneDef> scenes;
    std::set<std::string> names;
    for (const std::string& input : options.inputs) {
        scenes.push_back(load_scene(input, options));
        if (!names.insert(scenes.back().name).second) {
            throw Error(ExitCode::usage,
                        fmt::format("{}: a second scene with the name '{}' would write into {}", input,
                                    scenes.back().name, (out / scenes.back().name).string()));
        }
        frame_range(options, frame_count_of(scenes.back()));
        if (has_pictures) {
            render::check_overlay(scenes.back());
            require_film(scenes.back(), !options.no_video && options.frames.empty());
        }
        if (!simulation_preset(options).empty()) {
            study::require_study(scenes.back()); // the error reached is told at the end
        }
    }
    if (is_elsewhere(options.placement)) {
        run_scenes_elsewhere(scenes, options);
        return;
    }
    std::string missed; // of all scenes: each is run
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const bool draws_later = has_pictures && options.accuracy > 0.0;
        Task task{options.inputs[i], scenes[i], out / scenes[i].name};
        if (options.budget > 0.0) {
            task.scene = scene_within_budget(task.input, options, has_pictures, task.budget);
            if (!options.is_quiet) {
                std::fprintf(has_pipe ? stderr : stdout, "%s\n", budget_text(task.scene, task.budget).c_str());
                std::fflush(stdout);
            }
        }
        const std::string promise = has_pipe                 ? run_piped(task.scene, options)
                                    : options.frames.empty() ? run_scene(task, options, has_pictures && !draws_later)
                                                             : run_slice(task.scene, task.folder, options);
        if (draws_later) {
            draw(task.folder, options);
        }
        if (!promise.empty()) {
            missed += (missed.empty() ? "" : "; ") + task.scene.name + ": " + promise;
        }
    }
    if (options.is_strict && !missed.empty()) {
        throw Error(ExitCode::stopped, missed);
    }
}

} // namespace

void run_scenes(const Options& options) {
    if (!options.frames.empty() && options.no_png) {
        throw Error(ExitCode::usage, "--frames makes PNG files only: --no-png leaves nothing to make");
    }
    stills_of(options); // refused before anything is made
    run_all(options, !options.no_png || !options.no_video);
}

void simulate_scenes(const Options& options) {
    run_all(options, false);
}

} // namespace cmd
