#include "render/cmd/baseline_draw.h"

#include "render/cmd/baseline_place.h"
#include "render/cmd/interrupt.h"
#include "render/cmd/progress.h"
#include "render/cmd/simulation.h"
#include "render/cmd/workplace.h"
#include "render/film/film.h"
#include "render/film/memory.h"
#include "render/film/thread_group.h"
#include "render/gl/context.h"
#include "render/gl/shader.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/world/world.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

using namespace std::chrono_literals;

constexpr auto look_interval = 50ms; ///< at interruptions and progress

} // namespace

void run_jobs(const JobPlan& plan, const std::function<void(std::size_t, JobProgress&)>& work) {
    JobProgress progress;
    std::atomic<std::size_t> next = 0;
    Progress shown(plan.label, "steps", 1, plan.is_quiet ? ProgressStyle::quiet : ProgressStyle::text);
    render::ThreadGroup threads; // ends before what its threads use
    for (int thread = 0; thread < plan.at_once; ++thread) {
        threads.start([&] {
            for (std::size_t i = next++; i < plan.count && !threads.is_stopping(); i = next++) {
                work(i, progress);
            }
        });
    }
    while (!threads.wait_for(look_interval)) {
        shown.update(progress.done, std::max<std::int64_t>(1, progress.total));
    }
    shown.clear();
    threads.join();
}

std::vector<std::int64_t> frames_of(const BaselineRecord& record, const sim::SceneDef& scene) {
    const std::int64_t last = frame_count_of(scene) - 1;
    std::vector<std::int64_t> frames = record.frames;
    if (frames.empty()) {
        for (const std::int64_t quarter : {0, 1, 2, 3, 4}) {
            frames.push_back(last * quarter / 4);
        }
        frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    }
    std::erase_if(frames, [last](std::int64_t frame) { return frame > last; });
    return frames;
}

void draw_baseline(const sim::SceneDef& scene, const fs::path& folder, int threads, BaselineRecord& record,
                   JobProgress& progress) {
    const std::vector<std::int64_t> frames = frames_of(record, scene);
    if (frames.empty()) {
        throw Error(ExitCode::usage, fmt::format("{}: none of the frames {} is in the film of {} frames", scene.name,
                                                 fmt::join(record.frames, ","), frame_count_of(scene)));
    }
    render::require_memory(scene.output.width, scene.output.height);
    sim::World world(scene, threads); // first: a scene that cannot start leaves no folder
    remove_baseline(folder / "frames");
    make_folder(folder / "frames");
    render::Film film(
        scene,
        {.folder = folder, .write_video = false, .frames = frames, .write_bodies = record.has_body_ids});
    Simulation simulation(scene, std::move(world), &film);
    simulation.restrict_to({0, frames.back() + 1});
    progress.total += simulation.last_step();

    render::ThreadGroup group; // ends before what its threads use
    film.start(group);
    group.start([&] { simulation.advance(group); });
    std::int64_t seen = 0;
    while (!group.wait_for(look_interval)) {
        if (is_interrupted()) {
            throw Error(ExitCode::interrupted, "interrupted; no baseline was changed");
        }
        progress.done += simulation.steps_done() - seen;
        seen = simulation.steps_done();
    }
    group.join();
    progress.done += simulation.steps_done() - seen;

    record.scene_text = scene.text;
    record.origin = {"tumble " TUMBLE_VERSION,
                     scene.name,
                     fmt::format("{:016x}", simulation.summary().state_hash),
                     render::shaders_hash(),
                     film.renderer_string(),
                     render::processor_class(),
                     render::shader_hashes()};
    record.pictures.clear();
    for (const sim::WrittenFile& file : film.files()) {
        record.pictures[fs::path(file.name).filename().string()] = file.sha256;
    }
}

} // namespace cmd
