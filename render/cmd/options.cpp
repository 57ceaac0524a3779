#include "render/cmd/options.h"

#include "render/cmd/key_options.h"
#include "render/cmd/scene_path.h"
#include "render/cmd/usage.h"
#include "render/film/film.h"
#include "render/film/memory.h"
#include "render/study/preset.h"
#include "sim/base/cores.h"
#include "sim/base/error.h"
#include "sim/scene/file.h"
#include "sim/scene/tree.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>

namespace cmd {

using sim::Error;
using sim::ExitCode;

namespace {

// All of standard input, read once.
const std::string& standard_input() {
    static const std::string text{std::istreambuf_iterator<char>(std::cin), {}};
    return text;
}

sim::SceneDef load(const std::string& input, std::span<const std::string> overrides) {
    return input == "-" ? sim::parse_scene(standard_input(), "stdin.toml", overrides)
                        : sim::load_scene(scene_path(input), overrides);
}

// With all changes, and with the simulation's preset below them.
sim::SceneDef load_with_preset(const Options& options, const std::string& input) {
    const std::vector<std::string> changes = overrides_of(options);
    sim::SceneDef scene = load(input, changes);
    const std::string word = simulation_preset(options);
    if (!word.empty()) {
        // From the file's own settings, not from those given by --set, which come last and hold.
        std::vector<std::string> all =
            study::preset_overrides(load(input, {}), *study::find_preset(word));
        all.insert(all.end(), changes.begin(), changes.end());
        scene = load(input, all);
    }
    scene.output.gl = options.gl.empty() ? scene.output.gl : options.gl;
    return scene;
}

} // namespace

void add_options(CLI::App& verb, Options& options, Changes changes) {
    verb.add_option("--out", options.out,
                    changes == Changes::everything ? "Folder for the results, DIR/SCENE/; out/SCENE/ if not given"
                                                   : "Folder for the results; the one that is read if not given")
        ->type_name("DIR");
    const bool simulates = changes == Changes::everything;
    verb.add_option(
            "--preset", options.presets,
            simulates
                ? "Of the simulation: preview, standard or accurate; of the pictures: draft, standard or "
                  "final; one of each, separated by a comma"
                : "Size, edges, shadows and encoder: draft, standard or final")
        ->type_name("WORDS")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(one_of(simulates ? std::vector<std::string>{"preview", "standard", "accurate", "draft", "final"}
                                : std::vector<std::string>{"draft", "standard", "final"}));
    add_key_options(verb, options, changes);
    verb.add_option("--threads", options.threads,
                    "Threads of the simulation, else one a core; the result does not depend on it")
        ->type_name("N")
        ->check(whole_number(1, 1024));
    verb.add_option("--set", options.assignments, "Sets any key of the scene, such as light.sun_intensity=2")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    verb.add_flag("--no-video", options.no_video, "No MP4");
    verb.add_flag("--no-png", options.no_png, "No PNG frames");
    add_progress_options(verb, options);
}

void add_progress_options(CLI::App& verb, Options& options) {
    verb.add_option("--progress", options.progress, "text, or json: an object a second on standard error, for machines")
        ->type_name("WORD")
        ->check(one_of({"text", "json"}));
    verb.add_flag("--quiet", options.is_quiet, "Only errors are printed");
}

void add_frame_options(CLI::App& verb, Options& options) {
    verb.add_option("--frames", options.frames, "Draws only the frames A to B - 1, for tumble join")
        ->type_name("A:B");
    verb.add_option("--format", options.format, "With --out -: y4m (4:4:4, BT.709) or rgb24; frames go to standard output")
        ->type_name("WORD")
        ->check(one_of({"y4m", "rgb24"}));
    verb.add_flag("--body-ids", options.has_body_ids,
                  "Beside each frame which body each pixel shows: tumble compare then names bodies");
    add_gl_option(verb, options.gl);
    add_placement_options(verb, options.placement);
    verb.add_option("--slices", options.placement.slices,
                    "With --on slurm: tasks that draw the film; so many that each has 20 s of work, if not given")
        ->type_name("N")
        ->check(whole_number(1, 1000));
    verb.add_flag("--portable", options.is_portable,
                  "The same pictures on processors with and without fused multiply-add; slower");
}

void add_checkpoint_options(CLI::App& verb, Options& options) {
    verb.add_flag("--resume", options.is_resumed,
                  "Goes on after an interruption, from the last checkpoint of the simulation; whole frames are kept");
    verb.add_option("--checkpoint", options.checkpoint_period,
                    "Seconds of work from checkpoint to checkpoint; 30, or more where that is "
                    "less than a hundred times what one takes to write")
        ->type_name("S")
        ->check(number_from(0.0, 1e6));
}

void add_gl_option(CLI::App& verb, std::string& gl) {
    verb.add_option("--gl", gl, "What draws: osmesa, egl, or egl:0 and on, graphics cards; see tumble devices")
        ->type_name("DEVICE")
        ->check(CLI::Validator([](const std::string& word) { return sim::gl_word_fault(word); }, ""));
}

void add_strict_option(CLI::App& verb, Options& options) {
    const char* ci = std::getenv("CI");
    options.is_strict = ci != nullptr && std::string_view(ci) == "true";
    verb.add_flag("--strict,!--no-strict", options.is_strict,
                  "Exit code 5 if a step ends above the tolerance, does not converge or gains energy; the default where CI=true");
}

void add_search_options(CLI::App& verb, Options& options) {
    verb.add_option("--accuracy", options.accuracy,
                    "Finds time step and tolerances: motion to this length, such as 1mm or 1e-5 (metres)")
        ->type_name("LENGTH")
        ->transform(quantity({{"", 1.0}, {"m", 1.0}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}}));
    verb.add_option("--budget", options.budget,
                    "Finds the most accurate settings and the best pictures for this time, such as 30s or 5min")
        ->type_name("TIME")
        ->transform(quantity({{"", 1.0}, {"s", 1.0}, {"min", 60.0}, {"h", 3600.0}}));
}

void add_still_options(CLI::App& verb, Options& options) {
    verb.add_option("--poster", options.poster_time, "Also the frame at this time [s] as SCENE_poster.png")
        ->type_name("S")
        ->check(number_from(0.0, 1e6));
    verb.add_option("--sheet", options.sheet_count, "Also N frames side by side as SCENE_sheet.png")
        ->type_name("N")
        ->check(whole_number(1, 400));
    verb.add_flag("--webp", options.has_webp, "Also an animation for a page: SCENE.webp");
    verb.add_flag("--gif", options.has_gif, "Also an animation of 256 colours, for what shows nothing else: SCENE.gif");
    const render::StillsSettings usual;
    verb.add_option("--animation-width", options.animation_width,
                    fmt::format("Of --webp and --gif [px], else {}; no wider than the frames", usual.animation_width))
        ->type_name("PX")
        ->check(whole_number(16, 16384));
    verb.add_option("--animation-fps", options.animation_rate,
                    fmt::format("Pictures a second of --webp and --gif, else {:g}; no more than the film's",
                                usual.animation_rate))
        ->type_name("N")
        ->check(number_from(0.1, 1e4));
}

render::StillsSettings stills_of(const Options& options) {
    render::StillsSettings stills;
    if (options.poster_time >= 0.0) {
        stills.poster_time = options.poster_time;
    }
    stills.sheet_count = options.sheet_count;
    stills.has_webp = options.has_webp;
    stills.has_gif = options.has_gif;
    stills.animation_width = options.animation_width > 0 ? options.animation_width : stills.animation_width;
    stills.animation_rate = options.animation_rate > 0.0 ? options.animation_rate : stills.animation_rate;
    if ((options.animation_width > 0 || options.animation_rate > 0.0) && !stills.has_webp && !stills.has_gif) {
        throw Error(ExitCode::usage, "--animation-width and --animation-fps are of --webp and --gif: expected one of them too");
    }
    if (stills.is_needed() && options.no_png) {
        throw Error(ExitCode::usage,
                    "--poster, --sheet, --webp and --gif are made of the PNG files: not with --no-png");
    }
    if (stills.is_needed() && !options.frames.empty()) {
        throw Error(
            ExitCode::usage,
            "--poster, --sheet, --webp and --gif need the whole film: give them to tumble join, not with --frames");
    }
    return stills;
}

FrameRange frame_range(const Options& options, std::int64_t frame_count) {
    if (options.frames.empty()) {
        return {0, frame_count};
    }
    const std::string& text = options.frames;
    const std::size_t colon = text.find(':');
    if (colon != std::string::npos) {
        const std::optional<long> begin = parse_integer(std::string_view(text).substr(0, colon));
        const std::optional<long> end = parse_integer(std::string_view(text).substr(colon + 1));
        if (begin && end && *begin >= 0 && *begin < *end && *end <= frame_count) {
            return {*begin, *end};
        }
    }
    throw Error(ExitCode::usage,
                fmt::format("--frames '{}': expected A:B with 0 <= A < B <= {}", text, frame_count));
}

namespace {

/// The one word of `presets` that `is_meant`; empty if there is none. Throws Error (usage) if there are two.
std::string one_preset(const Options& options, bool (*is_meant)(const std::string&)) {
    std::string found;
    for (const std::string& word : options.presets) {
        if (is_meant(word)) {
            if (!found.empty() && found != word) {
                throw Error(
                    ExitCode::usage,
                    fmt::format("--preset {},{}: expected one preset of the simulation (preview, standard, "
                                "accurate) and one of the pictures (draft, standard, final)",
                                found, word));
            }
            found = word;
        }
    }
    return found;
}

} // namespace

std::string picture_preset(const Options& options) {
    const std::string word =
        one_preset(options, [](const std::string& w) { return w == "draft" || w == "final"; });
    const bool is_standard = std::ranges::find(options.presets, "standard") != options.presets.end();
    return word.empty() && is_standard ? "standard" : word;
}

std::string simulation_preset(const Options& options) {
    const std::string word =
        one_preset(options, [](const std::string& w) { return w == "preview" || w == "accurate"; });
    const bool is_standard = std::ranges::find(options.presets, "standard") != options.presets.end();
    return word.empty() && is_standard ? "standard" : word;
}

std::vector<std::string> overrides_of(const Options& options) {
    std::vector<std::string> overrides = options.assignments;
    if (const std::string preset = picture_preset(options); !preset.empty()) {
        overrides.push_back("output.preset=\"" + preset + "\"");
    }
    std::ranges::move(key_overrides(options), std::back_inserter(overrides));
    return overrides;
}

sim::SceneDef load_scene(const std::string& path, const Options& options, const std::vector<std::string>& found) {
    try {
        Options all = options;
        all.assignments.insert(all.assignments.end(), found.begin(), found.end());
        return load_with_preset(all, path);
    } catch (const Error& error) {
        throw Error(error.code(), as_typed(error.what(), options) + nearest_scene(path));
    }
}

void require_film(const sim::SceneDef& scene, bool has_video) {
    const sim::OutputDef& output = scene.output;
    render::require_memory(output.width, output.height);
    if (output.encoder != render::automatic_encoder) {
        const std::vector<std::string> names = render::encoder_names();
        if (std::ranges::find(names, output.encoder) == names.end()) {
            throw Error(ExitCode::usage,
                        fmt::format("{}: output.encoder '{}': expected auto or an encoder that this libavcodec has: {}{}",
                                    scene.name, output.encoder, fmt::join(names, ", "),
                                    sim::near_miss(output.encoder, names)));
        }
    }
    if (has_video) {
        render::require_encoder(render::video_settings(scene), output.width, output.height);
    }
}

bool is_piped(const Options& options) {
    if (options.out != "-") {
        if (!options.format.empty()) {
            throw Error(ExitCode::usage, "--format is of films to standard output: expected --out - with it");
        }
        return false;
    }
    if (options.format.empty()) {
        throw Error(ExitCode::usage, "--out - writes frames to standard output: expected --format y4m or rgb24 with it");
    }
    if (options.inputs.size() > 1 || options.accuracy > 0.0 || options.no_video || options.is_resumed || options.has_body_ids ||
        !options.passes.empty() || stills_of(options).is_needed() || is_elsewhere(options.placement)) {
        throw Error(ExitCode::usage, "--out - writes the frames of one film and nothing else: not with more scenes, "
                                     "--accuracy, --no-video, --resume, --body-ids, --passes, --poster, --sheet, --webp, "
                                     "--gif and --on slurm");
    }
    return true;
}

render::FilmSettings piped_film(const Options& options, std::int64_t first_frame) {
    return {.folder = {},
            .write_png = false,
            .write_video = false,
            .first_frame = first_frame,
            .raw = options.format == "y4m" ? render::RawFormat::y4m : render::RawFormat::rgb24};
}

ProgressStyle progress_style(const Options& options) {
    return options.is_quiet ? ProgressStyle::quiet
                            : options.progress == "json" ? ProgressStyle::json : ProgressStyle::text;
}

int thread_count(const Options& options) {
    return options.threads > 0 ? options.threads : sim::core_count();
}

} // namespace cmd
