#pragma once
/// One run of a study: from a task to what it cost and how wrong it was.
#include "render/study/motion.h"
#include "render/study/plan.h"

#include <atomic>

namespace study {

enum class Status {
    done,
    refused,  ///< the scene or the engine does not allow the settings
    stopped,  ///< by the simulation, with the reason
    too_dear, ///< beyond the limit of processor time
};
inline constexpr const char* status_names[] = {"done", "refused", "stopped", "too dear"};

struct Point {
    Status status = Status::done;
    std::string message;      ///< of what was not done
    double cpu = 0.0;         ///< [s] processor time of the steps alone, least of some runs if they are short
    double simulated = 0.0;   ///< [s]
    double overlap = 0.0;     ///< [m] largest
    double iterations = 0.0;  ///< sweeps a step, of contacts and of collisions
    double contacts = 0.0;    ///< a step
    double collisions = 0.0;  ///< a step
    std::int64_t at_limit = 0; ///< steps that did not converge
    Difference error;         ///< from the reference
    std::vector<std::vector<double>> series; ///< [count][statistics_count], of statistical scenes
};

/// What is run.
struct Run {
    const Plan& plan;
    const Task& task;
    const EngineKind& engine;
    std::atomic<std::int64_t>& steps_done; ///< counts, for those who watch
};

/// Runs a task. motion: filled with the states at the plan's instants. reference: may be null. What the scene or the
/// simulation refuses is a Point too. Throws nothing else but bad_alloc.
Point run_task(const Run& run, const Motion* reference, Motion& motion);

/// A point as JSON, with `key`: what it was computed from.
std::string point_to_json(const Point& point, const std::string& key);
/// The point of such a text, if it has this key.
std::optional<Point> point_from_json(const std::string& text, const std::string& key);

} // namespace study
