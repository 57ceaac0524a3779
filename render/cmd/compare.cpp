#include "render/cmd/compare.h"

#include "render/cmd/interrupt.h"
#include "render/cmd/usage.h"
#include "render/compare/cases.h"
#include "render/compare/history.h"
#include "render/compare/limits_file.h"
#include "render/compare/report.h"
#include "render/compare/side_by_side.h"
#include "sim/base/cores.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/base/workers.h"
#include "sim/scene/difference.h"

#include <CLI/CLI.hpp>
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <exception>
#include <functional>
#include <optional>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// The last part of a path that is no "frames" and no ".".
std::string case_name(const fs::path& path) {
    fs::path whole = fs::absolute(path).lexically_normal();
    while (whole.filename().empty() || whole.filename() == "frames") {
        if (whole == whole.root_path()) {
            return "pictures";
        }
        whole = whole.parent_path();
    }
    const std::string name = whole.stem().string();
    return sim::is_file_name(name) ? name : "pictures";
}

diff::Tier tier_of(const std::string& name) {
    for (const diff::Tier tier : {diff::Tier::identical, diff::Tier::noise, diff::Tier::changed}) {
        if (name == diff::name_of(tier)) {
            return tier;
        }
    }
    throw Error(ExitCode::usage, fmt::format("--fail-on '{}': expected identical, noise or changed", name));
}

} // namespace

diff::Settings compare_settings(const CompareOptions& options) {
    diff::Settings settings;
    settings.fail_on = tier_of(options.fail_on);
    settings.is_interrupted = is_interrupted;
    settings.threads = options.threads > 0 ? options.threads : sim::core_count();
    for (const std::string& mask : options.masks) {
        diff::add_to_mask(mask, settings.pair.accepted, settings.pair.mask);
    }
    settings.pair.ignored_bodies = options.ignored_bodies;
    if (options.calibrates) {
        constexpr double any_value = 1e9;
        for (diff::Limit& limit : settings.pair.limits.of) {
            limit = {any_value, "calibration"}; // all is measured
        }
    }
    if (!options.limits.empty() && !options.calibrates) {
        settings.pair.limits = diff::read_limits(options.limits);
    }
    return settings;
}

void prepare_report(const std::string& folder) {
    std::error_code error;
    for (const char* name : {"summary.json", "frames/run.json"}) {
        if (fs::exists(fs::path(folder) / name, error)) {
            throw Error(ExitCode::usage,
                        fmt::format("{} is the folder of a run; choose another for the report", folder));
        }
    }
    fs::create_directories(folder, error);
    if (error) {
        throw Error(ExitCode::io, "cannot make the folder " + folder + ": " + error.message());
    }
    diff::remove_report(folder);
}

void name_scene_cause(const diff::Source& reference, const diff::Source& candidate, diff::Case& result) {
    if (result.cause != diff::Cause::scene) {
        return;
    }
    try {
        const std::string difference = sim::scene_difference({candidate.scene_text, candidate.overrides},
                                                             {reference.scene_text, reference.overrides});
        const std::string start = result.tier == diff::Tier::identical ? "equal pixels, but " : "";
        result.cause_text = start + (difference.empty() ? "the scenes' texts differ, but no value of a key does"
                                                        : "the scene changed: " + difference);
    } catch (const Error&) {
        // No scenes of this program: the general sentence stays.
    }
}

diff::Comparison start_comparison(const CompareOptions& options, const std::string& command) {
    diff::Comparison comparison;
    comparison.program = "tumble " TUMBLE_VERSION;
    comparison.command = command;
    comparison.fail_on = tier_of(options.fail_on);
    return comparison;
}

int finish_comparison(const CompareOptions& options, diff::Comparison& comparison) {
    diff::sum_up(comparison);
    if (!options.history.empty()) {
        diff::append_history(options.history, comparison, fmt::format("{:%FT%TZ}", fmt::gmtime(std::time(nullptr))));
        diff::read_history(options.history, comparison);
    }
    if (!options.report.empty()) {
        diff::write_report(options.report, comparison,
                           options.is_one_page ? diff::PagePictures::inside : diff::PagePictures::linked);
    }
    if (!options.junit.empty()) {
        sim::write_file(options.junit, diff::to_junit(comparison));
    }
    if (options.prints_json) {
        std::fputs(diff::to_json(comparison).c_str(), stdout);
    } else if (!options.is_quiet) {
        std::fputs(diff::to_text(comparison).c_str(), stdout);
    }
    for (const diff::Case& result : comparison.cases) {
        if (options.is_quiet && result.status != diff::Status::compared) {
            std::fprintf(stderr, "tumble: %s: %s\n", result.name.c_str(), result.message.c_str());
        }
    }
    return comparison.exit_code;
}

void add_report_options(CLI::App& verb, const ReportOptions& options) {
    verb.add_option("--pictures", options.pictures, "Frames of a case whose pictures the report keeps, the worst ones (16)")
        ->type_name("N")
        ->check(whole_number(0, 1000000));
    verb.add_flag("--one-page", options.is_one_page, "Puts the report's pictures into its page, instead of files beside it");
    verb.add_option("--history", options.history,
                    "Appends a line of JSON a case to this file; the report shows the last runs and which cases are flaky")
        ->type_name("FILE");
}

void add_compare_options(CLI::App& verb, CompareOptions& options) {
    verb.add_option("REFERENCE", options.reference,
                    "A picture, a folder of frames, a run's folder, a film, or a folder of such")
        ->required()
        ->type_name("");
    verb.add_option("CANDIDATE", options.candidate, "What is compared with it, of the same kind")
        ->required()
        ->type_name("");
    verb.add_option("--fail-on", options.fail_on,
                    "Fails from this tier on: identical, noise or changed (default)")
        ->type_name("TIER");
    verb.add_option("--mask", options.masks,
                    "Leaves out X,Y,WIDTH,HEIGHT [px] or the bright pixels of a picture")
        ->type_name("RECT|FILE")
        ->allow_extra_args(false);
    verb.add_option("--ignore-body", options.ignored_bodies,
                    "Leaves out the pixels of a body, where both sides were made with --body-ids")
        ->type_name("NAME")
        ->allow_extra_args(false);
    verb.add_option("--report", options.report, "Folder for the report and its pictures")->type_name("DIR");
    verb.add_option("--junit", options.junit, "Writes JUnit's XML too")->type_name("FILE");
    add_report_options(verb, {options.pictures, options.is_one_page, options.history});
    verb.add_option("--limits", options.limits, "Limits of the gates, as --calibrate prints them")
        ->type_name("FILE");
    verb.add_option("--threads", options.threads, "Pairs at a time; the result does not depend on it")
        ->type_name("N")
        ->check(whole_number(1, 1024));
    verb.add_flag("--json", options.prints_json, "Prints the result as JSON");
    verb.add_flag("--calibrate", options.calibrates,
                  "Prints the limits under which these two, known to be good, differ by noise only");
    verb.add_flag("--quiet", options.is_quiet, "Only errors are printed");
}

bool needs_films(const CompareOptions& options) {
    const auto is_film_source = [&options](const fs::path& path) {
        const diff::SourceKind kind = diff::find_source(path).kind;
        return kind == diff::SourceKind::film || (kind == diff::SourceKind::frames && !options.report.empty());
    };
    try {
        const std::vector<diff::CasePaths> cases = diff::find_cases(options.reference, options.candidate);
        return std::any_of(cases.begin(), cases.end(), [&](const diff::CasePaths& paths) {
            return is_film_source(paths.reference) || is_film_source(paths.candidate);
        });
    } catch (const Error&) {
        return false; // said when it is compared
    }
}

namespace {

/// What all cases of one call share.
struct Comparing {
    const CompareOptions& options;
    diff::Settings settings;
    const diff::FilmTools* films;
};

/// Compares, and makes the film and pictures of the report.
diff::Case compare_case(const Comparing& comparing, const diff::CasePaths& paths) {
    const auto begin = std::chrono::steady_clock::now();
    const CompareOptions& options = comparing.options;
    const diff::Source reference = diff::find_source(paths.reference);
    const diff::Source candidate = diff::find_source(paths.candidate);
    const diff::Sides sides{reference, candidate};
    const std::string name = paths.name.empty() ? case_name(options.candidate) : paths.name;
    const bool are_sequences = reference.kind != diff::SourceKind::picture && candidate.kind != diff::SourceKind::picture;
    const bool has_report = !options.report.empty() && !options.calibrates;
    std::optional<diff::SideBySide> film;
    diff::SeePair see;
    if (has_report && comparing.films != nullptr && are_sequences) {
        film.emplace(sides, *comparing.films, options.report, name);
        see = [&film](std::size_t i, const diff::PairMemory& memory, const diff::Frame& frame) { film->add(i, memory, frame); };
    }
    diff::Case result = diff::compare_sources(name, sides, comparing.settings, comparing.films, see);
    name_scene_cause(reference, candidate, result);
    result.reference = paths.name.empty() ? options.reference : paths.reference.string();
    result.candidate = paths.name.empty() ? options.candidate : paths.candidate.string();
    if (film) {
        film->finish(result);
    }
    if (has_report) {
        diff::write_review(sides, comparing.settings, {options.report, options.pictures}, comparing.films, result);
    }
    result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return result;
}

/// Calls use(i) for all cases, several at a time; what it throws is kept in errors[i].
std::vector<std::exception_ptr> for_each_case(int threads, std::size_t count, const std::function<void(std::size_t)>& use) {
    std::vector<std::exception_ptr> errors(count);
    sim::Workers workers(std::min(threads, static_cast<int>(std::max<std::size_t>(count, 1))));
    std::atomic<std::size_t> next = 0;
    workers.run(static_cast<std::size_t>(threads), [&](std::size_t, std::size_t) {
        for (std::size_t i = next++; i < count; i = next++) {
            try {
                use(i);
            } catch (...) {
                errors[i] = std::current_exception();
            }
        }
    });
    return errors;
}

/// One case of many that could not be compared is told among them; a single one is the error. Throws Error.
void tell_error(const std::exception_ptr& thrown, const diff::CasePaths& paths, diff::Case& result) {
    try {
        std::rethrow_exception(thrown);
    } catch (const Error& error) {
        if (paths.name.empty() || error.code() == ExitCode::interrupted) {
            throw;
        }
        result = {};
        result.name = paths.name;
        result.reference = paths.reference.string();
        result.candidate = paths.candidate.string();
        result.status = diff::Status::unreadable;
        result.tier = diff::Tier::changed;
        result.is_failed = true;
        result.message = error.what();
        result.error_code = static_cast<int>(error.code());
    }
}

} // namespace

int compare(const CompareOptions& options, const std::string& command, const diff::FilmTools* films) {
    Comparing comparing{options, compare_settings(options), films};
    const std::vector<diff::CasePaths> paths = diff::find_cases(options.reference, options.candidate);
    const int threads = comparing.settings.threads;
    comparing.settings.threads = paths.size() > 1 ? 1 : threads; // a core a case, or a pair
    diff::Comparison comparison = start_comparison(options, command);
    comparison.cases.resize(paths.size());
    if (!options.report.empty() && !options.calibrates) {
        prepare_report(options.report);
    }
    const std::vector<std::exception_ptr> errors = for_each_case(
        threads, paths.size(), [&](std::size_t i) { comparison.cases[i] = compare_case(comparing, paths[i]); });
    for (std::size_t i = 0; i < errors.size(); ++i) {
        if (errors[i] != nullptr) {
            tell_error(errors[i], paths[i], comparison.cases[i]);
        }
    }
    if (options.calibrates) {
        const diff::Limits least = options.limits.empty() ? diff::Limits() : diff::read_limits(options.limits);
        std::fputs(diff::proposed_limits(comparison, least).c_str(), stdout);
        return static_cast<int>(ExitCode::good);
    }
    return finish_comparison(options, comparison);
}

} // namespace cmd
