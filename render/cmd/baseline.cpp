#include "render/cmd/baseline.h"

#include "render/cmd/baseline_draw.h"
#include "render/cmd/baseline_elsewhere.h"
#include "render/cmd/baseline_place.h"
#include "render/cmd/compare.h"
#include "render/cmd/options.h"
#include "render/cmd/workplace.h"
#include "render/compare/sequence.h"
#include "render/gl/context.h"
#include "sim/base/cores.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"
#include "sim/scene/tree.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

constexpr const char* default_report = "out/baselines";
constexpr const char* default_size = "640x360"; ///< the least at which the text over a picture is read

JobPlan job_plan(const BaselineOptions& options, std::size_t count) {
    const int most = static_cast<int>(std::max<std::size_t>(count, 1));
    const int wanted = options.jobs > 0 ? options.jobs : sim::core_count();
    return {count, std::min(wanted, most), "baselines", options.is_quiet || options.prints_json};
}

int threads_of(const JobPlan& plan) {
    return std::max(1, sim::core_count() / plan.at_once);
}

/// The folder as one side of a comparison.
diff::Source source_of(const fs::path& folder, const BaselineRecord& record) {
    diff::Source source = diff::find_source(folder);
    std::erase_if(source.names, [&](const std::string& name) { return !is_frame_name(name); }); // somebody else's
    source.origin = record.origin;
    source.scene_text = record.scene_text;
    source.overrides = record.overrides;
    return source;
}

/// What the record leaves out; masks that are pictures lie in `folder`.
void add_masks(const BaselineRecord& record, const fs::path& folder, diff::PairSettings& settings) {
    settings.ignored_bodies = record.ignored_bodies;
    for (const std::string& mask : record.masks) {
        const fs::path file = folder / mask;
        diff::add_to_mask(fs::exists(file) ? file.string() : mask, settings.accepted, settings.mask);
    }
}

/// Throws Error if masks or bodies to be ignored fit no picture, or leave nothing of one.
void check_masks(const BaselineRecord& record, const fs::path& folder) {
    if (record.masks.empty() && record.ignored_bodies.empty()) {
        return;
    }
    const diff::Source drawn = source_of(folder, record);
    diff::Settings settings;
    add_masks(record, folder, settings.pair);
    diff::compare_sources("", {drawn, drawn}, settings, nullptr, {});
}

/// The scene of a baseline, to be drawn by what the user asks for.
sim::SceneDef load_drawn(const fs::path& file, const std::vector<std::string>& overrides, const std::string& gl) {
    sim::SceneDef scene = sim::load_scene(file, overrides);
    scene.output.gl = gl.empty() ? scene.output.gl : gl;
    return scene;
}

/// By how many levels pictures may differ that one program's sampler has drawn: none where machine, state and shaders
/// are the same; else one, by which versions of Mesa differ. Processors without fused multiply-add round otherwise.
double level_between(const diff::Origin& a, const diff::Origin& b) {
    if (a.processor != b.processor) {
        return diff::not_asked;
    }
    return a.renderer == b.renderer && a.state_hash == b.state_hash && a.shaders_hash == b.shaders_hash ? 0.0 : 1.0;
}

/// The folder of the report, which no other check uses as long as the lock lives.
class ReportPlace {
public:
    explicit ReportPlace(const std::string& asked) {
        constexpr int most_checks = 100;
        for (int i = 1;; ++i) {
            folder_ = !asked.empty() ? asked : i == 1 ? default_report : fmt::format("{}_{}", default_report, i);
            prepare_folder(folder_);
            try {
                lock_.emplace(folder_, FolderLock::Kind::alone, false);
                return;
            } catch (const Error&) {
                if (!asked.empty() || i == most_checks) {
                    throw;
                }
            }
        }
    }
    const std::string& folder() const { return folder_; }

private:
    static void prepare_folder(const std::string& folder) {
        std::error_code error;
        fs::create_directories(folder, error);
        if (error) {
            throw Error(ExitCode::io, "cannot make the folder " + folder + ": " + error.message());
        }
    }

    std::string folder_;
    std::optional<FolderLock> lock_;
};

/// To be called before the program's first thread.
void prepare_gl(const BaselineOptions& options) {
    render::configure_gl(false);
    if (!options.gl.empty()) {
        render::renderer_string(options.gl); // refused before anything is made
    }
}

class Check {
public:
    Check(const BaselineOptions& options, CompareOptions comparing, int threads)
        : options_(options), comparing_(std::move(comparing)), threads_(threads) {}

    /// Draws one scene as its baseline was drawn.
    void draw(BaselinePlace place, JobProgress& progress) const {
        const fs::path file = place.scene_file;
        if (file.empty()) {
            throw Error(ExitCode::usage,
                        fmt::format("{} does not say where its scene is: name the scene's file, or make it anew with "
                                    "tumble baseline update SCENE.toml",
                                    place.folder.string()));
        }
        place.folder = machine_folder(options_.folder, place, load_drawn(file, {}, options_.gl).output.gl);
        BaselineRecord now;
        if (const std::optional<BaselineRecord> reference = read_baseline_record(place.folder)) {
            now = *reference;
        } else {
            change_record({.size = default_size}, now);
        }
        const fs::path drawn = drawn_folder(comparing_.report, place);
        draw_baseline(load_drawn(file, now.overrides, options_.gl), drawn, threads_, now, progress);
        copy_masks(place.folder, drawn / "frames", now);
        write_baseline_record(drawn / "frames", now);
    }

    /// What was drawn beside its baseline.
    diff::Case compare(BaselinePlace place) const {
        const fs::path file = place.scene_file;
        place.folder = machine_folder(options_.folder, place, load_drawn(file, {}, options_.gl).output.gl);
        const fs::path drawn = drawn_folder(comparing_.report, place);
        const std::optional<BaselineRecord> reference = read_baseline_record(place.folder);
        const BaselineRecord now = read_baseline_record(drawn / "frames").value_or(BaselineRecord{});

        diff::Source before;
        before.path = place.folder;
        if (reference) {
            before = source_of(place.folder, *reference);
        }
        const diff::Source after = source_of(drawn / "frames", now);
        const diff::Settings settings = settings_of(place, reference, now);
        diff::Case result = diff::compare_sources(place.case_name(), {before, after}, settings, nullptr, {});
        name_scene_cause(before, after, result);
        if (!reference) {
            result.message =
                fmt::format("no baseline {}: look at {}, then tumble baseline accept {}", place.folder.string(),
                            (drawn / "frames").string(), comparing_.report);
        }
        result.reference = place.folder.string();
        result.candidate = file.string();
        diff::write_review({before, after}, settings, {comparing_.report, comparing_.pictures}, nullptr, result);
        return result;
    }

    /// Masks that are pictures lie in the baseline's folder: `from`, or as the user named them.
    static void copy_masks(const fs::path& from, const fs::path& to, BaselineRecord& record) {
        for (std::size_t i = 0; i < record.masks.size(); ++i) {
            std::string& mask = record.masks[i];
            const std::string path = fs::exists(from / mask) ? (from / mask).string() : mask;
            diff::Mask read;
            diff::add_to_mask(path, {}, read);
            if (!read.pictures.empty()) {
                mask = fmt::format("masks/{}{}", i, fs::path(path).extension().string());
                const std::string bytes = sim::read_text_file(path);
                fs::create_directories(to / "masks");
                sim::write_file(to / mask, bytes);
            }
        }
    }

private:
    diff::Settings settings_of(const BaselinePlace& place, const std::optional<BaselineRecord>& before,
                               const BaselineRecord& now) const {
        diff::Settings settings = compare_settings(comparing_);
        settings.threads = 1;
        add_masks(now, drawn_folder(comparing_.report, place) / "frames", settings.pair);
        if (before && options_.limits.empty()) {
            settings.pair.limits = limits_of(*before, level_between(before->origin, now.origin), place.folder);
        }
        return settings;
    }

    const BaselineOptions& options_;
    CompareOptions comparing_;
    int threads_;
};

/// A case that could not be compared at all.
diff::Case failed_case(const BaselinePlace& place, const Error& error) {
    diff::Case result;
    result.name = place.case_name();
    result.reference = place.folder.string();
    result.candidate = place.scene_file.string();
    result.is_sequence = true;
    result.status = diff::Status::unreadable;
    result.tier = diff::Tier::changed;
    result.is_failed = true;
    result.message = error.what();
    result.error_code = static_cast<int>(error.code());
    return result;
}

/// A cluster's task. What goes wrong with a scene is the caller's to tell. Throws Error.
void draw_part(const BaselineOptions& options, const std::vector<BaselinePlace>& places) {
    const std::optional<Share> share = parse_share(options.part);
    if (!share) {
        throw Error(ExitCode::usage, fmt::format("--part '{}': expected K/N with 0 <= K < N", options.part));
    }
    CompareOptions comparing;
    comparing.report = options.report.empty() ? default_report : options.report;
    const Check check(options, comparing, std::max(1, options.jobs)); // its cores are its own
    JobProgress progress;
    for (std::size_t i = share->first; i < places.size(); i += share->count) {
        const fs::path drawn = drawn_folder(comparing.report, places[i]);
        begin_drawing(drawn);
        try {
            check.draw(places[i], progress);
        } catch (const Error& error) {
            if (error.code() == ExitCode::interrupted) {
                throw;
            }
            keep_failure(drawn, error);
        }
    }
}

/// What update is to make.
struct Target {
    BaselinePlace place;
    BaselineRecord before;
    BaselineRecord now;
    bool is_new = true;
};

Target target_of(const BaselineOptions& options, const BaselinePlace& place) {
    Target target{place, {}, {}, true};
    const std::string gl = load_drawn(place.scene_file, {}, options.gl).output.gl;
    target.place.folder = options.is_for_this_renderer ? renderer_folder(options.folder, place, gl)
                                                       : machine_folder(options.folder, place, gl);
    for (const fs::path& folder : {target.place.folder, place.folder}) {
        if (const std::optional<BaselineRecord> found = read_baseline_record(folder)) {
            target.before = target.now = *found;
            target.is_new = false;
            break;
        }
    }
    if (target.is_new) {
        change_record({.size = default_size}, target.now);
    }
    change_record(options.changes, target.now);
    std::error_code error;
    target.now.scene_file =
        fs::relative(fs::absolute(place.scene_file), fs::absolute(options.folder), error).generic_string();
    Options typed; // what is wrong with --size is told by its name
    typed.size = options.changes.size;
    typed.assignments = target.now.overrides;
    load_scene(place.scene_file.string(), typed);
    return target;
}

std::string made_text(const Target& target) {
    const auto count = std::count_if(
        target.now.pictures.begin(), target.now.pictures.end(),
        [](const auto& file) { return file.first.find(".bodies.") == std::string::npos; });
    std::string text =
        fmt::format("{}: {} picture{} in {}\n", target.place.case_name(), count, count == 1 ? "" : "s", target.place.folder.string());
    if (!target.is_new) {
        for (const std::string& line : record_changes(target.before, target.now)) {
            text += "  " + line + "\n";
        }
    }
    return text;
}

void make_baseline(Target& target, const std::string& gl, int threads, JobProgress& progress) {
    const fs::path& folder = target.place.folder;
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    const FolderLock lock(folder.parent_path(), FolderLock::Kind::alone, true);
    const fs::path fresh = folder.string() + ".part";
    try {
        draw_baseline(load_drawn(target.place.scene_file, target.now.overrides, gl), fresh, threads, target.now,
                      progress);
        Check::copy_masks(folder, fresh / "frames", target.now);
        check_masks(target.now, fresh / "frames");
        write_baseline_record(fresh / "frames", target.now);
        replace_folder(fresh / "frames", folder);
        remove_fresh(fresh);
    } catch (...) {
        remove_fresh(fresh); // the first error is told
        fs::remove(folder.parent_path(), error); // if nothing is in it
        throw;
    }
}

} // namespace

int check_baselines(const BaselineOptions& options, const std::string& command) {
    prepare_gl(options);
    std::vector<BaselinePlace> places;
    for (const std::string& scene : options.scenes) {
        const std::vector<BaselinePlace> found = places_of(options.folder, scene, options.name);
        places.insert(places.end(), found.begin(), found.end());
    }
    if (options.scenes.empty()) {
        places = all_places(options.folder, options.name);
    }
    if (!options.part.empty()) {
        draw_part(options, places);
        return 0;
    }
    const ReportPlace report(options.report);
    CompareOptions comparing;
    comparing.fail_on = options.fail_on;
    comparing.report = report.folder();
    comparing.junit = options.junit;
    comparing.limits = options.limits;
    comparing.history = options.history;
    comparing.pictures = options.pictures;
    comparing.is_one_page = options.is_one_page;
    comparing.prints_json = options.prints_json;
    comparing.is_quiet = options.is_quiet;
    diff::Comparison comparison = start_comparison(comparing, command);
    comparison.accept = accept_command(options, report.folder());
    compare_settings(comparing); // refused before anything is drawn
    const bool is_drawn_elsewhere = is_elsewhere(options.placement);
    if (is_drawn_elsewhere && !draw_elsewhere(options, report.folder(), places)) {
        return 0;
    }
    prepare_report(comparing.report);
    const JobPlan plan = job_plan(options, places.size());
    const Check check(options, comparing, threads_of(plan));
    comparison.cases.resize(places.size());
    run_jobs(plan, [&](std::size_t i, JobProgress& progress) {
        const auto begin = std::chrono::steady_clock::now();
        try {
            if (is_drawn_elsewhere) {
                throw_failure(drawn_folder(comparing.report, places[i]));
            } else {
                check.draw(places[i], progress);
            }
            comparison.cases[i] = check.compare(places[i]);
        } catch (const Error& error) {
            if (error.code() == ExitCode::interrupted) {
                throw;
            }
            comparison.cases[i] = failed_case(places[i], error);
        }
        comparison.cases[i].seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    });
    const int code = finish_comparison(comparing, comparison);
    if (!options.is_quiet && !options.prints_json && code != 0) {
        std::printf("report: %s/index.html; what is meant: tumble baseline accept %s\n", report.folder().c_str(),
                    report.folder().c_str());
    }
    return code;
}

void update_baselines(const BaselineOptions& options) {
    prepare_gl(options);
    std::vector<Target> targets;
    for (const std::string& scene : options.scenes) {
        for (const BaselinePlace& place : places_of(options.folder, scene, options.name)) {
            targets.push_back(target_of(options, place));
        }
    }
    const JobPlan plan = job_plan(options, targets.size());
    std::mutex printing;
    run_jobs(plan, [&](std::size_t i, JobProgress& progress) {
        make_baseline(targets[i], options.gl, threads_of(plan), progress);
        if (!options.is_quiet) {
            const std::lock_guard<std::mutex> lock(printing);
            std::fputs(made_text(targets[i]).c_str(), stdout);
        }
    });
}

} // namespace cmd
