#pragma once
/// tumble side-by-side: several films in one, in step.
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct SideBySideOptions {
    std::vector<std::string> inputs; ///< films, or folders of runs
    std::vector<std::string> labels; ///< one each; empty: their names
    std::string film;                ///< what is written
    bool is_quiet = false;
};

/// Adds the verb's options. `options` must outlive the parsing.
void add_side_by_side_options(CLI::App& verb, SideBySideOptions& options);

/// Throws Error.
void write_films_side_by_side(const SideBySideOptions& options);

} // namespace cmd
