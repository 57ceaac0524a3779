/// tumble run and tumble simulate: one scene after the other; within a scene, simulation, drawing, PNG and
/// film each in a thread.
#include "render/cmd/options.h"
#include "render/cmd/supervise.h"
#include "render/film.h"
#include "sim/error.h"
#include "sim/scene_file.h"
#include "sim/summary.h"
#include "sim/trajectory.h"
#include "sim/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
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

constexpr const char* trajectory_name = "trajectory.h5";
constexpr const char* summary_name = "summary.json";

std::int64_t frame_count_of(const sim::SceneDef& scene) {
    return sim::frame_count(scene.output.duration, scene.output.fps);
}

std::int64_t step_count_of(const sim::SceneDef& scene) {
    return sim::step_count(scene.output.duration, scene.step.time_step);
}

/// One scene on its way from state 0 to the end of the film.
class Simulation {
public:
    /// film: may be null.
    Simulation(const sim::SceneDef& scene, sim::World world, const fs::path& folder, render::Film* film)
        : scene_(scene), world_(std::move(world)), trajectory_(folder / trajectory_name, scene), film_(film) {
    }

    /// The thread's work: all steps, or as many as are made until the group stops.
    void advance(const render::ThreadGroup& threads);

    std::int64_t steps_done() const { return steps_done_; }
    /// Once advance() has returned.
    const sim::Summary& summary() const { return summary_; }

private:
    /// Hands the present state to trajectory and film, where it is one of theirs. False once the film stops.
    bool record_state();

    const sim::SceneDef& scene_;
    sim::World world_;
    sim::TrajectoryWriter trajectory_;
    render::Film* film_;
    sim::Summary summary_;
    std::int64_t next_frame_ = 0;
    std::atomic<std::int64_t> steps_done_ = 0;
};

void Simulation::advance(const render::ThreadGroup& threads) {
    const std::int64_t last_step = step_count_of(scene_);
    summary_.start = sim::mechanics(scene_, world_.take_snapshot());
    if (!record_state()) {
        return;
    }
    while (world_.step_index() < last_step) {
        if (threads.is_stopping()) {
            return;
        }
        summary_.totals.add(world_.step());
        ++steps_done_;
        if (!record_state()) {
            return;
        }
    }
    if (film_ != nullptr) {
        film_->close();
    }
    const sim::Snapshot last = world_.take_snapshot();
    summary_.end = sim::mechanics(scene_, last);
    summary_.state_hash = sim::state_hash(last);
    summary_.simulated_time = world_.time();
    trajectory_.finish();
}

bool Simulation::record_state() {
    const std::int64_t step = world_.step_index();
    const sim::OutputDef& output = scene_.output;
    const std::int64_t frame_count = frame_count_of(scene_);
    const auto is_frame_now = [&] {
        return next_frame_ < frame_count &&
               sim::step_of_frame(next_frame_, output.fps, scene_.step.time_step) == step;
    };
    const bool is_record = output.record_every > 0 ? step % output.record_every == 0 : is_frame_now();
    if (!is_record && !is_frame_now()) {
        return true;
    }
    const auto snapshot = std::make_shared<const sim::Snapshot>(world_.take_snapshot());
    if (is_record) {
        trajectory_.append(*snapshot);
    }
    // A step longer than a frame is shown by several.
    for (; is_frame_now(); ++next_frame_) {
        if (film_ != nullptr && !film_->add(next_frame_, snapshot)) {
            return false;
        }
    }
    return true;
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
    if (totals.steps_at_iteration_limit > 0) {
        line += fmt::format("; {} steps at the iteration limit", totals.steps_at_iteration_limit);
    }
    line += fmt::format("; energy {:.4g} J to {:.4g} J; state {:016x}; in {}",
                        summary.start.kinetic_energy + summary.start.potential_energy,
                        summary.end.kinetic_energy + summary.end.potential_energy, summary.state_hash,
                        folder.string());
    std::printf("%s\n", line.c_str());
    std::fflush(stdout);
}

void run_scene(const sim::SceneDef& scene, const fs::path& folder, const Options& options,
               bool has_pictures) {
    const Clock::time_point start = Clock::now();
    sim::World world(scene, thread_count(options)); // first: a scene that cannot start leaves no folder
    const Workplace workplace(folder);
    workplace.remove_file(summary_name);
    workplace.remove_file(trajectory_name);
    workplace.remove_file(scene.name + ".mp4");
    workplace.remove_frames();

    std::unique_ptr<render::Film> film;
    if (has_pictures) {
        if (!options.no_png) {
            workplace.make_frames_folder();
        }
        film = std::make_unique<render::Film>(
            scene, render::FilmSettings{folder, !options.no_png, !options.no_video});
    }
    Simulation simulation(scene, std::move(world), folder, film.get());
    {
        render::ThreadGroup threads; // ends before what its threads use
        if (film != nullptr) {
            film->start(threads);
        }
        threads.start([&] { simulation.advance(threads); });
        if (film != nullptr) {
            Progress progress(scene.name, "frames", frame_count_of(scene), options.is_quiet);
            supervise(
                threads, progress, [&] { return film->frames_done(); }, workplace);
        } else {
            Progress progress(scene.name, "steps", std::max<std::int64_t>(1, step_count_of(scene)),
                              options.is_quiet);
            supervise(
                threads, progress, [&] { return simulation.steps_done(); }, workplace);
        }
    }

    sim::Summary summary = simulation.summary();
    summary.threads = thread_count(options);
    summary.files.push_back(sim::describe_file(folder, trajectory_name));
    if (film != nullptr) {
        const std::vector<sim::WrittenFile> files = film->files();
        summary.files.insert(summary.files.end(), files.begin(), files.end());
    }
    summary.wall_time = std::chrono::duration<double>(Clock::now() - start).count();
    sim::write_file(folder / summary_name, sim::summary_to_json(scene, summary));
    if (!options.is_quiet) {
        print_result(scene, summary, has_pictures, folder);
    }
}

void run_all(const Options& options, bool has_pictures) {
    // All are read before the first is run: a mistake in the last one shows at once.
    const std::vector<std::string> overrides = overrides_of(options);
    const fs::path out = options.out.empty() ? "out" : options.out;
    std::vector<sim::SceneDef> scenes;
    std::set<std::string> names;
    for (const std::string& input : options.inputs) {
        scenes.push_back(sim::load_scene(input, overrides));
        if (!names.insert(scenes.back().name).second) {
            throw Error(ExitCode::usage,
                        fmt::format("{}: a second scene with the name '{}' would write into {}", input,
                                    scenes.back().name, (out / scenes.back().name).string()));
        }
    }
    for (const sim::SceneDef& scene : scenes) {
        run_scene(scene, out / scene.name, options, has_pictures);
    }
}

} // namespace

void run_scenes(const Options& options) {
    run_all(options, !options.no_png || !options.no_video);
}

void simulate_scenes(const Options& options) {
    run_all(options, false);
}

} // namespace cmd
