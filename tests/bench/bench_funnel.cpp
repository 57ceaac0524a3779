/// bench_funnel [--set key=value]... [--steps N] [--check-every N] [--engines a,b,...] [--scene FILE] [--out
/// DIR]
///
/// The funnel in tumble, Bullet and ODE: the same bodies at the same places, one thread, the engines taking
/// turns of a hundred steps so that the machine's moods meet all alike. Times are processor time of the
/// thread. Every N steps the overlaps are judged by the independent check, outside the timing; ours after
/// every step, in a second run that comes to the same state: looking at all pairs empties the caches. Writes
/// steps.csv, summary.csv, summary.md and figure4 into DIR (default out/bench).
#include "tests/bench/engine.h"
#include "tests/bench/figure4.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"
#include "tests/laws/law_solids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>

namespace {

using bench::Engine;
using bench::StepCounts;

constexpr int turn_length = 100;   // steps an engine takes before the next one's turn
constexpr double tolerance = 1e-4; // [m] above which an overlap counts

struct Options {
    std::string scene = TUMBLE_SCENE_DIR "/funnel.toml";
    std::string out = TUMBLE_OUT_DIR "/bench";
    std::string engines = "tumble,bullet10,ode10";
    std::vector<std::string> overrides;
    int steps = 0; ///< 0: the scene's duration
    int check_every = 50;
};

/// One engine's run so far.
struct Run {
    Engine engine;
    int check_every = 1;
    std::vector<double> ms; ///< processor time of each step
    std::vector<StepCounts> counts;
    std::vector<double> deepest; ///< [m] of each step that was checked, else -1
    reference::OverlapStatistics overlaps;
    std::set<int> left; ///< bodies that passed through a static one
    std::vector<reference::Placement> last_checked;
};

double thread_ms() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

void check(Run& run, const std::vector<reference::Solid>& solids) {
    const std::vector<reference::Placement> placed = run.engine.placements();
    const std::vector<reference::PairGap> pairs = reference::near_pairs(solids, placed, 0.0);
    run.overlaps.add(pairs);
    double deepest = 0.0;
    for (const reference::PairGap& pair : pairs) {
        deepest = std::max(deepest, -pair.gap);
    }
    run.deepest.back() = deepest;
    if (!run.last_checked.empty()) {
        for (int body : reference::passed_through(solids, run.last_checked, placed)) {
            run.left.insert(body);
        }
    }
    run.last_checked = placed;
}

void take_turn(Run& run, const std::vector<reference::Solid>& solids, int steps) {
    for (int i = 0; i < steps; ++i) {
        const double before = thread_ms();
        run.engine.step();
        run.ms.push_back(thread_ms() - before);
        run.counts.push_back(run.engine.counts());
        run.deepest.push_back(-1.0);
        if (run.ms.size() % static_cast<std::size_t>(run.check_every) == 0) {
            check(run, solids);
        }
    }
}

double mean(const std::vector<double>& values) {
    double sum = 0.0;
    for (double value : values) {
        sum += value;
    }
    return sum / static_cast<double>(values.size());
}

std::string first_line_with(const char* file, const std::string& key) {
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);) {
        if (line.starts_with(key)) {
            return line.substr(line.find(':') + 2);
        }
    }
    return "unknown processor";
}

void write_results(const Options& options, const std::vector<Run>& runs, double h) {
    std::string steps = "engine,step,ms,contacts,collisions,iterations,collisions_ms,contacts_ms,deepest_m\n";
    std::string csv =
        "engine,steps,ms_per_step,slowest_ms,times_real_time,contacts,overlap_p50_m,overlap_p99_m,"
        "overlap_max_m,share_above,unconverged,left,state_hash\n";
    std::string page = fmt::format(
        "# Funnel, one thread, {} steps of {:g} ms\n\n{}; {} {}; flags {}\n\n"
        "| engine | ms/step | slowest | x real time | contacts | overlap p50 | p99 | max [m] | share > 1e-4 "
        "m | "
        "unconverged | left |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        runs.front().ms.size(), 1e3 * h, first_line_with("/proc/cpuinfo", "model name"), TUMBLE_COMPILER,
        __VERSION__, TUMBLE_FLAGS);
    for (const Run& run : runs) {
        double contacts = 0.0;
        long unconverged = 0;
        for (std::size_t i = 0; i < run.ms.size(); ++i) {
            const StepCounts& c = run.counts[i];
            contacts += c.contacts / static_cast<double>(run.ms.size());
            unconverged += c.unconverged ? 1 : 0;
            steps += fmt::format("\"{}\",{},{:.5f},{},{},{},{:.5f},{:.5f},{:.3e}\n", run.engine.name, i + 1,
                                 run.ms[i], c.contacts, c.collisions, c.iterations, c.collisions_ms,
                                 c.contacts_ms, run.deepest[i]);
        }
        const double ms = mean(run.ms), slowest = *std::max_element(run.ms.begin(), run.ms.end());
        csv += fmt::format("\"{}\",{},{:.4f},{:.3f},{:.3f},{:.0f},{:.3e},{:.3e},{:.3e},{:.3e},{},{},{}\n",
                           run.engine.name, run.ms.size(), ms, slowest, 1e3 * h / ms, contacts,
                           run.overlaps.quantile(0.5), run.overlaps.quantile(0.99), run.overlaps.largest(),
                           run.overlaps.share_above(tolerance), unconverged, run.left.size(),
                           run.engine.state_hash ? run.engine.state_hash() : "");
        page += fmt::format(
            "| {} | {:.2f} | {:.1f} | {:.2f} | {:.0f} | {:.1e} | {:.1e} | {:.1e} | {:.2f} % | {} | {} |\n",
            run.engine.name, ms, slowest, 1e3 * h / ms, contacts, run.overlaps.quantile(0.5),
            run.overlaps.quantile(0.99), run.overlaps.largest(), 100.0 * run.overlaps.share_above(tolerance),
            unconverged, run.left.size());
    }
    std::filesystem::create_directories(options.out);
    sim::write_file(options.out + "/steps.csv", steps);
    sim::write_file(options.out + "/summary.csv", csv);
    sim::write_file(options.out + "/summary.md", page);
    std::fputs(page.c_str(), stdout);
    for (const Run& run : runs) {
        if (run.engine.name == "tumble") {
            bench::write_figure4(run.counts, options.out);
        }
    }
}

Options parse(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; i += 2) {
        const std::string key = argv[i];
        if (i + 1 == argc) {
            throw sim::Error(sim::ExitCode::usage, key + " needs a value");
        }
        const std::string value = argv[i + 1];
        if (key == "--set") {
            options.overrides.push_back(value);
        } else if (key == "--scene") {
            options.scene = value;
        } else if (key == "--out") {
            options.out = value;
        } else if (key == "--engines") {
            options.engines = value;
        } else if (key == "--steps") {
            options.steps = std::stoi(value);
        } else if (key == "--check-every") {
            options.check_every = std::max(std::stoi(value), 1);
        } else {
            throw sim::Error(sim::ExitCode::usage, "unknown option " + key);
        }
    }
    return options;
}

/// "tumble", "bullet10", "ode50": the number is that of the iterations.
Run make_run(const std::string& name, const sim::SceneDef& scene, int check_every) {
    Run run;
    run.check_every = check_every;
    const std::size_t digits = name.find_first_of("0123456789");
    const std::string kind = name.substr(0, digits);
    const int iterations = digits == std::string::npos ? 10 : std::stoi(name.substr(digits));
    if (kind == "tumble") {
        run.engine = bench::make_ours(scene);
    } else if (kind == "bullet") {
        run.engine = bench::make_bullet(scene, {.iterations = iterations});
    } else if (kind == "ode") {
        run.engine = bench::make_ode(scene, {.iterations = iterations});
    } else {
        throw sim::Error(sim::ExitCode::usage, "unknown engine " + name);
    }
    return run;
}

/// Looks at every step of ours, in a run that is not timed.
void check_all(Run& run, const sim::SceneDef& scene, const std::vector<reference::Solid>& solids) {
    Run again = make_run(run.engine.name, scene, 1);
    const auto steps = static_cast<int>(run.ms.size());
    for (int done = 0; done < steps; done += turn_length) {
        take_turn(again, solids, std::min(turn_length, steps - done));
        std::fprintf(stderr, "\r%d of %d steps looked at", std::min(done + turn_length, steps), steps);
    }
    std::fputs("\n", stderr);
    if (again.engine.state_hash() != run.engine.state_hash()) {
        throw sim::Error(sim::ExitCode::stopped, "a second run came to another state");
    }
    run.overlaps = again.overlaps;
    run.deepest = again.deepest;
    run.left = again.left;
}

int measure(const Options& options) {
    const sim::SceneDef scene = sim::load_scene(options.scene, options.overrides);
    const std::vector<reference::Solid> solids = laws::solids(scene);
    const double h = scene.step.time_step.value();
    const int steps =
        options.steps > 0 ? options.steps : static_cast<int>(scene.output.duration.value() / h + 0.5);
    std::vector<Run> runs;
    std::stringstream names(options.engines);
    for (std::string name; std::getline(names, name, ',');) {
        runs.push_back(make_run(name, scene, options.check_every));
    }
    for (int done = 0; done < steps; done += turn_length) {
        for (Run& run : runs) {
            take_turn(run, solids, std::min(turn_length, steps - done));
        }
        std::fprintf(stderr, "\r%d of %d steps", std::min(done + turn_length, steps), steps);
    }
    std::fputs("\n", stderr);
    for (Run& run : runs) {
        if (run.engine.name == "tumble") {
            check_all(run, scene, solids);
        }
    }
    write_results(options, runs, h);
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    try {
        return measure(parse(argc, argv));
    } catch (const sim::Error& error) {
        std::fprintf(stderr, "bench_funnel: %s\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "bench_funnel: %s\n", error.what());
        return 2;
    }
}
