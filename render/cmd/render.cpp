/// tumble render: pictures and film of an earlier simulation.
#include "render/cmd/elsewhere.h"
#include "render/cmd/films.h"
#include "render/cmd/key_options.h"
#include "render/cmd/options.h"
#include "render/cmd/recorded_frames.h"
#include "render/cmd/run_folder.h"
#include "render/cmd/run_record.h"
#include "render/cmd/supervise.h"
#include "render/film/film.h"
#include "render/gl/context.h"
#include "sim/base/error.h"
#include "sim/record/trajectory.h"
#include "sim/scene/file.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdio>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// The scene as it was simulated, with another size, rate or look where the user asks for it.
sim::SceneDef scene_of(const sim::TrajectoryReader& trajectory, const std::string& path,
                       const Options& options) {
    const sim::TrajectoryInfo& info = trajectory.info();
    std::vector<std::string> overrides = info.overrides;
    for (const std::string& assignment : overrides_of(options)) {
        if (assignment.starts_with("simulation.")) {
            throw Error(ExitCode::usage,
                        fmt::format("--set {}: the simulation has been made; use tumble run", assignment));
        }
        overrides.push_back(assignment);
    }
    const auto parsed = [&] {
        try {
            return sim::parse_scene(info.scene_text, info.scene_name + ".toml", overrides);
        } catch (const Error& error) {
            throw Error(error.code(), as_typed(error.what(), options));
        }
    };
    sim::SceneDef scene = parsed();
    scene.output.gl = options.gl.empty() ? scene.output.gl : options.gl;
    sim::require_same_bodies(info, scene, path);
    if (sim::contacts_shown(scene) > trajectory.contacts()) {
        throw Error(
            ExitCode::usage,
            fmt::format("{} has not recorded the contacts that the pictures are to show; simulate again "
                        "with the same settings of overlay and plot",
                        path));
    }
    return scene;
}

/// Enters the new pictures in the summary, if there is one.
void sum_up(const sim::SceneDef& scene, const render::Film& film, const std::vector<sim::WrittenFile>& stills,
            const fs::path& folder) {
    const std::string text = read_summary(folder);
    if (text.empty()) {
        return;
    }
    sim::Summary drawn;
    add_pictures(scene, film, drawn);
    std::vector<sim::WrittenFile> files = *sim::files_of_summary(text); // of what was not drawn
    std::error_code error;
    if (fs::exists(folder / run_record_name, error)) {
        files.push_back(sim::describe_file(folder, run_record_name));
    }
    files.insert(files.end(), drawn.files.begin(), drawn.files.end());
    files.insert(files.end(), stills.begin(), stills.end());
    drawn.files = files;
    sim::write_file(folder / summary_name, sim::summary_with_pictures(text, scene, drawn));
}

/// Hands the recorded frames to the film, with the states before them that its curves and paths show.
void add_frames(render::Film& film, const sim::TrajectoryReader& trajectory, const RecordedFrames& recorded,
                const FrameRange& frames) {
    const std::int64_t first = film.shows_past() ? 0 : frames.begin;
    std::size_t next = film.shows_past() ? 0 : recorded.record_before(first);
    for (std::int64_t frame = first; frame < frames.end; ++frame) {
        for (; next <= recorded.record_before(frame) && film.shows_past(); ++next) {
            film.observe(trajectory.read(next));
        }
        if (!film.add(frame, recorded.state(frame))) {
            return;
        }
    }
    film.close();
}

/// Frames of an earlier simulation.
struct Recording {
    const sim::TrajectoryReader& trajectory;
    const RecordedFrames& frames;
    FrameRange drawn;
};

/// All of the film, with progress. workplace: see supervise().
void draw_frames(render::Film& film, const Recording& of, const std::string& name, const Workplace* workplace,
                 const Options& options) {
    render::ThreadGroup threads; // ends before what its threads use
    film.start(threads);
    threads.start([&] { add_frames(film, of.trajectory, of.frames, of.drawn); });
    Progress progress(name, "frames", of.drawn.end - of.drawn.begin, progress_style(options));
    supervise(
        threads, progress, [&] { return film.frames_done(); }, workplace);
}

/// seconds: wall time of it all.
void print_times(const sim::SceneDef& scene, const render::Film& film, const FrameRange& frames, double seconds,
                 const std::string& folder) {
    const auto count = static_cast<double>(frames.end - frames.begin);
    const render::FilmTimes& times = film.times();
    std::fputs(fmt::format("{}: {} frames in {}, {:.1f} ms each; processor time of the stages: list {:.1f}, "
                           "draw {:.1f}, edges {:.1f}, png {:.1f}, video {:.1f} ms; in {}\n",
                           scene.name, frames.end - frames.begin, duration_text(seconds), 1e3 * seconds / count,
                           times.list / count, times.draw / count, times.edges / count, times.png / count,
                           times.video / count, folder)
                   .c_str(),
               stdout);
}

void require_products(const Options& options) {
    if (options.no_png && (options.no_video || !options.frames.empty())) {
        throw Error(ExitCode::usage, "--no-png leaves nothing to make");
    }
    if (options.inputs.size() != 1) {
        throw Error(ExitCode::usage, "render takes one trajectory");
    }
}

/// Of a run's folder the trajectory in it.
fs::path trajectory_of(const fs::path& given) {
    std::error_code error;
    return fs::is_directory(given, error) ? given / "trajectory.h5" : given;
}

} // namespace

void render_trajectory(const Options& options) {
    using Clock = std::chrono::steady_clock;
    const Clock::time_point start = Clock::now();
    require_products(options);
    const bool has_pipe = is_piped(options);
    const render::StillsSettings stills = stills_of(options);
    const fs::path path = trajectory_of(options.inputs.front());
    render::configure_gl(options.is_portable);
    const sim::TrajectoryReader trajectory(path);
    sim::SceneDef scene = scene_of(trajectory, path.string(), options);
    render::check_overlay(scene);
    const RecordedFrames recorded(trajectory, path.string(), scene);
    const std::int64_t frame_count = recorded.count();
    const FrameRange frames = frame_range(options, frame_count);
    const bool is_slice = !options.frames.empty();
    require_film(scene, !options.no_video && !is_slice);

    if (has_pipe) {
        render::Film film(scene, piped_film(options, frames.begin));
        draw_frames(film, {trajectory, recorded, frames}, scene.name, nullptr, options);
        return;
    }
    const fs::path folder = options.out.empty() ? path.parent_path() : options.out / fs::path(scene.name);
    if (is_elsewhere(options.placement)) {
        render_elsewhere(scene, folder.empty() ? "." : folder, options);
        return;
    }
    const Workplace workplace(folder.empty() ? "." : folder, run_names(scene.name),
                              is_slice ? Sharing::with_slices : Sharing::alone);
    const bool has_video = !options.no_video && !is_slice;
    require_same_simulation(workplace.folder(), path);
    const auto forget = [&] { forget_products(workplace, scene.name, false); };
    if (!options.no_png) {
        prepare_frames(workplace, scene, options.is_resumed || is_slice, forget);
    }
    if (!is_slice) {
        forget();
    }
    if (options.no_png) {
        remove_pictures(workplace);
    }
    render::Film film(scene, {.folder = workplace.folder(),
                              .write_png = !options.no_png,
                              .write_video = has_video,
                              .keep_frames = options.is_resumed,
                              .first_frame = frames.begin,
                              .write_bodies = options.has_body_ids});
    draw_frames(film, {trajectory, recorded, frames}, scene.name, &workplace, options);
    const std::vector<sim::WrittenFile> made = render::make_stills(
        scene, stills,
        [&](std::int64_t frame) { return workplace.folder() / render::frame_file_name(frame); },
        workplace.folder());
    if (!is_slice) {
        sum_up(scene, film, made, workplace.folder());
    }
    if (!options.is_quiet) {
        print_times(scene, film, frames, std::chrono::duration<double>(Clock::now() - start).count(),
                    workplace.folder().string());
        std::fputs(options.no_video || is_slice ? "" : film_note(scene).c_str(), stdout);
    }
}

} // namespace cmd
