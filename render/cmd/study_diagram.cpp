#include "render/cmd/study_diagram.h"

#include "render/study/ensemble.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace cmd {

using render::Mark;
using study::Row;
using study::Status;

namespace {

/// Errors below it are rounding and are drawn at it [m] or [-].
constexpr double least_error = 1e-16;

glm::vec3 color_of(int rgb) {
    return glm::vec3(static_cast<float>(rgb >> 16 & 255), static_cast<float>(rgb >> 8 & 255),
                     static_cast<float>(rgb & 255)) /
           255.0f;
}

/// A hue for each engine, ours first; within it each curve has a shade and a mark of its own.
constexpr std::size_t shades = 7;
constexpr std::array<std::array<int, shades>, 3> shade_colors{
    {{0x0072b2, 0x4b2e9e, 0x009e73, 0x56b4e9, 0x1a3d6d, 0x5f9ea0, 0x7fb800},
     {0xd55e00, 0x8b2500, 0xe69f00, 0xdc143c, 0xb8860b, 0xff7f50, 0xa0522d},
     {0xcc79a7, 0x6a0572, 0x9b5fc0, 0xc71585, 0x8b5f7b, 0xb39ddb, 0xe377c2}}};
constexpr std::array<Mark, shades> shade_marks{Mark::disc,    Mark::square,   Mark::up,  Mark::down,
                                               Mark::diamond, Mark::pentagon, Mark::ring};

glm::dvec2 point_of(const Row& row) {
    return {row.cost, std::max(row.error, least_error)};
}

void sort_by_cost(std::vector<glm::dvec2>& points) {
    std::sort(points.begin(), points.end(),
              [](const glm::dvec2& a, const glm::dvec2& b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
}

/// A curve a knob of an engine, in the order of the table.
std::vector<render::Series> curves_of(const study::Table& table) {
    std::vector<render::Series> curves;
    int engine = -1;       // 0: ours
    std::size_t place = 0; // among the curves of the engine
    std::string last;
    for (const Row& row : table.rows) {
        if (row.status != Status::done || row.knob.empty()) {
            continue;
        }
        const std::string title = row.engine + ": " + row.knob;
        if (curves.empty() || curves.back().title != title) {
            place = row.engine == last ? place + 1 : 0;
            engine += row.engine == last ? 0 : 1;
            last = row.engine;
            const auto hue = static_cast<std::size_t>(engine) % shade_colors.size();
            curves.push_back({.title = title,
                              .color = color_of(shade_colors[hue][place % shades]),
                              .dash = engine == 0 ? 0.0f : 5.0f,
                              .mark = shade_marks[place % shades]});
            const auto base = std::find_if(table.rows.begin(), table.rows.end(), [&row](const Row& other) {
                return other.engine == row.engine && other.knob.empty() && other.status == Status::done;
            });
            if (base != table.rows.end() && row.starts_at_base) {
                curves.back().points.push_back(point_of(*base));
            }
        }
        curves.back().points.push_back(point_of(row));
    }
    for (render::Series& curve : curves) {
        sort_by_cost(curve.points);
    }
    return curves;
}

/// The rows worth a line: the settings as given of each engine, and the cheapest on the front.
std::vector<const Row*> rows_over_time(const study::Table& table) {
    std::vector<const Row*> rows;
    const Row* cheapest = nullptr;
    for (const Row& row : table.rows) {
        if (row.status == Status::done && row.knob.empty()) {
            rows.push_back(&row);
        } else if (row.is_on_front && (cheapest == nullptr || row.cost < cheapest->cost)) {
            cheapest = &row;
        }
    }
    if (cheapest != nullptr) {
        rows.push_back(cheapest);
    }
    return rows;
}

/// Mean and `spread` deviations of one quantity over time.
std::vector<glm::dvec2> curve_over_time(const study::Plan& plan, const study::Ensemble& all, std::size_t quantity,
                                        double spread) {
    std::vector<glm::dvec2> points;
    for (std::size_t k = 0; k < all.mean.size(); ++k) {
        points.emplace_back(static_cast<double>(k) * plan.spacing.value(),
                            all.mean[k][quantity] + spread * std::sqrt(all.variance[k][quantity]));
    }
    return points;
}

} // namespace

render::Figure study_diagram(const study::Plan& plan, const study::Table& table) {
    render::Chart chart;
    chart.title = plan.scene.name + ": error against cost";
    chart.x = {"processor time for a simulated second [s]", true};
    chart.y = {plan.is_statistical() ? "error of throughput, height, spread and energy over time [-]"
                                     : "root mean square displacement from the truth [m]",
               true};
    render::Series front{.title = "Pareto front", .color = glm::vec3(0.8f), .line = 6.0f, .has_steps = true};
    render::Series base{
        .title = "settings as given", .color = glm::vec3(0.0f), .line = 0.0f, .mark = Mark::star, .mark_size = 7.0f};
    for (const Row& row : table.rows) {
        if (row.is_on_front) {
            front.points.push_back(point_of(row));
        }
        if (row.status == Status::done && row.knob.empty()) {
            base.points.push_back(point_of(row));
            chart.labels.push_back({point_of(row), row.engine});
        }
    }
    sort_by_cost(front.points);
    render::Series rings{
        .color = glm::vec3(0.4f), .points = front.points, .line = 0.0f, .mark = Mark::ring, .mark_size = 8.0f};
    chart.series = {front, rings};
    const std::vector<render::Series> curves = curves_of(table);
    chart.series.insert(chart.series.end(), curves.begin(), curves.end());
    chart.series.push_back(base);
    if (table.noise > 0.0) {
        double least = base.points.empty() ? 1.0 : base.points[0].x, largest = least;
        for (const render::Series& curve : curves) {
            least = std::min(least, curve.points.front().x);
            largest = std::max(largest, curve.points.back().x);
        }
        chart.series.push_back({.title = fmt::format("spread of a mean over {} seeds", plan.seeds),
                                .points = {{least, table.noise}, {largest, table.noise}},
                                .dash = 2.0f});
    }
    return {.charts = {chart}};
}

render::Chart study_fronts(const study::Plan& plan, const study::Table& table) {
    constexpr std::array<Mark, shade_colors.size()> marks{Mark::disc, Mark::square, Mark::up};
    const bool shows_overlaps = plan.is_statistical();
    render::Chart chart;
    chart.title = plan.scene.title;
    chart.x = {"processor time for a simulated second [s]", true};
    chart.y = {shows_overlaps ? "largest overlap [m]" : "displacement from the truth [m]", true};
    std::vector<const Row*> rows;
    for (const Row& row : table.rows) { // engines in their order: each has its colour in every chart
        if (std::ranges::find(chart.series, row.engine, &render::Series::title) == chart.series.end()) {
            const std::size_t i = chart.series.size() % shade_colors.size();
            chart.series.push_back({.title = row.engine,
                                    .color = color_of(shade_colors[i][0]),
                                    .line = 2.0f,
                                    .mark = marks[i],
                                    .has_steps = true});
        }
        if (row.status == Status::done) {
            rows.push_back(&row);
        }
    }
    std::ranges::stable_sort(rows, {}, [](const Row* row) { return row->cost; });
    for (const Row* row : rows) {
        std::vector<glm::dvec2>& points = std::ranges::find(chart.series, row->engine, &render::Series::title)->points;
        const glm::dvec2 at{row->cost, std::max(shows_overlaps ? row->overlap : row->error, least_error)};
        if (points.empty() || at.y < points.back().y) {
            points.push_back(at);
        }
    }
    std::erase_if(chart.series, [](const render::Series& curve) { return curve.points.empty(); });
    return chart;
}

render::Figure study_statistics(const study::Plan& plan, const study::Table& table,
                                std::span<const study::Point> points, std::span<const study::Point> references) {
    constexpr std::array<const char*, study::statistics_count> labels{
        "share below the gate [-]", "mean height below it [m]", "spread below it [m]", "energy [J]"};
    constexpr std::array<int, 4> line_colors{0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7};
    const std::vector<const Row*> rows = rows_over_time(table);
    const study::Ensemble truth = study::ensemble_of(references);
    render::Figure figure{.width = 1000, .height = 700, .columns = 2, .charts = {}};
    for (std::size_t q = 0; q < labels.size(); ++q) {
        render::Chart chart{.x = {"time [s]", false}, .y = {labels[q], false}};
        chart.has_key = q == 1; // one for all
        std::vector<glm::dvec2> band = curve_over_time(plan, truth, q, 1.0);
        const std::vector<glm::dvec2> below = curve_over_time(plan, truth, q, -1.0);
        band.insert(band.end(), below.rbegin(), below.rend());
        chart.series.push_back(
            {.title = "converged, spread of a run", .color = glm::vec3(0.33f), .points = band, .is_area = true});
        chart.series.push_back({.title = "converged", .points = curve_over_time(plan, truth, q, 0.0), .line = 2.0f});
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const study::Ensemble all = study::ensemble_of(
                points.subspan(static_cast<std::size_t>(rows[i]->task), static_cast<std::size_t>(plan.seeds)));
            chart.series.push_back(
                {.title = fmt::format("{}: {}{}", rows[i]->engine, rows[i]->knob.empty() ? "" : rows[i]->knob + " ",
                                      rows[i]->value),
                 .color = color_of(line_colors[i % line_colors.size()]),
                 .points = curve_over_time(plan, all, q, 0.0)});
        }
        figure.charts.push_back(std::move(chart));
    }
    return figure;
}

void write_figure(const render::Figure& figure, const std::filesystem::path& folder, const char* name) {
    sim::write_file(folder / (std::string(name) + ".svg"), render::figure_svg(figure));
    sim::write_file(folder / (std::string(name) + ".png"), render::encode_png(render::figure_image(figure)));
}

} // namespace cmd
