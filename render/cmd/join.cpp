/// tumble join: the film from the frames of one or more folders, the same bytes as from one run.
#include "render/cmd/interrupt.h"
#include "render/cmd/options.h"
#include "render/cmd/progress.h"
#include "render/cmd/run_folder.h"
#include "render/cmd/run_record.h"
#include "render/film/film.h"
#include "sim/base/error.h"
#include "sim/scene/file.h"

#include <fmt/format.h>

#include <cstdio>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

sim::SceneDef scene_of(const RunRecord& record) {
    return sim::parse_scene(record.scene_text, record.scene_name + ".toml", record.overrides);
}

/// The scene of all folders. Throws Error: io if one has no record, usage if they differ.
sim::SceneDef common_scene(const std::vector<std::string>& folders) {
    std::optional<RunRecord> first;
    for (const std::string& folder : folders) {
        const std::optional<RunRecord> record = read_run_record(folder);
        if (!record) {
            throw Error(ExitCode::io, fmt::format("cannot read {}: No such file or directory",
                                                  (fs::path(folder) / run_record_name).string()));
        }
        if (!first) {
            first = record;
            continue;
        }
        const std::string difference = record_difference(*record, *first);
        if (!difference.empty()) {
            throw Error(ExitCode::usage,
                        fmt::format("{} does not belong to {}: {}", folder, folders.front(), difference));
        }
    }
    return scene_of(*first);
}

/// Throws Error (usage) if the folder holds another run than that of `input`, a folder with frames.
void require_same_run(const fs::path& folder, const fs::path& input) {
    std::error_code error;
    if (fs::equivalent(folder, input, error)) {
        return;
    }
    const std::optional<RunRecord> there = read_run_record(folder);
    const bool is_other =
        there ? !record_difference(*read_run_record(input), *there).empty()
              : fs::exists(folder / summary_name, error) || fs::exists(folder / trajectory_name, error);
    if (is_other) {
        throw Error(ExitCode::usage, fmt::format("{} holds another run than {}; choose another folder with --out",
                                                 folder.string(), input.string()));
    }
}

/// Where each frame lies. Throws Error (missing_or_size) naming the first that is nowhere.
std::vector<fs::path> frame_paths(const std::vector<std::string>& folders, std::int64_t count) {
    std::vector<fs::path> paths;
    for (std::int64_t frame = 0; frame < count; ++frame) {
        const std::string name = render::frame_file_name(frame);
        std::error_code error;
        for (const std::string& folder : folders) {
            if (fs::is_regular_file(fs::path(folder) / name, error)) {
                paths.push_back(fs::path(folder) / name);
                break;
            }
        }
        if (paths.size() != static_cast<std::size_t>(frame) + 1) {
            throw Error(ExitCode::missing_or_size,
                        fmt::format("frame {} of {} is missing: no {}", frame, count,
                                    (fs::path(folders.front()) / name).string()));
        }
    }
    return paths;
}

} // namespace

void join_frames(const Options& options) {
    const sim::SceneDef scene = common_scene(options.inputs);
    const sim::OutputDef& output = scene.output;
    const std::vector<fs::path> paths =
        frame_paths(options.inputs, sim::frame_count(output.duration, output.fps));
    const fs::path folder =
        options.out.empty() ? fs::path(options.inputs.front()) : options.out / fs::path(scene.name);
    require_film(scene);
    const Workplace workplace(folder, run_names(scene.name));
    require_same_run(folder, options.inputs.front());
    forget_products(workplace, scene.name, true);
    const std::string name = render::film_file_name(scene);
    render::VideoWriter video(folder / name, output.width, output.height, render::video_settings(scene));
    Progress progress(scene.name, "frames", static_cast<std::int64_t>(paths.size()), progress_style(options));
    std::int64_t done = 0;
    for (const fs::path& path : paths) {
        const render::Image image = render::read_image(path);
        if (image.width != output.width || image.height != output.height) {
            throw Error(ExitCode::missing_or_size,
                        fmt::format("{} has {}x{} pixels, expected {}x{}", path.string(), image.width,
                                    image.height, output.width, output.height));
        }
        if (is_interrupted()) {
            progress.clear();
            throw Error(ExitCode::interrupted, "interrupted; no film was made");
        }
        video.add(image);
        progress.update(++done);
    }
    video.finish();
    progress.clear();
    std::vector<sim::WrittenFile> made = render::make_stills(
        scene, stills_of(options), [&](std::int64_t frame) { return paths[static_cast<std::size_t>(frame)]; },
        folder);
    if (const std::string summary = read_summary(folder); !summary.empty()) {
        const auto files = *sim::files_of_summary(summary);
        made.insert(made.begin(), sim::describe_file(folder, name));
        made.insert(made.begin(), files.begin(), files.end());
        sim::write_file(folder / summary_name, sim::summary_with_files(summary, made));
    }
    if (!options.is_quiet) {
        std::printf("%s: %zu frames joined; in %s\n", scene.name.c_str(), paths.size(),
                    (folder / name).c_str());
    }
}

} // namespace cmd
