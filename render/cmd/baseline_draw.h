#pragma once
/// The pictures of baselines, drawn as `tumble run` draws them; several scenes at a time.
#include "render/cmd/baseline_record.h"
#include "sim/model/scene_def.h"

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

namespace cmd {

/// Jobs that go on at the same time.
struct JobPlan {
    std::size_t count = 0;
    int at_once = 1;
    std::string label; ///< of the progress
    bool is_quiet = false;
};

/// How far they are [steps]; `total` grows as jobs begin.
struct JobProgress {
    std::atomic<std::int64_t> done = 0;
    std::atomic<std::int64_t> total = 0;
};

/// Calls work(i, progress) for 0 .. count - 1. Throws what one of them throws.
void run_jobs(const JobPlan& plan, const std::function<void(std::size_t, JobProgress&)>& work);

/// The frames that a record asks for: numbers, or start, quarters and end of the film.
std::vector<std::int64_t> frames_of(const BaselineRecord& record, const sim::SceneDef& scene);

/// Simulates up to the last of the record's frames, draws them into folder/frames/, which is made anew, and enters
/// in the record what made them. Frames beyond the film's end are not drawn. Throws Error.
void draw_baseline(const sim::SceneDef& scene, const std::filesystem::path& folder, int threads,
                   BaselineRecord& record, JobProgress& progress);

} // namespace cmd
