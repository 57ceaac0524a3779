/// tumble study: the points of a sweep in processes of their own, then tables, diagram, film and page.
#include "render/cmd/study.h"

#include "render/cmd/scene_path.h"
#include "render/cmd/study_crew.h"
#include "render/cmd/study_diagram.h"
#include "render/cmd/study_film.h"
#include "render/cmd/study_page.h"
#include "render/cmd/usage.h"
#include "render/cmd/workplace.h"
#include "render/study/law.h"
#include "render/study/promise.h"
#include "render/study/table.h"
#include "sim/base/cores.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/record/trajectory.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>

namespace cmd {

namespace fs = std::filesystem;

namespace {

/// One scene under study.
struct Study {
    const StudyOptions& options;
    std::span<const study::EngineKind> engines;
    study::Plan plan;
    study::Request request{};
    fs::path folder{};
    std::string program{};                   ///< hash of this program: another one computes anew
    std::vector<study::Motion> references{}; ///< a seed each
    std::vector<study::Point> reference_points{};
    std::vector<study::Point> points{};
};

/// What a point was computed from: if it is the same, so is the point.
std::string key_of(const Study& study, const study::Task& task) {
    const study::Plan& plan = study.plan;
    std::string key = fmt::format("{}\n{}\n{} {} {}\n{}\n{}\n", study.program, plan.scene.text, task.engine,
                                  study::fraction_text(plan.spacing), plan.count, task.setting.variant,
                                  fmt::join(task.overrides, "\n"));
    if (!plan.references.empty()) {
        key += fmt::format("{}", fmt::join(plan.references.front().overrides, "\n"));
    }
    return key;
}

fs::path point_path(const Study& study, const study::Task& task) {
    return study.folder / "points" / (task.name + ".json");
}

fs::path motion_path(const Study& study, const study::Task& task) {
    return study.folder / "points" / (task.name + ".h5");
}

/// The point, if it is there and is not one that a larger limit may bring to its end.
std::optional<study::Point> kept_point(const Study& study, const study::Task& task) {
    const fs::path path = point_path(study, task);
    if (!fs::exists(path)) {
        return std::nullopt;
    }
    const auto point = study::point_from_json(sim::read_text_file(path), key_of(study, task));
    const bool may_end = point && point->status == study::Status::too_dear && point->cpu < study.options.limit;
    return may_end ? std::nullopt : point;
}

void write_point(const Study& study, const study::Task& task, const study::Point& point) {
    sim::write_file(point_path(study, task), study::point_to_json(point, key_of(study, task)));
}

void write_motion(const Study& study, const study::Task& task, const study::Motion& motion) {
    sim::TrajectoryWriter file(motion_path(study, task), study.plan.scene);
    for (const sim::Snapshot& state : motion.states) {
        file.append(state);
    }
    file.finish();
}

study::Motion read_motion(const Study& study, const study::Task& task) {
    const sim::TrajectoryReader file(motion_path(study, task));
    study::Motion motion;
    for (std::size_t k = 0; k < file.steps().size(); ++k) {
        motion.states.push_back(file.read(k));
    }
    return motion;
}

/// The work of a task: computes its point and writes it, a reference's motion too.
Job job_of(const Study& study, const study::Task& task, const study::Motion* reference) {
    Job job{.name = task.name, .steps = task.steps};
    job.work = [&study, &task, reference](std::atomic<std::int64_t>& steps_done) {
        study::Motion motion;
        const auto engine = static_cast<std::size_t>(task.engine);
        const study::Point point =
            study::run_task({study.plan, task, study.engines[engine], steps_done}, reference, motion);
        if (reference == nullptr && point.status == study::Status::done) {
            write_motion(study, task, motion);
        }
        write_point(study, task, point);
    };
    job.on_failure = [&study, &task](bool is_too_dear, const std::string& reason) {
        study::Point point;
        point.status = is_too_dear ? study::Status::too_dear : study::Status::stopped;
        point.cpu = study.options.limit;
        point.message = reason;
        write_point(study, task, point);
    };
    return job;
}

CrewSettings crew_settings(const Study& study, const std::string& what) {
    return {.label = study.plan.scene.name + ", " + what,
            .processes = study.options.jobs > 0 ? study.options.jobs : sim::core_count(),
            .limit = study.options.limit,
            .is_quiet = study.options.is_quiet};
}

/// Computes what is missing of a part of the tasks.
void compute_points(const Study& study, const std::vector<study::Task>& tasks, Share share,
                    const std::string& what) {
    std::vector<Job> jobs;
    for (std::size_t i = share.first; i < tasks.size(); i += share.count) {
        const study::Task& task = tasks[i];
        if (!kept_point(study, task)) {
            const auto seed = static_cast<std::size_t>(task.seed);
            jobs.push_back(job_of(study, task, study.references.empty() ? nullptr : &study.references[seed]));
        }
    }
    // The dearest first: none is left to run alone at the end.
    std::stable_sort(jobs.begin(), jobs.end(), [](const Job& a, const Job& b) { return a.steps > b.steps; });
    run_jobs(jobs, crew_settings(study, what));
}

/// Computes what is missing of `tasks` and reads all of it.
std::vector<study::Point> points_of(const Study& study, const std::vector<study::Task>& tasks,
                                    const std::string& what) {
    compute_points(study, tasks, {}, what);
    std::vector<study::Point> points;
    for (const study::Task& task : tasks) {
        const auto point =
            study::point_from_json(sim::read_text_file(point_path(study, task)), key_of(study, task));
        CHECK(point.has_value());
        points.push_back(*point);
    }
    return points;
}

/// Throws Error (stopped) if the point is not done.
study::Motion read_reference(const Study& study, const study::Task& task, const study::Point& point) {
    if (point.status != study::Status::done) {
        throw sim::Error(sim::ExitCode::stopped,
                         fmt::format("{}: there is no converged solution to hold the points against: {}",
                                     study.plan.scene.name, point.message));
    }
    return read_motion(study, task);
}

void find_references(Study& study) {
    const study::Plan& plan = study.plan;
    if (plan.references.empty()) {
        study.references.push_back(study::law_motion(plan.scene, plan.def.law, plan.times()));
        return;
    }
    study.reference_points = points_of(study, plan.references, "the converged solution");
    for (std::size_t i = 0; i < plan.references.size(); ++i) {
        study.references.push_back(read_reference(study, plan.references[i], study.reference_points[i]));
    }
}

/// Those that a share of the points is held against, which other tasks have computed.
void read_references(Study& study, Share share) {
    const study::Plan& plan = study.plan;
    if (plan.references.empty()) {
        find_references(study);
        return;
    }
    study.references.resize(plan.references.size());
    for (std::size_t i = share.first; i < plan.tasks.size(); i += share.count) {
        const auto seed = static_cast<std::size_t>(plan.tasks[i].seed);
        if (study.references[seed].states.empty()) {
            const auto point = kept_point(study, plan.references[seed]);
            study.references[seed] = read_reference(study, plan.references[seed], point.value_or(study::Point{}));
        }
    }
}

/// Frames of a panel, and its folders if nothing else is in them.
void remove_panel(const fs::path& folder) {
    remove_frame_files(folder / "frames");
    remove_if_empty(folder / "frames");
    remove_if_empty(folder);
}

void make_film(const Study& study, const study::Table& table) {
    const std::vector<Panel> panels = choose_panels(study.plan, table);
    const fs::path folder = study.folder / "film";
    // What an interrupted study has left.
    for (const study::Task& task : study.plan.tasks) {
        remove_panel(folder / task.name);
    }
    std::vector<Job> jobs;
    for (const Panel& panel : panels) {
        const study::Task& task =
            study.plan.tasks[static_cast<std::size_t>(table.rows[static_cast<std::size_t>(panel.row)].task)];
        Job job{.name = panel.name, .steps = task.steps};
        job.work = [&study, &task, path = folder / panel.name](std::atomic<std::int64_t>& steps_done) {
            draw_panel(study.plan, task, study.engines[static_cast<std::size_t>(task.engine)], path, steps_done);
        };
        job.on_failure = [name = panel.name](bool, const std::string& reason) {
            throw sim::Error(sim::ExitCode::stopped, fmt::format("the film of {} was not made: {}", name, reason));
        };
        jobs.push_back(std::move(job));
    }
    CrewSettings settings = crew_settings(study, "film");
    settings.limit = 10 * study.options.limit; // drawing comes on top
    run_jobs(jobs, settings);
    join_panels(study.plan, panels, folder);
    for (const Panel& panel : panels) {
        remove_panel(folder / panel.name);
    }
}

void print_front(const study::Plan& plan, const study::Table& table, const fs::path& folder) {
    std::vector<study::Row> front;
    std::copy_if(table.rows.begin(), table.rows.end(), std::back_inserter(front),
                 [](const study::Row& row) { return row.is_on_front; });
    std::sort(front.begin(), front.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
    std::printf("%s: %zu points, %zu on the front; in %s\n", plan.scene.name.c_str(), table.rows.size(),
                front.size(), folder.c_str());
    for (const study::Row& row : front) {
        std::fputs(fmt::format("  {:>9.3g} s/s  error {:>8.2g}{}  {} {} {}\n", row.cost, row.error,
                               plan.is_statistical() ? "" : " m", row.engine,
                               row.knob.empty() ? "as given:" : row.knob, row.value)
                       .c_str(),
                   stdout);
    }
    for (const auto& [preset, promises] : study::preset_promises(plan, table)) {
        std::printf("  preset %s: %s\n", study::preset_names[static_cast<std::size_t>(preset)],
                    study::promises_text(promises).c_str());
    }
    if (table.noise > 0.0) {
        std::printf("  errors below %.2g are within the spread of a mean over %d seeds\n", table.noise, plan.seeds);
    }
}

/// Files that a study writes, relative to its folder.
std::vector<std::string> study_names(const study::Plan& plan) {
    std::vector<std::string> names{"study.csv",  "promises.csv", "statistics.csv", "index.html",    "film/film.mp4",
                                   "diagram.svg", "diagram.png", "statistics.svg", "statistics.png"};
    for (const std::vector<study::Task>* tasks : {&plan.tasks, &plan.references}) {
        for (const study::Task& task : *tasks) {
            names.push_back("points/" + task.name + ".json");
            names.push_back("points/" + task.name + ".h5");
        }
    }
    return names;
}

/// A task of a cluster, "points:3/25": others compute other parts into the folder meanwhile. Throws Error.
void study_part(Study& study, const std::string& part) {
    const std::size_t colon = std::min(part.find(':'), part.size());
    const std::string word = part.substr(0, colon);
    const std::optional<Share> share = parse_share(std::string_view(part).substr(std::min(colon + 1, part.size())));
    if (!share || (word != "references" && word != "points")) {
        throw sim::Error(sim::ExitCode::usage,
                         fmt::format("--part '{}': expected references:K/N or points:K/N with 0 <= K < N", part));
    }
    const Workplace workplace(study.folder, study_names(study.plan), Sharing::with_slices);
    make_folder(study.folder / "points");
    if (word == "references") {
        compute_points(study, study.plan.references, *share, "a part of the converged solution");
        return;
    }
    read_references(study, *share);
    compute_points(study, study.plan.tasks, *share, "a part of the points");
}

/// The stage of a cluster's work that computes these tasks, some in each of its own.
BatchStage batch_stage(const Study& study, const std::vector<study::Task>& tasks, const std::string& word,
                       std::size_t tasks_each, const std::string& command) {
    const std::size_t count = std::clamp<std::size_t>((tasks.size() + tasks_each - 1) / tasks_each, 1, most_tasks);
    BatchStage stage{.name = word, .count = static_cast<int>(count)};
    stage.commands = fmt::format("{} --part {}:$n/{} --jobs \"$cores\" --quiet", command, word, count);
    for (std::size_t n = 0; n < count; ++n) {
        for (std::size_t i = n; i < tasks.size(); i += count) {
            if (!kept_point(study, tasks[i])) {
                stage.missing.push_back(static_cast<int>(n));
                break;
            }
        }
    }
    return stage;
}

/// All points are computed by a cluster, or are to be. False if its jobs are left to themselves.
bool compute_elsewhere(const Study& study) {
    constexpr std::size_t points_each = 8;      // the start of a task and reading the references are small beside them
    constexpr std::size_t most_references = 16; // tasks: as many of these as there are seeds, which are few and dear
    const StudyOptions& options = study.options;
    std::string command = program_word() + " study " + shell_word(study.plan.scene_file);
    for (const std::string& assignment : study.request.overrides) {
        command += " --set " + shell_word(assignment);
    }
    if (!options.request.knobs.empty()) {
        command += " --knobs " + shell_word(fmt::format("{}", fmt::join(options.request.knobs, ",")));
    }
    command += fmt::format(" --seeds {} --limit {} --out {}", options.request.seeds, options.limit,
                           shell_word(study.folder.parent_path().string()));
    Batch batch{.name = study.plan.scene.name, .folder = study.folder};
    if (!study.plan.references.empty()) {
        const std::size_t each = (study.plan.references.size() + most_references - 1) / most_references;
        batch.stages.push_back(batch_stage(study, study.plan.references, "references", each, command));
    }
    batch.stages.push_back(batch_stage(study, study.plan.tasks, "points", points_each, command));
    const auto done = [&study] {
        std::int64_t count = 0;
        for (const auto* tasks : {&study.plan.references, &study.plan.tasks}) {
            count += std::count_if(tasks->begin(), tasks->end(), [&](const study::Task& task) {
                return fs::exists(point_path(study, task));
            });
        }
        return count;
    };
    const auto total = static_cast<std::int64_t>(study.plan.references.size() + study.plan.tasks.size());
    return run_batches({batch}, options.placement,
                       {.unit = "points", .total = total, .done = done,
                        .progress = options.is_quiet ? ProgressStyle::quiet : ProgressStyle::text});
}

fs::path study_folder(const StudyOptions& options) {
    return options.out.empty() ? "out/study" : options.out;
}

/// What its engines reach; none if others finish the study.
std::optional<render::Chart> study_scene(const StudyOptions& options, std::span<const study::EngineKind> engines,
                                         const std::string& scene) {
    study::Request request = options.request;
    request.scene = scene_path(scene);
    if (!options.duration.empty()) {
        request.overrides.push_back("output.duration=\"" + options.duration + "\"");
    }
    Study study{.options = options, .engines = engines, .plan = study::make_plan(request, engines), .request = request};
    study.folder = study_folder(options) / study.plan.scene.name;
    study.program = sim::sha256_of_file("/proc/self/exe");
    if (!options.part.empty()) {
        study_part(study, options.part);
        return std::nullopt;
    }
    if (is_elsewhere(options.placement) && !compute_elsewhere(study)) {
        return std::nullopt;
    }
    const Workplace workplace(study.folder, study_names(study.plan));
    make_folder(study.folder / "points");
    find_references(study);
    study.points = points_of(study, study.plan.tasks, "points");
    const study::Table table =
        study::make_table(study.plan, engines, study.points, study.reference_points);
    if (std::none_of(table.rows.begin(), table.rows.end(),
                     [](const study::Row& row) { return row.status == study::Status::done; })) {
        throw sim::Error(sim::ExitCode::stopped, fmt::format("{}: no point was done: {}", study.plan.scene.name,
                                                             table.rows.front().message));
    }
    sim::write_file(study.folder / "study.csv", study::table_csv(study.plan, table));
    sim::write_file(study.folder / "promises.csv", study::promises_csv(study.plan, table));
    if (study.plan.is_statistical()) {
        sim::write_file(study.folder / "statistics.csv",
                        study::statistics_csv(study.plan, engines, study.points, study.reference_points));
    }
    for (const char* name : {"diagram.svg", "diagram.png", "statistics.svg", "statistics.png"}) {
        workplace.remove_file(name); // of an earlier study
    }
    write_figure(study_diagram(study.plan, table), study.folder, "diagram");
    if (study.plan.is_statistical()) {
        write_figure(study_statistics(study.plan, table, study.points, study.reference_points), study.folder,
                     "statistics");
    }
    if (options.has_films) {
        make_film(study, table);
    }
    write_study_page(study.plan, table, study.folder);
    if (!options.is_quiet) {
        print_front(study.plan, table, study.folder);
    }
    return study_fronts(study.plan, table);
}

} // namespace

void add_study_options(CLI::App& verb, StudyOptions& options) {
    verb.add_option("SCENE", options.scenes, "Scene files (TOML)")->required()->type_name("");
    verb.add_option("--out", options.out, "Folder for the results; out/study if not given")->type_name("DIR");
    verb.add_option("--knobs", options.request.knobs, "Only these, such as \"time step,tolerance\"; all if not given")
        ->type_name("NAMES")
        ->delimiter(',')
        ->allow_extra_args(false);
    verb.add_option("--seeds", options.request.seeds, "Runs a point, of scenes with study.seed_key")
        ->type_name("N")
        ->check(whole_number(1, 1000));
    verb.add_option("--duration", options.duration, "Length of the motion [s]")->type_name("S");
    verb.add_option("--jobs", options.jobs, "Points at a time; one a core if not given")
        ->type_name("N")
        ->check(whole_number(1, 1024));
    verb.add_option("--limit", options.limit, "Processor time of a point, whole seconds; beyond it, it is left out")
        ->type_name("S")
        ->check(whole_number(1, 1000000));
    verb.add_option("--set", options.request.overrides, "Sets any key of the scene, for all points")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    verb.add_option("--part", options.part, "A cluster's task: points:K/N, every N-th from K on; references:K/N")
        ->type_name("PART");
    add_placement_options(verb, options.placement);
    verb.add_flag("!--no-film", options.has_films, "No film of points side by side");
    verb.add_flag("--quiet", options.is_quiet, "Only errors are printed");
}

void study_scenes(const StudyOptions& options, std::span<const study::EngineKind> engines) {
    render::Figure fronts{.width = 1240, .height = 0, .columns = 2, .charts = {}};
    for (const std::string& scene : options.scenes) {
        if (const std::optional<render::Chart> chart = study_scene(options, engines, scene)) {
            fronts.charts.push_back(*chart);
        }
    }
    if (fronts.charts.size() > 1) {
        constexpr int row_height = 380; // [px]
        fronts.height = row_height * static_cast<int>((fronts.charts.size() + 1) / 2);
        write_figure(fronts, study_folder(options), "fronts");
    }
}

} // namespace cmd
