#include "render/study/point.h"

#include "sim/base/error.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <ctime>

namespace study {

namespace {

/// Processor time of this thread [s].
double thread_time() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Steps to the next instant, and what they cost.
void advance(Engine& engine, std::int64_t steps, Point& point, std::atomic<std::int64_t>& steps_done) {
    const double start = thread_time();
    for (std::int64_t i = 0; i < steps; ++i) {
        const sim::StepReport report = engine.step();
        point.overlap = std::max(point.overlap, report.max_penetration);
        point.iterations += report.contact_iterations + report.collision_iterations;
        point.contacts += report.contacts;
        point.collisions += report.collisions;
        point.at_limit += report.at_iteration_limit ? 1 : 0;
        steps_done.fetch_add(1, std::memory_order_relaxed);
    }
    point.cpu += thread_time() - start;
}

void simulate(const Run& run, Motion& motion, Point& point) {
    const auto& [plan, task, kind, steps_done] = run;
    const sim::SceneDef scene = scene_of(plan, task);
    Engine engine = kind.make(scene, task.setting.variant);
    const std::int64_t between = task.steps / (plan.count - 1);
    for (int k = 0; k < plan.count; ++k) {
        if (k > 0) {
            advance(engine, between, point, steps_done);
        }
        if (engine.overlap) {
            point.overlap = std::max(point.overlap, engine.overlap());
        }
        motion.states.push_back(engine.snapshot());
        motion.states.back().time = k * plan.spacing.value();
        if (plan.is_statistical()) {
            point.series.push_back(
                values_of(statistics(scene, motion.states.back(), plan.def.gate_height)));
        }
    }
}

constexpr double least_time = 0.1;  // [s] measured in all: clocks and caches make single short runs differ
constexpr int most_repeats = 20;

/// Least processor time of some runs more, if one is short.
double repeated_time(const Run& of, double first) {
    double least = first, sum = first;
    for (int i = 0; i < most_repeats && sum < least_time; ++i) {
        Motion motion;
        Point point;
        std::atomic<std::int64_t> steps = 0;
        simulate({of.plan, of.task, of.engine, steps}, motion, point);
        least = std::min(least, point.cpu);
        sum += point.cpu;
    }
    return least;
}

nlohmann::json error_json(const Difference& error) {
    return {{"rms_m", error.rms},
            {"largest_m", error.largest},
            {"agree_until_s", error.agree_until},
            {"energy", error.energy},
            {"heights", error.heights}};
}

} // namespace

Point run_task(const Run& run, const Motion* reference, Motion& motion) {
    const Task& task = run.task;
    Point point;
    if (!task.refusal.empty()) {
        point.status = Status::refused;
        point.message = task.refusal;
        return point;
    }
    try {
        simulate(run, motion, point);
        point.cpu = repeated_time(run, point.cpu);
    } catch (const sim::Error& error) {
        point.status = error.code() == sim::ExitCode::stopped ? Status::stopped : Status::refused;
        point.message = error.what();
        return point;
    }
    point.simulated = run.plan.duration();
    const auto steps = static_cast<double>(task.steps);
    point.iterations /= steps;
    point.contacts /= steps;
    point.collisions /= steps;
    if (reference != nullptr) {
        point.error = difference(run.plan.scene, motion, *reference);
    }
    return point;
}

std::string point_to_json(const Point& point, const std::string& key) {
    const nlohmann::json json = {{"key", key},
                                 {"status", static_cast<int>(point.status)},
                                 {"message", point.message},
                                 {"cpu_s", point.cpu},
                                 {"simulated_s", point.simulated},
                                 {"overlap_m", point.overlap},
                                 {"iterations", point.iterations},
                                 {"contacts", point.contacts},
                                 {"collisions", point.collisions},
                                 {"at_limit", point.at_limit},
                                 {"error", error_json(point.error)},
                                 {"series", point.series}};
    return json.dump(1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

std::optional<Point> point_from_json(const std::string& text, const std::string& key) {
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    try {
        if (json.is_discarded() || json.at("key") != key) {
            return std::nullopt;
        }
        Point point;
        point.status = static_cast<Status>(std::clamp(json.at("status").get<int>(), 0, 3));
        point.message = json.at("message");
        point.cpu = json.at("cpu_s");
        point.simulated = json.at("simulated_s");
        point.overlap = json.at("overlap_m");
        point.iterations = json.at("iterations");
        point.contacts = json.at("contacts");
        point.collisions = json.at("collisions");
        point.at_limit = json.at("at_limit");
        const nlohmann::json& error = json.at("error");
        point.error = {error.at("rms_m"), error.at("largest_m"), error.at("agree_until_s"), error.at("energy"), error.at("heights")};
        point.series = json.at("series").get<std::vector<std::vector<double>>>();
        return point;
    } catch (const nlohmann::json::exception&) {
        return std::nullopt; // damaged: it is computed again
    }
}

} // namespace study
