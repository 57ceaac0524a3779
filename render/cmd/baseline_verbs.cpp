/// The options of `tumble baseline`.
#include "render/cmd/baseline.h"
#include "render/cmd/compare.h"
#include "render/cmd/options.h"
#include "render/cmd/usage.h"

#include <CLI/CLI.hpp>

namespace cmd {

namespace {

CLI::App* add_verb(CLI::App& baseline, BaselineOptions& options, const char* name, const char* description) {
    CLI::App* verb = baseline.add_subcommand(name, description);
    verb->add_option("--baselines", options.folder, "Folder of the baselines (default: baselines)")
        ->type_name("DIR");
    verb->add_flag("--quiet", options.is_quiet, "Only errors are printed");
    return verb;
}

void add_drawing_options(CLI::App& verb, BaselineOptions& options) {
    verb.add_option("--name", options.name, "Of several baselines of a scene the one with this name")
        ->type_name("NAME");
    add_gl_option(verb, options.gl);
    verb.add_option("--jobs", options.jobs, "Baselines at a time, else one a core")
        ->type_name("N")
        ->check(whole_number(1, 1024));
}

void add_check(CLI::App& baseline, BaselineOptions& options, const std::string& command, int& code) {
    CLI::App* verb =
        add_verb(baseline, options, "check", "Draw what the baselines show, and compare; changes no baseline");
    verb->add_option("SCENE", options.scenes, "Scene files (TOML); all that have baselines if not given")
        ->type_name("");
    add_drawing_options(*verb, options);
    verb->add_option("--report", options.report, "Folder for the report (default: out/baselines)")
        ->type_name("DIR");
    verb->add_option("--fail-on", options.fail_on, "identical, noise or changed (default)")->type_name("TIER");
    verb->add_option("--junit", options.junit, "Writes JUnit's XML too")->type_name("FILE");
    add_report_options(*verb, {options.pictures, options.is_one_page, options.history});
    verb->add_option("--limits", options.limits, "Limits of the gates, instead of the baselines' own")
        ->type_name("FILE");
    verb->add_flag("--json", options.prints_json, "Prints the result as JSON");
    add_placement_options(*verb, options.placement);
    verb->add_option("--part", options.part, "A cluster's task: K/N, draws every N-th from K on, and compares nothing")
        ->type_name("PART");
    verb->final_callback([&options, &command, &code] { code = check_baselines(options, command); });
}

void add_update(CLI::App& baseline, BaselineOptions& options) {
    CLI::App* verb = add_verb(baseline, options, "update", "Accept what is drawn now as the baselines of these scenes");
    verb->add_option("SCENE", options.scenes, "Scene files (TOML)")->required()->type_name("");
    add_drawing_options(*verb, options);
    BaselineChanges& changes = options.changes;
    verb->add_option("--size", changes.size, "Size of the pictures [px] (new baselines: 640x360)")->type_name("WxH");
    verb->add_option("--set", changes.assignments, "Sets a key of the scene for its baseline")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    verb->add_option("--unset", changes.unset,
                     "Takes a key back that the baseline sets, or its mask, limits or ignore-body")
        ->type_name("KEY")
        ->allow_extra_args(false);
    verb->add_option("--frames", changes.frames,
                     "Frames that are kept, such as 0,5,10; default: start, quarters and end of the film")
        ->type_name("LIST");
    verb->add_flag_callback(
        "--body-ids", [&changes] { changes.has_body_ids = true; },
        "Keeps which body each pixel shows (new baselines do): reports name bodies");
    verb->add_flag_callback(
        "--no-body-ids", [&changes] { changes.has_body_ids = false; }, "Does not keep them");
    verb->add_option("--mask", changes.masks, "Adds a mask, as of tumble compare, to the baseline")
        ->type_name("RECT|FILE")
        ->allow_extra_args(false);
    verb->add_option("--ignore-body", changes.ignored_bodies, "Leaves out the pixels of a body")
        ->type_name("NAME")
        ->allow_extra_args(false);
    verb->add_option("--limits", changes.limits, "Keeps these limits of the gates with the baseline")
        ->type_name("FILE");
    verb->add_flag("--for-this-renderer", options.is_for_this_renderer,
                   "Beside the baseline for all machines, for those with this OpenGL only");
    verb->final_callback([&options] { update_baselines(options); });
}

} // namespace

void add_baseline_verbs(CLI::App& baseline, BaselineOptions& options, const std::string& command, int& code) {
    baseline.require_subcommand(1);
    add_check(baseline, options, command, code);
    add_update(baseline, options);
    CLI::App* verb = add_verb(baseline, options, "accept", "Makes the pictures that a report shows the baselines");
    verb->add_option("REPORT", options.report, "Folder of a report of tumble baseline check")->required()->type_name("");
    verb->add_option("CASE", options.cases, "Cases of it; all that changed if not given")->type_name("");
    verb->final_callback([&options] { accept_baselines(options); });
}

} // namespace cmd
