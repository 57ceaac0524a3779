/// Films on a cluster: the simulation, slices of frames from its trajectory, and the join, each after the one
/// before.
#include "render/cmd/elsewhere.h"

#include "render/cmd/run_folder.h"
#include "render/cmd/run_record.h"
#include "render/cmd/simulation.h"
#include "render/film/film.h"
#include "render/gl/context.h"
#include "render/gl/shader.h"
#include "render/picture/renderer.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/record/trajectory.h"
#include "sim/scene/difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <set>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

// Less work, and the start of a task is no longer small beside it [s].
constexpr double least_slice = 20.0;

double processor_time() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Processor time of a frame [s]: of the first one, drawn a second time, and its PNG.
double frame_time(const sim::SceneDef& scene) {
    render::Renderer renderer(scene, scene.output.width, scene.output.height,
                              render::render_settings(scene.output));
    const sim::Snapshot snapshot = sim::World(scene, 1).take_snapshot();
    renderer.draw(snapshot);
    const double before = processor_time();
    render::encode_png(renderer.draw(snapshot));
    const int pictures = scene.output.shutter > 0.0 ? scene.output.subframes : 1;
    return pictures * (processor_time() - before);
}

int slice_count(const sim::SceneDef& scene, const Options& options) {
    const std::int64_t frames = frame_count_of(scene);
    if (options.placement.slices > 0) {
        return static_cast<int>(std::min<std::int64_t>(options.placement.slices, frames));
    }
    const auto wanted =
        static_cast<std::int64_t>(frame_time(scene) * static_cast<double>(frames) / least_slice);
    return static_cast<int>(std::clamp<std::int64_t>(wanted, 1, std::min<std::int64_t>(frames, most_tasks)));
}

/// Words of the command line that the tasks get too.
std::string scene_words(const Options& options) {
    std::string words;
    if (const std::string preset = simulation_preset(options); !preset.empty()) {
        words += " --preset " + preset;
    }
    for (const std::string& assignment : overrides_of(options)) {
        words += " --set " + shell_word(assignment);
    }
    return words;
}

std::string drawing_words(const Options& options) {
    std::string words;
    for (const auto& [is_given, word] :
         {std::pair(options.is_portable, " --portable"), std::pair(options.has_body_ids, " --body-ids")}) {
        words += is_given ? word : "";
    }
    return words + (options.gl.empty() ? "" : " --gl " + options.gl);
}

std::string still_words(const Options& options) {
    return (options.poster_time >= 0.0 ? fmt::format(" --poster {}", options.poster_time) : "") +
           (options.sheet_count > 0 ? fmt::format(" --sheet {}", options.sheet_count) : "") +
           (options.has_webp ? " --webp" : "") + (options.has_gif ? " --gif" : "") +
           (options.animation_width > 0 ? fmt::format(" --animation-width {}", options.animation_width) : "") +
           (options.animation_rate > 0.0 ? fmt::format(" --animation-fps {}", options.animation_rate) : "");
}

/// Where the results of a scene go: every task and the caller name it alike.
std::string out_word(const fs::path& folder) {
    return shell_word(folder.parent_path().empty() ? "." : folder.parent_path().string());
}

/// True if the trajectory is whole and of this scene.
bool is_simulated(const sim::SceneDef& scene, const fs::path& path) {
    std::error_code error;
    if (!fs::exists(path, error)) {
        return false;
    }
    try {
        const sim::TrajectoryReader trajectory(path);
        return trajectory.info().program_version == TUMBLE_VERSION &&
               sim::scene_difference({scene.text, scene.overrides},
                                     {trajectory.info().scene_text, trajectory.info().overrides})
                   .empty();
    } catch (const Error&) {
        return false; // a damaged one is made again
    }
}

/// True if frames of the folder were made from something else than this scene and program.
bool has_other_frames(const sim::SceneDef& scene, const fs::path& folder) {
    const std::optional<RunRecord> record = read_run_record(folder);
    if (!record) {
        return false;
    }
    return record->program != "tumble " TUMBLE_VERSION || record->shaders != render::shaders_hash() ||
           !sim::scene_difference({scene.text, scene.overrides}, {record->scene_text, record->overrides})
                .empty();
}

/// Which frames are there. One look at the folder, which may be another machine's.
std::vector<bool> frames_there(const fs::path& folder, std::int64_t count) {
    std::set<fs::path> names;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / "frames", error)) {
        names.insert(entry.path());
    }
    std::vector<bool> there;
    for (std::int64_t frame = 0; frame < count; ++frame) {
        there.push_back(names.contains(folder / render::frame_file_name(frame)));
    }
    return there;
}

/// A film whose stages are known but for what is missing of them.
struct ClusterFilm {
    sim::SceneDef scene;
    fs::path folder;
    fs::path trajectory;
    std::string simulate{}; ///< command; empty: the trajectory is there
};

BatchStage draw_stage(const ClusterFilm& film, const Options& options, const std::string& words) {
    const std::int64_t frames = frame_count_of(film.scene);
    BatchStage stage{.name = "draw", .count = slice_count(film.scene, options)};
    stage.commands =
        fmt::format("{} render {} --out {} --frames $((n * {} / {})):$(((n + 1) * {} / {})) --resume{}"
                    " --quiet",
                    program_word(), shell_word(film.trajectory.string()), out_word(film.folder), frames,
                    stage.count, frames, stage.count, words);
    const std::vector<bool> there = frames_there(film.folder, frames);
    for (int n = 0; n < stage.count; ++n) {
        const auto end = there.begin() + (n + 1) * frames / stage.count;
        if (std::find(there.begin() + n * frames / stage.count, end, false) != end) {
            stage.missing.push_back(n);
        }
    }
    return stage;
}

/// The simulation goes on from a checkpoint, unless that is of another scene or program, or damaged.
void forget_other_checkpoint(const Workplace& workplace, const sim::SceneDef& scene) {
    try {
        read_checkpoint(workplace.folder(), scene);
    } catch (const Error&) {
        workplace.remove_file(checkpoint_name);
    }
}

/// Makes the folder ready, as a run here would, and says what is to be done.
Batch batch_of(const ClusterFilm& film, const Options& options, const std::string& words) {
    Batch batch{.name = film.scene.name, .folder = film.folder};
    const bool simulates = !film.simulate.empty() && !is_simulated(film.scene, film.trajectory);
    if (!film.simulate.empty()) {
        batch.stages.push_back({.name = "simulate", .commands = film.simulate});
        if (simulates) {
            batch.stages.back().missing = {0};
        }
    }
    if (simulates || has_other_frames(film.scene, film.folder)) {
        const Workplace workplace(film.folder, run_names(film.scene.name));
        forget_other_checkpoint(workplace, film.scene);
        forget_products(workplace, film.scene.name, false);
        remove_pictures(workplace);
    }
    batch.stages.push_back(draw_stage(film, options, words));
    if (!options.no_video) {
        BatchStage join{.name = "join"};
        join.commands = fmt::format("{} join {} --quiet{}", program_word(), shell_word(film.folder.string()),
                                    still_words(options));
        std::error_code error;
        if (!batch.stages.back().missing.empty() || !still_words(options).empty() ||
            !fs::exists(film.folder / render::film_file_name(film.scene), error)) {
            join.missing = {0};
        }
        batch.stages.push_back(join);
    }
    return batch;
}

void check_options(const Options& options) {
    if (options.no_png) {
        throw Error(ExitCode::usage,
                    "--on slurm draws PNG files, from which the film is joined: not with --no-png");
    }
    if (!options.frames.empty()) {
        throw Error(ExitCode::usage, "--on slurm divides the film by itself: --slices, not --frames");
    }
    if (render::StillsSettings stills = stills_of(options); stills.is_needed() && options.no_video) {
        throw Error(ExitCode::usage,
                    "--on slurm makes posters, sheets and animations with the film: not with --no-video");
    }
}

void run_films(const std::vector<ClusterFilm>& films, const Options& options, const std::string& words) {
    std::vector<Batch> batches;
    std::int64_t total = 0;
    for (const ClusterFilm& film : films) {
        require_film(film.scene);
        batches.push_back(batch_of(film, options, words));
        total += frame_count_of(film.scene);
    }
    const auto done = [&films] {
        std::int64_t count = 0;
        for (const ClusterFilm& film : films) {
            const std::vector<bool> there = frames_there(film.folder, frame_count_of(film.scene));
            count += std::count(there.begin(), there.end(), true);
        }
        return count;
    };
    const bool is_done =
        run_batches(batches, options.placement,
                    {.unit = "frames", .total = total, .done = done, .progress = progress_style(options)});
    for (const ClusterFilm& film : films) {
        if (is_done && !options.is_quiet) {
            std::printf("%s: %lld frames; in %s\n", film.scene.name.c_str(),
                        static_cast<long long>(frame_count_of(film.scene)), film.folder.c_str());
        }
    }
}

} // namespace

void run_scenes_elsewhere(const std::vector<sim::SceneDef>& scenes, const Options& options) {
    check_options(options);
    std::vector<ClusterFilm> films;
    const fs::path out = options.out.empty() ? "out" : options.out;
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        const fs::path folder = out / scenes[i].name;
        if (options.inputs[i] == "-") {
            throw Error(ExitCode::usage, "--on slurm reads scenes on the cluster: expected a file, not standard input");
        }
        ClusterFilm film{.scene = scenes[i], .folder = folder, .trajectory = folder / "trajectory.h5"};
        film.simulate = fmt::format("{} simulate {} --out {}{} {} --threads \"$cores\" --resume --quiet", program_word(),
                                    shell_word(options.inputs[i]), out_word(folder), scene_words(options),
                                    options.is_strict ? "--strict" : "--no-strict");
        films.push_back(std::move(film));
    }
    run_films(films, options, drawing_words(options));
}

void render_elsewhere(const sim::SceneDef& scene, const fs::path& folder, const Options& options) {
    check_options(options);
    run_films({{.scene = scene, .folder = folder, .trajectory = options.inputs.front()}}, options,
              scene_words(options) + drawing_words(options));
}

} // namespace cmd
