/// The work-precision diagram, and the quantities of chaotic scenes over time, by gnuplot.
#include "render/study/ensemble.h"
#include "render/study/table.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <sys/wait.h>

namespace study {

namespace {

/// Errors below it are rounding and are drawn at it [m] or [-].
constexpr double least_error = 1e-16;

/// A hue for each engine, ours first; within it each curve has a shade and a mark of its own.
constexpr std::size_t shades = 7;
constexpr std::array<std::array<const char*, shades>, 3> colors{
    {{"#0072b2", "#4b2e9e", "#009e73", "#56b4e9", "#1a3d6d", "#5f9ea0", "#7fb800"},
     {"#d55e00", "#8b2500", "#e69f00", "#dc143c", "#b8860b", "#ff7f50", "#a0522d"},
     {"#cc79a7", "#6a0572", "#9b5fc0", "#c71585", "#8b5f7b", "#b39ddb", "#e377c2"}}};
constexpr std::array<int, shades> marks{7, 5, 9, 11, 13, 15, 6}; // of gnuplot: filled shapes, then a ring

/// A curve: points in order of cost.
struct Curve {
    std::string title;
    int engine = 0;                                ///< 0: ours
    int place = 0;                                 ///< among the curves of the engine
    std::vector<std::pair<double, double>> points; ///< cost, error
};

std::vector<Curve> curves_of(const Table& table) {
    std::vector<Curve> curves;
    const auto point = [](const Row& row) { return std::pair(row.cost, std::max(row.error, least_error)); };
    for (const Row& row : table.rows) {
        if (row.status != Status::done || row.knob.empty()) {
            continue;
        }
        const std::string title = row.engine + ": " + row.knob;
        if (curves.empty() || curves.back().title != title) {
            const bool is_same = !curves.empty() && curves.back().title.starts_with(row.engine + ": ");
            const int engine = curves.empty() ? 0 : curves.back().engine + (is_same ? 0 : 1);
            curves.push_back({title, engine, is_same ? curves.back().place + 1 : 0, {}});
            const auto base = std::find_if(table.rows.begin(), table.rows.end(), [&row](const Row& other) {
                return other.engine == row.engine && other.knob.empty() && other.status == Status::done;
            });
            if (base != table.rows.end() && row.starts_at_base) {
                curves.back().points.push_back(point(*base));
            }
        }
        curves.back().points.push_back(point(row));
    }
    for (Curve& curve : curves) {
        std::sort(curve.points.begin(), curve.points.end());
    }
    return curves;
}

std::string block(const std::vector<std::pair<double, double>>& points) {
    std::string text;
    for (const auto& [cost, error] : points) {
        text += fmt::format("{:.6g} {:.6g}\n", cost, error);
    }
    return text + "\n\n";
}

std::string title_of(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        escaped += c == '\'' ? std::string("''") : std::string(1, c);
    }
    return escaped;
}

/// Base points, then the front, then the curves: blocks of diagram.dat.
std::string data_of(const Table& table, const std::vector<Curve>& curves) {
    std::vector<std::pair<double, double>> front;
    std::string data;
    for (const Row& row : table.rows) {
        const std::pair point(row.cost, std::max(row.error, least_error));
        if (row.status == Status::done && row.knob.empty()) {
            data += fmt::format("{:.6g} {:.6g} \"{}\"\n", point.first, point.second, row.engine);
        }
        if (row.is_on_front) {
            front.push_back(point);
        }
    }
    std::sort(front.begin(), front.end());
    data += "\n\n" + block(front);
    for (const Curve& curve : curves) {
        data += block(curve.points);
    }
    return data;
}

std::string script_of(const Plan& plan, const Table& table, const std::vector<Curve>& curves) {
    std::string script =
        "set logscale xy\nset format xy '10^{%L}'\nset grid\nset key outside right top spacing 1.2\n"
        "set xlabel 'processor time for a simulated second [s]'\n";
    script += plan.is_statistical()
                  ? "set ylabel 'error of throughput, height, spread and energy over time [-]'\n"
                  : "set ylabel 'root mean square displacement from the truth [m]'\n";
    script += fmt::format("set title '{}: error against cost' noenhanced\n", title_of(plan.scene.name));
    std::string plot = "plot 'diagram.dat' index 1 with steps lw 6 lc rgb '#d9d9d9' title 'Pareto front', "
                       "'' index 1 with points pt 6 ps 2.2 lw 2 lc rgb '#666666' notitle";
    for (std::size_t i = 0; i < curves.size(); ++i) {
        const Curve& curve = curves[i];
        const auto place = static_cast<std::size_t>(curve.place);
        plot += fmt::format(
            ", '' index {} with linespoints pt {} ps 1.1 lw 1.6 dt {} lc rgb '{}' title '{}' noenhanced",
            i + 2, marks[place % marks.size()], curve.engine == 0 ? 1 : 2,
            colors[static_cast<std::size_t>(curve.engine) % colors.size()][place % shades],
            title_of(curve.title));
    }
    plot += ", '' index 0 using 1:2 with points pt 3 ps 1.8 lw 2 lc rgb 'black' title 'settings as given'"
            ", '' index 0 using 1:2:3 with labels offset 0,1 font ',10' noenhanced notitle";
    if (table.noise > 0.0) {
        plot += fmt::format(", {:.6g} with lines dt 3 lc rgb 'black' title 'spread of a mean over {} seeds'",
                            table.noise, plan.seeds);
    }
    script += "set terminal svg size 1000,560 font 'sans,13' background 'white'\nset output 'diagram.svg'\n" +
              plot + "\nset terminal pngcairo size 1000,560 font 'sans,11'\nset output 'diagram.png'\n" + plot + "\nunset output\n";
    return script;
}

/// Runs a script that lies in `folder`. False if there is no gnuplot.
bool run_gnuplot(const std::filesystem::path& folder, const std::string& script) {
    if (std::system("command -v gnuplot >/dev/null 2>&1") != 0) {
        return false;
    }
    std::string path;
    for (const char c : folder.string()) {
        path += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    const int status = std::system(("cd '" + path + "' && gnuplot " + script).c_str());
    if (status == -1 || !WIFEXITED(status) || WEXITSTATUS(status) != 0) {
        throw sim::Error(sim::ExitCode::io, fmt::format("gnuplot failed on {}", (folder / script).string()));
    }
    return true;
}

/// The rows worth a line: the settings as given of each engine, and the cheapest on the front.
std::vector<const Row*> rows_over_time(const Table& table) {
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

/// Lines "time mean deviation ..." of one ensemble.
std::string ensemble_block(const Plan& plan, const Ensemble& all) {
    std::string text;
    for (std::size_t k = 0; k < all.mean.size(); ++k) {
        text += fmt::format("{:.6g}", static_cast<double>(k) * plan.spacing.value());
        for (std::size_t q = 0; q < statistics_count; ++q) {
            text += fmt::format(" {:.8g} {:.8g}", all.mean[k][q], std::sqrt(all.variance[k][q]));
        }
        text += "\n";
    }
    return text + "\n\n";
}

std::string panel_script(int quantity, const std::vector<const Row*>& rows) {
    constexpr const char* labels[] = {"share below the gate [-]", "mean height below it [m]",
                                      "spread below it [m]", "energy [J]"};
    const int column = 2 + 2 * quantity;
    std::string plot = fmt::format(
        "{}\nset ylabel '{}'\nplot 'statistics.dat' index 0 using 1:(${}-${}):(${}+${}) with filledcurves "
        "fs solid 0.25 lc rgb '#555555' title 'converged, spread of a run', '' index 0 using 1:{} with "
        "lines lw 2 lc rgb 'black' title 'converged'",
        quantity == 2 ? "set key top left font ',9'" : "unset key", labels[quantity], column, column + 1,
        column, column + 1, column);
    constexpr const char* of_rows[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7"};
    for (std::size_t i = 0; i < rows.size(); ++i) {
        plot +=
            fmt::format(", '' index {} using 1:{} with lines lw 1.5 lc rgb '{}' title '{}: {}{}' noenhanced",
                        i + 1, column, of_rows[i % std::size(of_rows)], title_of(rows[i]->engine),
                        title_of(rows[i]->knob.empty() ? "" : rows[i]->knob + " "), title_of(rows[i]->value));
    }
    return plot + "\n";
}

} // namespace

bool draw_diagram(const Plan& plan, const Table& table, const std::filesystem::path& folder) {
    const std::vector<Curve> curves = curves_of(table);
    sim::write_file(folder / "diagram.dat", data_of(table, curves));
    sim::write_file(folder / "diagram.gp", script_of(plan, table, curves));
    return run_gnuplot(folder, "diagram.gp");
}

bool draw_statistics(const Plan& plan, const Table& table, std::span<const Point> points,
                     std::span<const Point> references, const std::filesystem::path& folder) {
    const std::vector<const Row*> rows = rows_over_time(table);
    std::string data = ensemble_block(plan, ensemble_of(references));
    for (const Row* row : rows) {
        const auto first = static_cast<std::size_t>(row->task);
        data += ensemble_block(plan, ensemble_of(points.subspan(first, static_cast<std::size_t>(plan.seeds))));
    }
    std::string panels = "set multiplot layout 2,2\n";
    for (int q = 0; q < statistics_count; ++q) {
        panels += panel_script(q, rows);
    }
    panels += "unset multiplot\nunset output\n";
    sim::write_file(folder / "statistics.dat", data);
    sim::write_file(
        folder / "statistics.gp",
        "set grid\nset xlabel 'time [s]'\n"
        "set terminal svg size 1000,700 font 'sans,12' background 'white'\nset output 'statistics.svg'\n" +
            panels + "set terminal pngcairo size 1000,700 font 'sans,10'\nset output 'statistics.png'\n" +
            panels);
    return run_gnuplot(folder, "statistics.gp");
}

} // namespace study
