#pragma once
/// Points of a study, each computed by a process of its own, some at a time.
#include "render/study/point.h"

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace cmd {

/// A piece of work for a child process. It counts its steps in the argument; what it throws ends it.
struct Job {
    std::string name{};
    std::int64_t steps = 0; ///< that it will make, for the time left
    std::function<void(std::atomic<std::int64_t>& steps_done)> work{};
    /// In the parent, when the child has ended badly: by the limit of processor time or with another reason.
    std::function<void(bool is_too_dear, const std::string& reason)> on_failure{};
};

struct CrewSettings {
    std::string label{}; ///< of the progress
    int processes = 1;
    int limit = 600; ///< [s] processor time of a job
    bool is_quiet = false;
};

/// Runs all jobs. Throws Error (interrupted) on Ctrl-C, once the children are gone; (io) if no process can be
/// started.
void run_jobs(const std::vector<Job>& jobs, const CrewSettings& settings);

} // namespace cmd
