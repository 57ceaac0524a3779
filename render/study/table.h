#pragma once
/// The points of a study as rows, one for all seeds, and as files: CSV.
#include "render/study/point.h"

#include <array>

namespace study {

/// One setting of one engine.
struct Row {
    std::string engine{};
    std::string knob{}; ///< empty: the base
    std::string value{};
    bool starts_at_base = true;
    Status status = Status::done;
    std::string message{};
    double cost = 0.0;    ///< [s] processor time a simulated second, mean over the seeds
    double error = 0.0;   ///< [m], or [-] where it is statistical
    double largest = 0.0; ///< [m] largest displacement of a body
    double agree_until = 0.0; ///< [s] least over the seeds
    double overlap = 0.0;     ///< [m]
    double energy = 0.0;      ///< [-]
    double heights = 0.0;     ///< [-] as in Difference
    double iterations = 0.0, contacts = 0.0, collisions = 0.0; ///< a step
    double at_limit = 0.0;    ///< [-] share of the steps
    std::array<double, statistics_count> statistics{}; ///< [-] error of each, where it is statistical
    bool is_on_front = false; ///< no other row has less error at less cost
    int task = 0;             ///< index of its first task
};

struct Table {
    std::vector<Row> rows;
    double noise = 0.0; ///< [-] error that two means over as many other seeds would show; 0 if not statistical
};

/// points: of the plan's tasks, in their order; references: of its references.
Table make_table(const Plan& plan, std::span<const EngineKind> engines, std::span<const Point> points,
                 std::span<const Point> references);

/// Where the first engine loses: the points of the others on the front, the cheapest first, in one sentence. Empty if
/// there is one engine only.
std::string losses_text(const Plan& plan, const Table& table);

/// study.csv.
std::string table_csv(const Plan& plan, const Table& table);
/// statistics.csv: the quantities over time, mean and standard deviation over the seeds.
std::string statistics_csv(const Plan& plan, std::span<const EngineKind> engines, std::span<const Point> points,
                           std::span<const Point> references);

} // namespace study
