/// The program tumble-draw: arguments to a verb, the verb's outcome to an exit code. start.cpp is what a user
/// calls.
#include "render/cmd/baseline.h"
#include "render/cmd/compare.h"
#include "render/cmd/export.h"
#include "render/cmd/films.h"
#include "render/cmd/guard.h"
#include "render/cmd/manual.h"
#include "render/cmd/options.h"
#include "render/cmd/side_by_side.h"
#include "render/cmd/study.h"
#include "render/cmd/usage.h"
#include "sim/base/error.h"
#include "sim/scene/tree.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

namespace {

using sim::ExitCode;

constexpr const char* short_help = R"(tumble simulates rigid bodies in contact and makes films of them.

  tumble new first.toml       a scene to start from
  tumble run first.toml       its film: out/first/first.mp4
  tumble scenes               the scenes that came with the program

All verbs and options: tumble --help, man tumble
)";

constexpr const char* exit_codes = R"(Exit status:
  0    good
  1    a comparison is above its limit
  2    arguments, or the content of a scene
  3    reading or writing a file
  4    a frame is missing or of another size
  5    the simulation stopped
  130  interrupted
)";

/// A line of what is typed, and what it does.
struct Example {
    std::string_view verb;
    std::string_view command;
    std::string_view effect;
};

constexpr Example examples[] = {
    {"run", "tumble run funnel", "out/funnel/: frames, film, trajectory, summary"},
    {"run", "tumble run scenes/*.toml --size 640x360 --fps 30", "all scenes, small"},
    {"run", "tumble run funnel --show time,points,impulses --color-by speed",
     "contacts as dots and arrows, speed in colours"},
    {"run", "tumble run coin --set output.speed=0.25", "slow motion"},
    {"run", "tumble run film.toml --size 1080x1920", "upright, for a phone"},
    {"run", "tumble run funnel --out - --format y4m | ffmpeg -i - film.mov", "frames to another program"},
    {"simulate", "tumble simulate funnel --time-step 1/500", "trajectory and summary only"},
    {"simulate", "tumble simulate office_toy --accuracy 1mm", "settings are found, and what error is left is said"},
    {"run", "tumble run funnel --budget 2min", "the best settings and pictures for that time"},
    {"render", "tumble render out/funnel --camera top", "another view without simulating again"},
    {"render", "tumble render out/funnel --frames 0:180", "half of the film, for tumble join"},
    {"join", "tumble join out/funnel other/funnel", "the film of frames drawn in two folders"},
    {"side-by-side", "tumble side-by-side before/funnel out/funnel -o both.mp4", "two runs, in step"},
    {"export", "tumble export out/funnel --gltf funnel.glb", "for Blender, or a page with three.js"},
    {"export", "tumble export out/funnel --csv - | head", "poses and velocities as a table"},
    {"check", "tumble check - < film.toml", "a scene from standard input"},
    {"gallery", "tumble gallery out", "out/index.html"},
    {"scenes", "tumble scenes", "the scenes that came with the program"},
    {"new", "tumble new first.toml", "a scene to start from"},
    {"study", "tumble study funnel", "out/study/funnel/index.html"},
    {"compare", "tumble compare before/funnel out/funnel --report out/report", "two runs, frame by frame"},
    {"baseline", "tumble baseline update scenes/funnel.toml", "accepts what is drawn now"},
    {"baseline", "tumble baseline check scenes/funnel.toml", "draws it again and compares"},
};

/// Examples of one verb; of all with an empty name.
std::string examples_of(std::string_view verb) {
    std::string text;
    for (const Example& example : examples) {
        if (verb.empty() || example.verb == verb) {
            text += fmt::format("  {}\n      {}\n", example.command, example.effect);
        }
    }
    return text.empty() ? text : "Examples:\n" + text;
}

/// tumble help [VERB]: the help of a verb, such as "baseline check", or of all.
void print_help(const CLI::App& app, const std::vector<std::string>& words) {
    const CLI::App* verb = &app;
    for (const std::string& word : words) {
        std::vector<std::string> names;
        const CLI::App* found = nullptr;
        for (const CLI::App* next : verb->get_subcommands([](const CLI::App*) { return true; })) {
            names.push_back(next->get_name());
            found = next->get_name() == word ? next : found;
        }
        if (found == nullptr) {
            throw sim::Error(ExitCode::usage,
                             fmt::format("help: unknown verb '{}'{}", word, sim::suggestion(word, names)));
        }
        verb = found;
    }
    std::string before = words.empty() ? "" : "tumble";
    for (std::size_t i = 0; i + 1 < words.size(); ++i) {
        before += " " + words[i];
    }
    // The formatter itself: App::help() is that of the verb in use, which is help.
    const std::string name = before + (before.empty() ? "" : " ") + verb->get_name();
    std::fputs(verb->get_formatter()->make_help(verb, name, CLI::AppFormatMode::Normal).c_str(), stdout);
}

CLI::App* add_verb(CLI::App& app, const char* name, const char* description, cmd::Options& options,
                   cmd::Changes changes) {
    CLI::App* verb = app.add_subcommand(name, description);
    cmd::add_options(*verb, options, changes);
    return verb;
}

/// What simulates, draws, or reads scenes.
void add_scene_verbs(CLI::App& app, cmd::Options& options) {
    const auto scenes = [&options](CLI::App* verb, void (*work)(const cmd::Options&)) {
        verb->add_option("SCENE", options.inputs, "Scene files (TOML)")->required()->type_name("");
        verb->final_callback([&options, work] { work(options); });
    };
    using enum cmd::Changes;
    CLI::App* run = add_verb(app, "run", "Simulate, draw and encode: DIR/<scene>/", options, everything);
    cmd::add_frame_options(*run, options);
    cmd::add_checkpoint_options(*run, options);
    cmd::add_still_options(*run, options);
    cmd::add_strict_option(*run, options);
    cmd::add_search_options(*run, options);
    scenes(run, cmd::run_scenes);
    CLI::App* simulate = add_verb(app, "simulate", "No pictures: trajectory and summary", options, everything);
    cmd::add_checkpoint_options(*simulate, options);
    cmd::add_strict_option(*simulate, options);
    cmd::add_search_options(*simulate, options);
    scenes(simulate, cmd::simulate_scenes);
    CLI::App* render =
        add_verb(app, "render", "Pictures and film of an earlier simulation", options, only_output);
    cmd::add_frame_options(*render, options);
    render->add_flag("--resume", options.is_resumed, "Goes on after an interruption: whole frames are kept");
    cmd::add_still_options(*render, options);
    render->add_option("RUN", options.inputs, "Folder of a run, or its trajectory.h5")
        ->required()
        ->type_name("");
    render->final_callback([&options] { cmd::render_trajectory(options); });
    CLI::App* join = app.add_subcommand("join", "The film from the frames of one or more folders");
    join->add_option("FOLDER", options.inputs, "Folders with frames/")->required()->type_name("");
    join->add_option("--out", options.out, "Folder for the film")->type_name("DIR");
    cmd::add_still_options(*join, options);
    cmd::add_progress_options(*join, options);
    join->final_callback([&options] { cmd::join_frames(options); });
    CLI::App* check =
        add_verb(app, "check", "Read and validate only; print what the scene contains", options, everything);
    check->add_flag("--estimate", options.is_estimated, "Also time, disk and memory of a run, from a pilot of a second");
    scenes(check, cmd::check_scenes);
}

/// What neither simulates nor draws.
void add_other_verbs(CLI::App& app, cmd::Options& options) {
    CLI::App* gallery = app.add_subcommand("gallery", "One page of all results in a folder: DIR/index.html");
    gallery->add_option("DIR", options.out, "Folder of runs and reports; out/ if not given")->type_name("");
    gallery->add_flag("--quiet", options.is_quiet, "Only errors are printed");
    gallery->final_callback([&options] {
        options.out = options.out.empty() ? "out" : options.out;
        cmd::write_gallery(options);
    });
    CLI::App* scenes_verb = app.add_subcommand("scenes", "A line for each scene of a folder");
    scenes_verb->add_option("DIR", options.inputs, "Folder; scenes/, or those installed, if not given")
        ->type_name("")
        ->expected(0, 1);
    scenes_verb->final_callback([&options] { cmd::list_scenes(options); });
    CLI::App* new_verb = app.add_subcommand("new", "Writes a commented scene to start from");
    new_verb->add_option("FILE", options.inputs, "A name that ends in .toml")
        ->required()
        ->type_name("")
        ->expected(1);
    new_verb->add_flag("--quiet", options.is_quiet, "Only errors are printed");
    new_verb->final_callback([&options] { cmd::new_scene(options); });
    app.add_subcommand("devices", "What can draw here: OpenGL in software, graphics cards")->final_callback([&options] {
        cmd::list_devices(options);
    });
    app.add_subcommand("man", "Prints the manual page, for man -l -")->final_callback([&app] {
        std::fputs(cmd::man_page(app).c_str(), stdout);
    });
    app.add_subcommand("completion", "Prints the completion for bash")->final_callback([&app] {
        std::fputs(cmd::bash_completion(app).c_str(), stdout);
    });
    CLI::App* help = app.add_subcommand("help", "The help of a verb");
    help->add_option("VERB", options.inputs, "Name of a verb")->type_name("")->expected(-1);
    help->final_callback([&app, &options] { print_help(app, options.inputs); });
}

int run_program(int argc, char** argv) {
    CLI::App app("Simulates rigid bodies in contact from a scene file and makes a film of them.", "tumble");
    app.set_version_flag("--version", "tumble " TUMBLE_VERSION);
    app.require_subcommand(0, 1);
    cmd::Options options;
    add_scene_verbs(app, options);
    add_other_verbs(app, options);

    cmd::SideBySideOptions panels;
    CLI::App* panels_verb = app.add_subcommand("side-by-side", "Two to four films in one, in step");
    cmd::add_side_by_side_options(*panels_verb, panels);
    panels_verb->final_callback([&panels] { cmd::write_films_side_by_side(panels); });
    cmd::ExportOptions exported;
    CLI::App* export_verb = app.add_subcommand("export", "A run for other programs: glTF, CSV");
    cmd::add_export_options(*export_verb, exported);
    export_verb->final_callback([&exported] { cmd::export_run(exported); });
    cmd::StudyOptions study;
    CLI::App* study_verb =
        app.add_subcommand("study", "What settings of a scene cost and how wrong they are");
    cmd::add_study_options(*study_verb, study);
    study_verb->final_callback([&study] { cmd::study_scenes(study, std::array{study::our_engine()}); });
    cmd::CompareOptions comparison;
    int code = static_cast<int>(ExitCode::good);
    CLI::App* compare = app.add_subcommand("compare", "Two pictures, folders of frames, films or runs");
    cmd::add_compare_options(*compare, comparison);
    compare->final_callback([&] {
        const diff::FilmTools films = cmd::film_tools();
        code = cmd::compare(comparison, cmd::command_line(argc, argv), &films);
    });
    cmd::BaselineOptions baselines;
    const std::string command = cmd::command_line(argc, argv);
    cmd::add_baseline_verbs(*app.add_subcommand("baseline", "Accepted pictures of scenes: check, update, accept"),
                            baselines, command, code);

    app.footer(examples_of("") + "\n" + exit_codes);
    for (CLI::App* verb : app.get_subcommands([](const CLI::App*) { return true; })) {
        verb->footer(examples_of(verb->get_name()));
    }
    try {
        app.parse(argc, argv);
        if (app.get_subcommands().empty()) {
            std::fputs(short_help, stderr);
            return static_cast<int>(ExitCode::usage);
        }
    } catch (const CLI::Success& help_or_version) {
        return app.exit(help_or_version);
    } catch (const CLI::ParseError& error) {
        throw sim::Error(ExitCode::usage, cmd::usage_message(app, argc, argv, error));
    }
    return code;
}

} // namespace

int main(int argc, char** argv) {
    return cmd::guarded([&] { return run_program(argc, argv); });
}
