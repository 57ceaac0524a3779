/// bench_scale
///
/// The funnel with 1000, 8000 and 64 000 cubes: the same scene with another number of cubes in its lattice. Processor
/// time over the steps in which the first cubes meet: a step, and a contact beyond what the bodies cost in free fall, most
/// of them falling still; memory a body and a contact. Writes scale.csv and prints a table. Then columns at rest, jointed
/// figures, scenes with more threads than one, and of other shapes than cubes.
#include "sim/base/cores.h"
#include "sim/base/file_io.h"
#include "sim/base/random.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"
#include "tests/laws/tub.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace {

constexpr int first_step = 1000; // the lattice has reached the plates
constexpr int fall_begin = 100;  // nothing touches
constexpr int fall_end = 400;

double processor_ms() {
    timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double wall_ms() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Memory of this process [bytes].
double resident_bytes() {
    std::ifstream stream("/proc/self/statm");
    double total = 0.0;
    double resident = 0.0;
    stream >> total >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

struct Row {
    int bodies = 0;
    double ms = 0.0;       ///< a step
    double fall_ms = 0.0;  ///< a step of free fall
    double contacts = 0.0; ///< a step
    double sweeps = 0.0;   ///< a step
    double body_bytes = 0.0;
    double contact_bytes = 0.0;
};

Row measure(int side, int steps) {
    const std::string count = fmt::format("lattice.cube.count=[{0}, {0}, {0}]", side);
    const double before = resident_bytes();
    const sim::SceneDef scene = sim::load_scene(TUMBLE_SCENE_DIR "/funnel.toml", std::vector<std::string>{count});
    sim::World world(scene);
    world.step();
    Row row;
    row.bodies = static_cast<int>(scene.bodies.size());
    row.body_bytes = (resident_bytes() - before) / row.bodies;
    const double with_bodies = resident_bytes();
    double start = processor_ms();
    double largest = 1.0;
    double fall_start = start;
    for (int i = 1; i < steps; ++i) {
        fall_start = i == fall_begin ? processor_ms() : fall_start;
        row.fall_ms = i == fall_end ? (processor_ms() - fall_start) / (fall_end - fall_begin) : row.fall_ms;
        if (i == first_step) {
            start = processor_ms();
            row.contacts = row.sweeps = 0.0;
        }
        const sim::StepReport report = world.step();
        row.contacts += report.contacts;
        row.sweeps += report.contact_iterations;
        largest = std::max(largest, static_cast<double>(report.contacts));
    }
    const double counted = steps - std::min(first_step, steps - 1);
    row.ms = (processor_ms() - start) / counted;
    row.contacts /= counted;
    row.sweeps /= counted;
    row.contact_bytes = (resident_bytes() - with_bodies) / largest;
    return row;
}

constexpr const char* columns = R"(
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
friction = 0.5
[[lattice]]
name = "box"
count = [1, 1, 40]
spacing = [2, 2, 1]
origin = [0, 0, 0.5]
[lattice.body]
shape = { kind = "box", size = [1, 1, 1] }
friction = 0.5
)";

struct ColumnsRow {
    double first_s = 0.0; ///< until the first step is done
    double ms = 0.0;      ///< a step
};

/// side * side columns over the same steps, the first ones after that in which they are put down; one column 256 times, so that it
/// takes as long as 256.
ColumnsRow measure_columns(int side, int threads) {
    constexpr int steps = 60;
    const std::string count = fmt::format("lattice.box.count=[{0}, {0}, 40]", side);
    const int runs = side == 1 ? 256 : 1;
    ColumnsRow row;
    for (int run = 0; run < runs; ++run) {
        const double start = wall_ms();
        sim::SceneDef scene = sim::parse_scene(columns, "columns.toml", std::vector<std::string>{count});
        scene.step = sim::load_scene(TUMBLE_SCENE_DIR "/funnel.toml").step;
        sim::World world(scene, threads);
        world.step();
        const double begin = wall_ms();
        for (int i = 0; i < steps; ++i) {
            world.step();
        }
        row.first_s += 1e-3 * (begin - start) / runs;
        row.ms += (wall_ms() - begin) / (steps * runs);
    }
    return row;
}

void print_columns() {
    std::puts("\n| columns of 40 boxes | threads | ms/step | of one column, one thread | first step [s] |\n"
              "| --- | --- | --- | --- | --- |");
    double one = 0.0;
    for (const int side : {1, 16, 50}) {
        for (const int threads : {1, 2}) {
            const ColumnsRow row = measure_columns(side, threads);
            one = one == 0.0 ? row.ms : one;
            fmt::print("| {} | {} | {:.3f} | {:.0f} | {:.2f} |\n", side * side, threads, row.ms, row.ms / one, row.first_s);
            std::fflush(stdout);
        }
    }
}

/// A line of the table of scenes.
void print_scene(const char* name, const sim::SceneDef& scene, int steps) {
    sim::World world(scene);
    double slowest = 0.0;
    double sweeps = 0.0;
    const double start = processor_ms();
    for (int i = 0; i < steps; ++i) {
        const double before = processor_ms();
        sweeps += world.step().contact_iterations;
        slowest = std::max(slowest, processor_ms() - before);
    }
    fmt::print("| {} | {} | {:.2f} | {:.1f} | {:.1f} |\n", name, steps, (processor_ms() - start) / steps, slowest, sweeps / steps);
    std::fflush(stdout);
}

/// A chain that hangs from the world and swings down.
std::string chain(int links) {
    std::string text;
    for (int i = 0; i < links; ++i) {
        const double end = 0.14 * i;
        const std::string other = i > 0 ? fmt::format(", \"link {}\"", i - 1) : "";
        text += fmt::format("[[body]]\nname = \"link {}\"\nshape = {{ kind = \"capsule\", radius = 0.02, length = 0.1 }}\n"
                            "position = [{}, 0, 0]\neuler_degrees = [0, 90, 0]\n",
                            i, end + 0.07);
        text += fmt::format("[[joint]]\nname = \"joint {0}\"\nkind = \"ball\"\nbodies = [\"link {0}\"{1}]\nanchor = [{2}, 0, 0]\n",
                            i, other, end);
    }
    return text;
}

/// Figures of ten boxes that ball joints hold, in a row, turning as they fall onto a floor: those from first to last.
std::string figures(int first, int last) {
    struct Part {
        const char* name;
        sim::Vec3 size, at; ///< [m]
        int holder;         ///< the part that it hangs from
        sim::Vec3 joint;    ///< [m]
    };
    static const Part parts[] = {{"torso", {0.36, 0.22, 0.6}, {0, 0, 0}, -1, {}},
                                 {"head", {0.2, 0.2, 0.24}, {0, 0, 0.45}, 0, {0, 0, 0.31}},
                                 {"left arm", {0.36, 0.1, 0.1}, {-0.39, 0, 0.2}, 0, {-0.2, 0, 0.2}},
                                 {"right arm", {0.36, 0.1, 0.1}, {0.39, 0, 0.2}, 0, {0.2, 0, 0.2}},
                                 {"left hand", {0.36, 0.08, 0.08}, {-0.78, 0, 0.2}, 2, {-0.58, 0, 0.2}},
                                 {"right hand", {0.36, 0.08, 0.08}, {0.78, 0, 0.2}, 3, {0.58, 0, 0.2}},
                                 {"left leg", {0.14, 0.14, 0.46}, {-0.1, 0, -0.56}, 0, {-0.1, 0, -0.315}},
                                 {"right leg", {0.14, 0.14, 0.46}, {0.1, 0, -0.56}, 0, {0.1, 0, -0.315}},
                                 {"left foot", {0.12, 0.12, 0.46}, {-0.1, 0, -1.05}, 6, {-0.1, 0, -0.805}},
                                 {"right foot", {0.12, 0.12, 0.46}, {0.1, 0, -1.05}, 7, {0.1, 0, -0.805}}};
    const auto list = [](const sim::Vec3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); };
    std::string text = "[[body]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nstatic = true\nfriction = 0.6\n";
    for (int i = first; i <= last; ++i) {
        sim::Random random(static_cast<std::uint64_t>(i));
        const sim::Vec3 origin(3.0 * i, 0.0, 2.0 + 3.0 * random.uniform());
        const sim::Vec3 spin = 2.0 * random.direction(); // [rad/s]
        for (const Part& part : parts) {
            text += fmt::format("[[body]]\nname = \"{} {}\"\nshape = {{ kind = \"box\", size = {} }}\nposition = {}\n"
                                "velocity = {}\nangular_velocity = {}\nfriction = 0.6\nrestitution = 0.1\n",
                                part.name, i, list(part.size), list(origin + part.at), list(spin.cross(part.at)), list(spin));
            if (part.holder >= 0) {
                text += fmt::format("[[joint]]\nname = \"{0} {1}\"\nkind = \"ball\"\nbodies = [\"{0} {1}\", \"{2} {1}\"]\n"
                                    "anchor = {3}\n",
                                    part.name, i, parts[part.holder].name, list(origin + part.joint));
            }
        }
    }
    return text;
}

/// All in one scene, beside each in one of its own.
void print_figures() {
    constexpr int count = 64;
    constexpr int steps = 2000;
    const auto measure_figures = [&](int first, int last, int threads) { // [ms], and that of the slowest step
        sim::World world(sim::parse_scene(figures(first, last), "figures.toml"), threads);
        std::pair<double, double> ms;
        for (int i = 0; i < steps; ++i) {
            const double start = wall_ms();
            world.step();
            ms.first += (wall_ms() - start) / steps;
            ms.second = std::max(ms.second, wall_ms() - start);
        }
        return ms;
    };
    double alone = 0.0;
    for (int i = 1; i <= count; ++i) {
        alone += measure_figures(i, i, 1).first;
    }
    std::puts("\n| jointed figures that fall | threads | ms/step | slowest | of each alone, one thread |\n| --- | --- | --- | --- | --- |");
    for (const int threads : {1, 2}) {
        const auto [ms, slowest] = measure_figures(1, count, threads);
        fmt::print("| {} | {} | {:.2f} | {:.1f} | {:.2f} |\n", count, threads, ms, slowest, ms / alone);
        std::fflush(stdout);
    }
}

void print_scenes() {
    std::puts("\n| scene, one thread | steps | ms/step | slowest | sweeps |\n| --- | --- | --- | --- | --- |");
    print_scene("rubble", sim::load_scene(TUMBLE_SCENE_DIR "/rubble.toml"), 3000);
    print_scene("dominoes", sim::load_scene(TUMBLE_SCENE_DIR "/dominoes.toml"), 12000);
    const std::vector<std::string> of_1000 = {
        "lattice.piece.count=[10,10,10]", "lattice.piece.origin=[-2.34,-2.34,0.4]",
        "lattice.wall_x.spacing=[5.9,1,1]", "lattice.wall_x.origin=[-2.95,0,4]", "lattice.wall_x.body.shape.size=[0.4,12,8]",
        "lattice.wall_y.spacing=[1,5.9,1]", "lattice.wall_y.origin=[0,-2.95,4]", "lattice.wall_y.body.shape.size=[12,0.4,8]"};
    print_scene("1000 shapes of four kinds in a tub", sim::parse_scene(laws::tub, "tub.toml", of_1000), 2000);
    const std::vector<std::string> of_128 = {"lattice.piece.count=[4,4,8]", "simulation.velocity_tolerance=1e-7"};
    print_scene("128 of them, at the default tolerances", sim::parse_scene(laws::tub, "tub.toml", of_128), 2500);
    print_scene("a chain of 300 links", sim::parse_scene(chain(300), "chain.toml"), 500);
}

/// Time [us] until one core sees what another has written: half of that of an answer. Threads help as far as it is short.
double core_to_core_us() {
    constexpr int turns = 10000;
    struct alignas(64) Line {
        std::atomic<int> turn = 0;
    };
    Line asked;
    Line answered;
    const auto wait_for = [](const Line& line, int turn) {
        while (line.turn.load(std::memory_order_acquire) != turn) {
        }
    };
    std::thread other([&] {
        for (int i = 1; i <= turns; ++i) {
            wait_for(asked, i);
            answered.turn.store(i, std::memory_order_release);
        }
    });
    const double start = wall_ms();
    for (int i = 1; i <= turns; ++i) {
        asked.turn.store(i, std::memory_order_release);
        wait_for(answered, i);
    }
    const double ms = wall_ms() - start;
    other.join();
    return 0.5 * 1e3 * ms / turns;
}

/// The same scene with one thread, two, four and so on, as far as there are cores; in turns, so that what else the machine does
/// meets all of them.
void print_threads(const char* name, int steps) {
    constexpr int turn = 100; // steps
    const sim::SceneDef scene = sim::load_scene(fmt::format("{}/{}.toml", TUMBLE_SCENE_DIR, name));
    struct Run {
        int threads = 1;
        sim::World world;
        double ms = 0.0; ///< of a clock on the wall
    };
    std::vector<Run> runs;
    for (int threads = 1; threads <= std::max(2, sim::core_count()); threads *= 2) {
        runs.push_back({threads, sim::World(scene, threads)});
    }
    for (int done = 0; done < steps; done += turn) {
        for (Run& run : runs) {
            const double start = wall_ms();
            for (int i = 0; i < turn; ++i) {
                run.world.step();
            }
            run.ms += wall_ms() - start;
        }
    }
    for (const Run& run : runs) {
        fmt::print("| {} | {} | {:.3f} | {:.2f} |\n", name, run.threads, run.ms / steps, runs.front().ms / run.ms);
    }
    std::fflush(stdout);
}

} // namespace

int main() {
    const std::string out = "out/bench";
    constexpr int steps = 1300;
    std::string csv =
        "bodies,ms_per_step,ms_per_step_of_fall,contacts,sweeps,us_per_contact,bytes_per_body,bytes_per_contact\n";
    std::puts("| bodies | ms/step | in free fall | contacts | sweeps | us a contact beyond that | bytes a body | "
              "bytes a contact |\n"
              "| --- | --- | --- | --- | --- | --- | --- | --- |");
    for (const int side : {10, 20, 40}) {
        const Row row = measure(side, steps);
        const double us = 1e3 * (row.ms - row.fall_ms) / row.contacts;
        csv += fmt::format("{},{:.4f},{:.4f},{:.0f},{:.2f},{:.4f},{:.0f},{:.0f}\n", row.bodies, row.ms, row.fall_ms,
                           row.contacts, row.sweeps, us, row.body_bytes, row.contact_bytes);
        fmt::print("| {} | {:.2f} | {:.2f} | {:.0f} | {:.1f} | {:.3f} | {:.0f} | {:.0f} |\n", row.bodies, row.ms,
                   row.fall_ms, row.contacts, row.sweeps, us, row.body_bytes, row.contact_bytes);
        std::fflush(stdout);
    }
    std::filesystem::create_directories(out);
    sim::write_file(out + "/scale.csv", csv);
    print_columns();
    print_figures();
    const double before_us = core_to_core_us();
    std::puts("\n| scene | threads | ms/step | times as fast as one |\n| --- | --- | --- | --- |");
    print_threads("funnel", 4000);
    print_threads("rubble", 3000);
    print_threads("dominoes", 3000);
    fmt::print("\nFrom core to core before these and after: {:.2f}, {:.2f} us\n", before_us, core_to_core_us());
    print_scenes();
}
