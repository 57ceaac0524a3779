#pragma once
/// tumble baseline: accepted pictures of scenes, kept in a folder, and what the program draws now.
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct BaselineOptions {
    std::vector<std::string> scenes;      ///< files
    std::string folder = "baselines";     ///< of all baselines
    std::string report = "out/baselines"; ///< of check
    std::string fail_on = "changed";
    std::string junit;  ///< file; empty: none
    std::string limits; ///< file; empty: defaults
    bool prints_json = false;
    std::string gl; ///< what draws; empty: what the scene says
    bool is_quiet = false;
    // Of update; empty: as the baseline was made, or the defaults for a new one.
    std::string size;                     ///< "WxH" [px]; default 320x180
    std::vector<std::string> assignments; ///< "dotted.key=value"
    std::string frames;                   ///< "0,5,10"; default 0
    bool has_body_ids = false;
    bool is_for_this_renderer = false;    ///< kept beside the common one
};

/// Adds the verbs `check` and `update` to `baseline`. code: set by check. command: for the report.
void add_baseline_verbs(CLI::App& baseline, BaselineOptions& options, const std::string& command, int& code);

} // namespace cmd
