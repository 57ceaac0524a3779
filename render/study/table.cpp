#include "render/study/table.h"

#include "render/study/ensemble.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace study {

namespace {

/// Range of each quantity over time, what errors are relative to.
std::array<double, statistics_count> scales_of(const Ensemble& reference) {
    std::array<double, statistics_count> scales{};
    for (std::size_t q = 0; q < statistics_count; ++q) {
        const auto [least, largest] =
            std::minmax_element(reference.mean.begin(), reference.mean.end(),
                                [q](const auto& a, const auto& b) { return a[q] < b[q]; });
        const double range = (*largest)[q] - (*least)[q];
        scales[q] = range > 0.0 ? range : 1.0;
    }
    return scales;
}

/// Root mean square over time of the difference of the means, of each quantity.
std::array<double, statistics_count> errors_of(const Ensemble& one, const Ensemble& reference) {
    std::array<double, statistics_count> errors{};
    const auto scales = scales_of(reference);
    for (std::size_t q = 0; q < statistics_count; ++q) {
        for (std::size_t k = 0; k < reference.mean.size(); ++k) {
            const double d = (one.mean[k][q] - reference.mean[k][q]) / scales[q];
            errors[q] += d * d / static_cast<double>(reference.mean.size());
        }
        errors[q] = std::sqrt(errors[q]);
    }
    return errors;
}

double root_mean_square(const std::array<double, statistics_count>& values) {
    double sum = 0.0;
    for (const double value : values) {
        sum += value * value;
    }
    return std::sqrt(sum / statistics_count);
}

/// Two means over n runs of variance v differ by sqrt(2 v / n) in the mean square.
double noise_of(const Ensemble& reference) {
    const auto scales = scales_of(reference);
    double sum = 0.0;
    for (const std::vector<double>& row : reference.variance) {
        for (std::size_t q = 0; q < statistics_count; ++q) {
            sum += row[q] / (scales[q] * scales[q]);
        }
    }
    const auto values = static_cast<double>(reference.variance.size() * statistics_count);
    return std::sqrt(2.0 / reference.runs * sum / values);
}

/// The row of the tasks first .. first + seeds - 1.
Row row_of(const Plan& plan, std::span<const EngineKind> engines, std::span<const Point> points, std::size_t first) {
    const Task& task = plan.tasks[first];
    Row row{.engine = engines[static_cast<std::size_t>(task.engine)].name,
            .knob = task.knob,
            .value = task.setting.value,
            .starts_at_base = task.starts_at_base};
    row.task = static_cast<int>(first);
    row.agree_until = plan.duration();
    double square = 0.0;
    for (const Point& point : points) {
        if (point.status != Status::done) {
            row.status = point.status;
            row.message = point.message;
            return row;
        }
        const double share = 1.0 / static_cast<double>(points.size());
        row.cost += share * point.cpu / point.simulated;
        row.iterations += share * point.iterations;
        row.contacts += share * point.contacts;
        row.collisions += share * point.collisions;
        row.at_limit += share * static_cast<double>(point.at_limit) / static_cast<double>(task.steps);
        square += share * point.error.rms * point.error.rms;
        row.largest = std::max(row.largest, point.error.largest);
        row.overlap = std::max(row.overlap, point.overlap);
        row.energy = std::max(row.energy, point.error.energy);
        row.heights = std::max(row.heights, point.error.heights);
        row.agree_until = std::min(row.agree_until, point.error.agree_until);
    }
    row.error = std::sqrt(square);
    return row;
}

void mark_front(std::vector<Row>& rows) {
    for (Row& row : rows) {
        row.is_on_front =
            row.status == Status::done && std::none_of(rows.begin(), rows.end(), [&row](const Row& other) {
                return other.status == Status::done && other.error <= row.error && other.cost <= row.cost &&
                       (other.error < row.error || other.cost < row.cost);
            });
    }
}

/// A field of CSV.
std::string quoted(const std::string& text) {
    std::string field = "\"";
    for (const char c : text) {
        field += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
    }
    return field + "\"";
}

void add_series(std::string& csv, const std::string& engine, const Task& task, const Plan& plan,
                std::span<const Point> points) {
    const Ensemble all = ensemble_of(points);
    for (std::size_t k = 0; k < all.mean.size(); ++k) {
        csv += fmt::format("{},{},{},{:.6g}", quoted(engine), quoted(task.knob), quoted(task.setting.value),
                           static_cast<double>(k) * plan.spacing.value());
        for (std::size_t q = 0; q < statistics_count; ++q) {
            csv += fmt::format(",{:.8g},{:.8g}", all.mean[k][q], std::sqrt(all.variance[k][q]));
        }
        csv += "\n";
    }
}

} // namespace

Table make_table(const Plan& plan, std::span<const EngineKind> engines, std::span<const Point> points,
                 std::span<const Point> references) {
    Table table;
    const auto seeds = static_cast<std::size_t>(plan.seeds);
    const Ensemble reference = ensemble_of(references);
    const bool is_statistical = plan.is_statistical() && reference.runs > 0;
    for (std::size_t first = 0; first < plan.tasks.size(); first += seeds) {
        const std::span<const Point> group = points.subspan(first, seeds);
        Row row = row_of(plan, engines, group, first);
        if (is_statistical && row.status == Status::done) {
            row.statistics = errors_of(ensemble_of(group), reference);
            row.error = root_mean_square(row.statistics);
        }
        table.rows.push_back(std::move(row));
    }
    table.noise = is_statistical && reference.runs > 1 ? noise_of(reference) : 0.0;
    mark_front(table.rows);
    return table;
}

std::string losses_text(const Plan& plan, const Table& table) {
    const std::string& ours = table.rows.front().engine;
    const auto is_other = [&ours](const Row& row) { return row.engine != ours; };
    if (std::none_of(table.rows.begin(), table.rows.end(), is_other)) {
        return {};
    }
    std::vector<const Row*> others;
    for (const Row& row : table.rows) {
        if (row.is_on_front && is_other(row)) {
            others.push_back(&row);
        }
    }
    if (others.empty()) {
        return fmt::format(
            "No point of another engine is on the front: each is beaten in error and cost by one of {}.",
            ours);
    }
    std::sort(others.begin(), others.end(), [](const Row* a, const Row* b) { return a->cost < b->cost; });
    std::string text = fmt::format("Where {} loses: nothing reaches a smaller error at less cost than", ours);
    for (std::size_t i = 0; i < others.size(); ++i) {
        const Row& row = *others[i];
        text += fmt::format("{} {}{} {} ({:.2g} s, error {:.2g}{})", i == 0 ? "" : ",", row.engine,
                            row.knob.empty() ? "" : ", " + row.knob + ",", row.value, row.cost, row.error,
                            plan.is_statistical() ? "" : " m");
    }
    return text + ".";
}

std::string table_csv(const Plan& plan, const Table& table) {
    std::string csv = fmt::format(
        "engine,knob,value,status,cost_s_per_s,error_{},largest_displacement_m,agree_until_s,overlap_m,energy,"
        "iterations_per_step,contacts_per_step,collisions_per_step,share_at_limit,on_front",
        plan.is_statistical() ? "statistical" : "m");
    for (const char* name : statistics_names) {
        csv += plan.is_statistical() ? fmt::format(",error_{}", name) : "";
    }
    csv += ",message\n";
    for (const Row& row : table.rows) {
        csv += fmt::format("{},{},{},{}", quoted(row.engine), quoted(row.knob), quoted(row.value),
                           status_names[static_cast<int>(row.status)]);
        for (const double value : {row.cost, row.error, row.largest, row.agree_until, row.overlap, row.energy,
                                   row.iterations, row.contacts, row.collisions, row.at_limit}) {
            csv += row.status == Status::done ? fmt::format(",{:.6g}", value) : ",";
        }
        csv += row.is_on_front ? ",1" : ",0";
        for (const double value : row.statistics) {
            csv += plan.is_statistical() ? fmt::format(",{:.6g}", value) : "";
        }
        csv += "," + quoted(row.message) + "\n";
    }
    return csv;
}

std::string statistics_csv(const Plan& plan, std::span<const EngineKind> engines, std::span<const Point> points,
                           std::span<const Point> references) {
    std::string csv = "engine,knob,value,time_s";
    for (const char* name : statistics_names) {
        csv += fmt::format(",{0},{0}_deviation", name);
    }
    csv += "\n";
    if (!plan.references.empty()) {
        add_series(csv, engines.front().name, plan.references.front(), plan, references);
    }
    const auto seeds = static_cast<std::size_t>(plan.seeds);
    for (std::size_t first = 0; first < plan.tasks.size(); first += seeds) {
        const Task& task = plan.tasks[first];
        add_series(csv, engines[static_cast<std::size_t>(task.engine)].name, task, plan,
                   points.subspan(first, seeds));
    }
    return csv;
}

} // namespace study
