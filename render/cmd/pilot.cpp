#include "render/cmd/pilot.h"

#include "render/cmd/interrupt.h"
#include "render/cmd/workplace.h"
#include "render/film/film.h"
#include "sim/base/error.h"
#include "sim/model/film_clock.h"
#include "sim/world/world.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>

namespace cmd {

namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Frames drawn: the first tells nothing, it waits for OpenGL and the encoder.
constexpr std::size_t pilot_frames = 7;

class Stopwatch {
public:
    double wall() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
    double processor() const { return static_cast<double>(std::clock() - ticks_) / CLOCKS_PER_SEC; }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::clock_t ticks_ = std::clock();
};

void stop_if_interrupted() {
    if (is_interrupted()) {
        throw sim::Error(sim::ExitCode::interrupted, "interrupted; nothing is kept");
    }
}

/// A new folder for as long as it lives.
class ScratchFolder {
public:
    ScratchFolder() {
        std::string name = (fs::temp_directory_path() / "tumble-pilot-XXXXXX").string();
        if (mkdtemp(name.data()) == nullptr) {
            throw sim::Error(sim::ExitCode::io, fmt::format("cannot create {}", name));
        }
        path_ = name;
    }
    ~ScratchFolder() {
        std::error_code error;
        fs::remove_all(path_, error); // nothing is in it but what is made here
    }
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;

    const fs::path& path() const { return path_; }

private:
    fs::path path_;
};

double bytes_in(const fs::path& folder) {
    double sum = 0.0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        sum += entry.is_regular_file() ? static_cast<double>(entry.file_size()) : 0.0;
    }
    return sum;
}

} // namespace

double SimulationPilot::whole_time() const {
    if (seconds.empty()) {
        return 0.0;
    }
    double longest = 0.0; // of the last four parts
    for (std::size_t k = seconds.size(); k-- > 0 && k + 4 >= seconds.size();) {
        longest = std::max(longest, seconds[k] - (k > 0 ? seconds[k - 1] : 0.0));
    }
    return seconds.back() + static_cast<double>(pilot_parts - seconds.size()) * longest;
}

SimulationPilot pilot_simulation(const sim::SceneDef& scene, int threads, double most_seconds) {
    SimulationPilot pilot;
    sim::World world(scene, threads);
    const Stopwatch watch;
    const std::int64_t steps = sim::step_count_of(scene);
    pilot.states.push_back(std::make_shared<sim::Snapshot>(world.take_snapshot(sim::ContactDetail::count)));
    while (!pilot.is_whole() && watch.wall() < most_seconds) {
        const std::int64_t end = steps * static_cast<std::int64_t>(pilot.seconds.size() + 1) / pilot_parts;
        while (world.step_index() < end && (pilot.seconds.empty() || watch.wall() < most_seconds)) {
            stop_if_interrupted();
            world.step();
        }
        if (world.step_index() < end) {
            break;
        }
        pilot.seconds.push_back(watch.wall());
        pilot.states.push_back(std::make_shared<sim::Snapshot>(world.take_snapshot(sim::ContactDetail::count)));
    }
    pilot.processors = std::max(1.0, watch.processor() / watch.wall());
    return pilot;
}

PictureCost pilot_pictures(const sim::SceneDef& scene, const SimulationPilot& of, bool has_png, bool has_video) {
    const ScratchFolder folder;
    make_folder(folder.path() / "frames");
    render::Film film(scene, {.folder = folder.path(), .write_png = has_png, .write_video = has_video});
    double first_wall = 0.0;
    double first_processor = 0.0;
    const Stopwatch watch;
    {
        render::ThreadGroup threads; // ends before what its threads use
        film.start(threads);
        threads.start([&] {
            for (std::size_t k = 0; k < pilot_frames; ++k) {
                if (!film.add(static_cast<std::int64_t>(k), of.states[k * (of.states.size() - 1) / (pilot_frames - 1)])) {
                    return;
                }
            }
            film.close();
        });
        while (!threads.wait_for(1ms)) {
            if (first_wall == 0.0 && film.frames_done() > 0) {
                first_wall = watch.wall();
                first_processor = watch.processor();
            }
            if (is_interrupted()) {
                threads.stop();
            }
        }
        stop_if_interrupted();
        threads.join();
    }
    constexpr double frames = pilot_frames - 1;
    return {.wall = (watch.wall() - first_wall) / frames,
            .processor = (watch.processor() - first_processor) / frames,
            .bytes = bytes_in(folder.path()) / pilot_frames};
}

} // namespace cmd
