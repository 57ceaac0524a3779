#pragma once
/// tumble compare: two pictures, folders of frames, films or runs.
#include "render/compare/source.h"

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
    std::string report; ///< folder; empty: none
    std::string junit;  ///< file; empty: none
    std::string limits; ///< file that --calibrate has made; empty: defaults
    int threads = 0;    ///< 0: one a core
    bool prints_json = false;
    bool calibrates = false;
    bool is_quiet = false;
};

void add_compare_options(CLI::App& verb, CompareOptions& options);

/// True if a film is to be read.
bool needs_films(const CompareOptions& options);

/// Compares, reports, and returns the exit code. films: null where needs_films() is false. command: the arguments,
/// for the report. Throws Error.
int compare(const CompareOptions& options, const std::string& command, const diff::FilmTools* films);

} // namespace cmd
