#pragma once
/// tumble baseline: accepted pictures of scenes, kept in a folder, and what the program draws now.
#include "render/cmd/baseline_record.h"
#include "render/cmd/slurm.h"

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct BaselineOptions {
    std::vector<std::string> scenes;  ///< files; of check: empty for all that have baselines
    std::string folder = "baselines"; ///< of all baselines
    std::string name;                 ///< of a scene's baseline; empty: all of check, "common" of a new one
    std::string report;               ///< of check; empty: out/baselines, or the next that no other check uses
    std::string fail_on = "changed";
    std::string junit;  ///< file; empty: none
    std::string limits; ///< file; empty: the baselines' own
    std::string history; ///< file; empty: none
    std::size_t pictures = 16; ///< of a case, that a report keeps
    bool is_one_page = false;  ///< the report's pictures are in its page
    int jobs = 0;       ///< baselines at a time; 0: one for two cores
    Placement placement; ///< of check's drawing
    std::string part;    ///< of check: "K/N", draws every N-th, from K on, and compares nothing; empty: all
    bool prints_json = false;
    std::string gl; ///< what draws; empty: what the scene says
    bool is_quiet = false;
    BaselineChanges changes;           ///< of update
    bool is_for_this_renderer = false; ///< of update: kept beside the one for all machines
    std::vector<std::string> cases;    ///< of accept; empty: all that the report has drawn
};

/// Adds the verbs to `baseline`. code: set by check. command: for the report.
void add_baseline_verbs(CLI::App& baseline, BaselineOptions& options, const std::string& command, int& code);

/// The verbs; each throws Error.
int check_baselines(const BaselineOptions& options, const std::string& command);
void update_baselines(const BaselineOptions& options);
/// Makes the pictures that a report shows the baselines.
void accept_baselines(const BaselineOptions& options);
/// The command line that does so for a report of check, but its cases.
std::string accept_command(const BaselineOptions& options, const std::string& report);

} // namespace cmd
