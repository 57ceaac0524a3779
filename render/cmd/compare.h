#pragma once
/// tumble compare: two pictures, folders of frames, films or runs.
#include "render/compare/sequence.h"

#include <cstddef>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct CompareOptions {
    std::string reference;
    std::string candidate;
    std::string fail_on = "changed";
    std::vector<std::string> masks;
    std::vector<std::string> ignored_bodies;
    std::string report; ///< folder; empty: none
    std::string junit;  ///< file; empty: none
    std::string limits; ///< file that --calibrate has made; empty: defaults
    std::string history; ///< file that a line a case is appended to; empty: none
    std::size_t pictures = diff::default_pictures; ///< of a case, that a report keeps
    bool is_one_page = false; ///< the report's pictures are in its page
    int threads = 0;    ///< 0: one a core
    bool prints_json = false;
    bool calibrates = false;
    bool is_quiet = false;
};

void add_compare_options(CLI::App& verb, CompareOptions& options);

/// True if a film is to be read, or written for a report.
bool needs_films(const CompareOptions& options);

/// Compares, reports, and returns the exit code. films: null where needs_films() is false. command: the arguments,
/// for the report. Throws Error.
int compare(const CompareOptions& options, const std::string& command, const diff::FilmTools* films);

/// The pieces of compare() that other verbs share. Each throws Error.
diff::Settings compare_settings(const CompareOptions& options);
/// Makes the report's folder, and removes an earlier report from it.
void prepare_report(const std::string& folder);
/// Where the cause is another scene: which key, and both its values.
void name_scene_cause(const diff::Source& reference, const diff::Source& candidate, diff::Case& result);
diff::Comparison start_comparison(const CompareOptions& options, const std::string& command);
/// --pictures, --one-page and --history, which baselines have too.
struct ReportOptions {
    std::size_t& pictures;
    bool& is_one_page;
    std::string& history;
};
void add_report_options(CLI::App& verb, const ReportOptions& options);
/// Writes and prints what the options ask for; returns the exit code.
int finish_comparison(const CompareOptions& options, diff::Comparison& comparison);

} // namespace cmd
