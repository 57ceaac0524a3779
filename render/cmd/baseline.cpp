/// A baseline is the folder BASELINES/SCENE/common or BASELINES/SCENE/RENDERER: pictures and baseline.json,
/// which says how they were made.
#include "render/cmd/baseline.h"

#include "render/cmd/compare.h"
#include "render/cmd/interrupt.h"
#include "render/cmd/options.h"
#include "render/compare/sequence.h"
#include "render/film/film.h"
#include "render/film/memory.h"
#include "render/gl/context.h"
#include "render/gl/shader.h"
#include "render/picture/body_image.h"
#include "render/picture/renderer.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <optional>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

constexpr const char* record_name = "baseline.json";
constexpr const char* common_name = "common";
constexpr const char* default_size = "320x180";

/// How the pictures of a baseline are made, and what made them.
struct Record {
    diff::Origin origin;
    std::string scene_text;             ///< the scene file as read
    std::vector<std::string> overrides; ///< "dotted.key=value"
    std::vector<std::int64_t> frames{0};
    bool has_body_ids = false;
};

/// None if the folder has none. Throws Error (io) if it is damaged.
std::optional<Record> read_record(const fs::path& folder) {
    const fs::path path = folder / record_name;
    std::error_code error;
    if (!fs::exists(path, error)) {
        return std::nullopt;
    }
    const std::string text = sim::read_text_file(path);
    try {
        const nlohmann::json json = nlohmann::json::parse(text);
        Record record;
        record.origin = {json.at("program"), json.at("scene_name"), json.at("state_hash"),
                         json.at("shaders_hash"), json.at("renderer")};
        json.at("scene_text").get_to(record.scene_text);
        json.at("overrides").get_to(record.overrides);
        json.at("frames").get_to(record.frames);
        json.at("has_body_ids").get_to(record.has_body_ids);
        return record;
    } catch (const nlohmann::json::exception&) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: it is damaged", path.string()));
    }
}

void write_record(const fs::path& folder, const Record& record) {
    const nlohmann::ordered_json json = {
        {"program", record.origin.program},       {"scene_name", record.origin.scene},
        {"state_hash", record.origin.state_hash}, {"shaders_hash", record.origin.shaders_hash},
        {"renderer", record.origin.renderer},     {"frames", record.frames},
        {"has_body_ids", record.has_body_ids},    {"overrides", record.overrides},
        {"scene_text", record.scene_text}};
    sim::write_file(folder / record_name,
                    json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

/// The renderer string as a folder's name.
std::string folder_name(std::string renderer) {
    for (char& c : renderer) {
        const bool is_kept =
            (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.';
        c = is_kept ? c : '_';
    }
    return renderer;
}

/// The baseline that this machine is held against.
fs::path find_baseline(const fs::path& folder, const std::string& scene, const std::string& renderer) {
    const fs::path own = folder / scene / folder_name(renderer);
    std::error_code error;
    return fs::exists(own / record_name, error) ? own : folder / scene / common_name;
}

/// "0,5,10": ascending. Throws Error (usage).
std::vector<std::int64_t> parse_frames(const std::string& text) {
    std::vector<std::int64_t> frames;
    const char* at = text.data();
    const char* end = at + text.size();
    while (true) {
        std::int64_t frame = 0;
        const auto [next, error] = std::from_chars(at, end, frame);
        if (error != std::errc() || frame < 0 || (!frames.empty() && frame <= frames.back()) ||
            (next != end && *next != ',')) {
            throw Error(ExitCode::usage,
                        fmt::format("--frames '{}': expected ascending numbers such as 0,5,10", text));
        }
        frames.push_back(frame);
        if (next == end) {
            return frames;
        }
        at = next + 1;
    }
}

void make_empty_folder(const fs::path& folder) {
    std::error_code error;
    fs::remove_all(folder, error);
    if (!error) {
        fs::create_directories(folder, error);
    }
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
    }
}

/// Simulates to the last of the frames, draws them into the folder, and enters in the record what made them.
void draw(const sim::SceneDef& scene, const fs::path& folder, Record& record) {
    render::require_memory(scene.output.width, scene.output.height);
    make_empty_folder(folder);
    record.scene_text = scene.text;
    sim::World world(scene, 1);
    render::Renderer renderer(scene, scene.output.width, scene.output.height,
                              render::render_settings(scene.output));
    record.origin = {"tumble " TUMBLE_VERSION, scene.name, "", render::shaders_hash(),
                     renderer.renderer_string()};
    for (const std::int64_t frame : record.frames) {
        const std::int64_t step = sim::step_of_frame(frame, scene.output.fps, scene.step.time_step);
        while (world.step_index() < step) {
            if (is_interrupted()) {
                throw Error(ExitCode::interrupted, "interrupted; no baseline was changed");
            }
            world.step();
        }
        const sim::Snapshot snapshot = world.take_snapshot();
        const std::string name = fs::path(render::frame_file_name(frame)).filename().string();
        sim::write_file(folder / name, render::encode_png(renderer.draw(snapshot)));
        if (record.has_body_ids) {
            render::write_body_image(folder, name, scene, snapshot, renderer.body_ids());
        }
        record.origin.state_hash = fmt::format("{:016x}", sim::state_hash(snapshot));
    }
}

/// The scene of a baseline, to be drawn by what the user asks for.
sim::SceneDef load_drawn(const std::string& file, const std::vector<std::string>& overrides, const std::string& gl) {
    sim::SceneDef scene = sim::load_scene(file, overrides);
    scene.output.gl = gl.empty() ? scene.output.gl : gl;
    return scene;
}

/// The folder as one side of a comparison.
diff::Source source_of(const fs::path& folder, const Record& record) {
    diff::Source source = diff::find_source(folder);
    source.origin = record.origin;
    source.scene_text = record.scene_text + fmt::format("\n{}", fmt::join(record.overrides, "\n"));
    return source;
}

/// Draws one scene as its baseline was drawn, and compares.
diff::Case check_scene(const std::string& file, const BaselineOptions& options, const CompareOptions& comparing) {
    const sim::SceneDef scene = load_drawn(file, {}, options.gl);
    const std::string& name = scene.name;
    const fs::path folder = find_baseline(options.folder, name, render::renderer_string(scene.output.gl));
    const std::optional<Record> reference = read_record(folder);
    Record candidate = reference.value_or(Record{});
    if (!reference) {
        Options size;
        size.size = default_size;
        candidate.overrides = overrides_of(size);
    }
    const fs::path drawn = fs::path(options.report) / "candidates" / name;
    draw(load_drawn(file, candidate.overrides, options.gl), drawn, candidate);

    diff::Source before;
    before.path = folder;
    if (reference) {
        before = source_of(folder, *reference);
    }
    const diff::Source now = source_of(drawn, candidate);
    const diff::Settings settings = compare_settings(comparing);
    diff::Case result = diff::compare_sources(name, before, now, settings, nullptr);
    if (!reference) {
        result.message = fmt::format("no baseline {}: look at {}, then tumble baseline update {}",
                                     folder.string(), drawn.string(), file);
    }
    result.reference = folder.string();
    result.candidate = file;
    diff::write_review(before, now, settings, {.folder = options.report}, nullptr, result);
    return result;
}

int check(const BaselineOptions& options, const std::string& command) {
    CompareOptions comparing;
    comparing.fail_on = options.fail_on;
    comparing.report = options.report;
    comparing.junit = options.junit;
    comparing.limits = options.limits;
    comparing.prints_json = options.prints_json;
    comparing.is_quiet = options.is_quiet;
    prepare_report(options.report);
    diff::Comparison comparison = start_comparison(comparing, command);
    for (const std::string& scene : options.scenes) {
        comparison.cases.push_back(check_scene(scene, options, comparing));
    }
    return finish_comparison(comparing, comparison);
}

void update(const BaselineOptions& options) {
    for (const std::string& file : options.scenes) {
        const sim::SceneDef scene = load_drawn(file, {}, options.gl);
        const std::string& name = scene.name;
        const std::string renderer = render::renderer_string(scene.output.gl);
        const fs::path folder = options.is_for_this_renderer
                                    ? fs::path(options.folder) / name / folder_name(renderer)
                                    : find_baseline(options.folder, name, renderer);
        Record record = read_record(folder).value_or(Record{});
        if (record.overrides.empty() || !options.size.empty() || !options.assignments.empty()) {
            Options changes;
            changes.size = options.size.empty() ? default_size : options.size;
            changes.assignments = options.assignments;
            record.overrides = overrides_of(changes);
            load_scene(file, changes); // what is wrong with --size is told by its name
        }
        if (!options.frames.empty()) {
            record.frames = parse_frames(options.frames);
        }
        record.has_body_ids = record.has_body_ids || options.has_body_ids;

        const fs::path fresh = folder.string() + ".part";
        try {
            draw(load_drawn(file, record.overrides, options.gl), fresh, record);
            write_record(fresh, record);
            fs::remove_all(folder);
            fs::rename(fresh, folder);
        } catch (const fs::filesystem_error& error) {
            throw Error(ExitCode::io,
                        fmt::format("cannot replace {}: {}", folder.string(), error.code().message()));
        } catch (...) {
            std::error_code ignored; // the first error is told
            fs::remove_all(fresh, ignored);
            throw;
        }
        if (!options.is_quiet) {
            std::printf("%s: %zu pictures in %s\n", name.c_str(), record.frames.size(), folder.c_str());
        }
    }
}

} // namespace

void add_baseline_verbs(CLI::App& baseline, BaselineOptions& options, const std::string& command, int& code) {
    baseline.require_subcommand(1);
    const auto add = [&](const char* name, const char* description) {
        CLI::App* verb = baseline.add_subcommand(name, description);
        verb->add_option("SCENE", options.scenes, "Scene files (TOML)")->required()->type_name("");
        verb->add_option("--baselines", options.folder, "Folder of the baselines (default: baselines)")
            ->type_name("DIR");
        add_gl_option(*verb, options.gl);
        verb->add_flag("--quiet", options.is_quiet, "Only errors are printed");
        return verb;
    };
    CLI::App* check_verb = add("check", "Draw what the baselines show, and compare; changes no baseline");
    check_verb->add_option("--report", options.report, "Folder for the report (default: out/baselines)")
        ->type_name("DIR");
    check_verb->add_option("--fail-on", options.fail_on, "identical, noise or changed (default)")
        ->type_name("TIER");
    check_verb->add_option("--junit", options.junit, "Writes JUnit's XML too")->type_name("FILE");
    check_verb
        ->add_option("--limits", options.limits,
                     "Limits of the gates, as tumble compare --calibrate prints them")
        ->type_name("FILE");
    check_verb->add_flag("--json", options.prints_json, "Prints the result as JSON");
    check_verb->final_callback([&options, &command, &code] { code = check(options, command); });

    CLI::App* update_verb = add("update", "Accept what is drawn now as the baselines of these scenes");
    update_verb->add_option("--size", options.size, "Size of the pictures [px] (new baselines: 320x180)")
        ->type_name("WxH");
    update_verb->add_option("--set", options.assignments, "Sets a key of the scene for its baseline")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    update_verb
        ->add_option("--frames", options.frames, "Frames that are kept, such as 0,5,10 (new baselines: 0)")
        ->type_name("LIST");
    update_verb->add_flag("--body-ids", options.has_body_ids,
                          "Keeps which body each pixel shows: reports name bodies");
    update_verb->add_flag("--for-this-renderer", options.is_for_this_renderer,
                          "Beside the common baseline, for machines with this OpenGL only");
    update_verb->final_callback([&options] { update(options); });
}

} // namespace cmd
