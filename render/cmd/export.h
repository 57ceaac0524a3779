#pragma once
/// tumble export: a run for other programs.
#include <string>

namespace CLI {
class App;
}

namespace cmd {

struct ExportOptions {
    std::string run;  ///< folder of a run, or its trajectory
    std::string gltf; ///< file; empty: none
    std::string csv;  ///< file, "-": standard output; empty: none
    bool is_quiet = false;
};

/// Adds the verb's options. `options` must outlive the parsing.
void add_export_options(CLI::App& verb, ExportOptions& options);

/// Throws Error.
void export_run(const ExportOptions& options);

} // namespace cmd
