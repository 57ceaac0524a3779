#include "render/cmd/study_page.h"

#include "render/compare/page.h"
#include "render/study/promise.h"
#include "sim/base/base64.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>

namespace cmd {

namespace fs = std::filesystem;

namespace {

/// An SVG file without its XML declaration, for the inside of a page.
std::string inline_svg(const fs::path& path) {
    if (!fs::exists(path)) {
        return {};
    }
    const std::string text = sim::read_text_file(path);
    const std::size_t begin = text.find("<svg");
    return begin == std::string::npos ? std::string() : "<figure>" + text.substr(begin) + "</figure>\n";
}

std::string cell(const std::string& text) {
    return "<td>" + diff::escape_html(text) + "</td>";
}

std::string number(double value) {
    return std::isnan(value) ? "<td class=\"number\">-</td>" : fmt::format("<td class=\"number\">{:.3g}</td>", value);
}

std::string row_html(const study::Plan& plan, const study::Row& row) {
    std::string html = fmt::format("<tr{}>", row.is_on_front ? " class=\"front\"" : "");
    html += cell(row.engine) + cell(row.knob.empty() ? "as given" : row.knob) + cell(row.value);
    if (row.status != study::Status::done) {
        return html + fmt::format("<td colspan=\"9\">{}: {}</td></tr>\n",
                                  study::status_names[static_cast<int>(row.status)],
                                  diff::escape_html(row.message));
    }
    for (const double value : {row.cost, row.error, plan.is_statistical() ? row.agree_until : row.largest,
                               row.overlap, row.energy, row.iterations, row.contacts, row.collisions,
                               100.0 * row.at_limit}) {
        html += number(value);
    }
    return html + "</tr>\n";
}

/// A row a preset and promise: promised beside reached.
std::string promises_html(const study::Plan& plan, const study::Table& table) {
    std::string html;
    for (const auto& [preset, promises] : study::preset_promises(plan, table)) {
        for (const sim::Promise& promise : promises) {
            html += "<tr>" + cell(study::preset_names[static_cast<std::size_t>(preset)]);
            html += cell(fmt::format("{}{}", promise.what, *promise.unit != '\0' ? fmt::format(" [{}]", promise.unit) : ""));
            html += number(promise.promised) + number(promise.reached);
            html += cell(study::is_kept(promise) ? "" : "missed") + "</tr>\n";
        }
    }
    return html;
}

std::string film_html(const fs::path& film) {
    if (!fs::exists(film)) {
        return {};
    }
    return "<h2>The same seconds</h2>\n<video controls loop muted src=\"data:video/mp4;base64," +
           sim::base64(sim::read_text_file(film)) + "\"></video>\n";
}

std::string truth_of(const study::Plan& plan) {
    if (plan.references.empty()) {
        return "the closed form of its motion";
    }
    const std::string runs = plan.seeds > 1 ? fmt::format(", means over {} seeds", plan.seeds) : "";
    return "a converged solution: " + plan.references.front().setting.value + runs;
}

} // namespace

void write_study_page(const study::Plan& plan, const study::Table& table, const fs::path& folder) {
    std::string rows;
    for (const study::Row& row : table.rows) {
        rows += row_html(plan, row);
    }
    const std::string page = diff::fill_page(
        "study.html",
        {{"title", diff::escape_html(plan.scene.name + ": error against cost")},
         {"subtitle", diff::escape_html(fmt::format("{}. {:.6g} s, held against {}.", plan.scene.title,
                                                    plan.duration(), truth_of(plan)))},
         {"diagram", inline_svg(folder / "diagram.svg") + inline_svg(folder / "statistics.svg")},
         {"losses", diff::escape_html(study::losses_text(plan, table))},
         {"film", film_html(folder / "film" / "film.mp4")},
         {"error_unit", plan.is_statistical() ? "-" : "m"},
         {"fourth", plan.is_statistical() ? "agrees until [s]" : "largest [m]"},
         {"promises", promises_html(plan, table)},
         {"rows", rows},
         {"program", "tumble " TUMBLE_VERSION}});
    sim::write_file(folder / "index.html", page);
}

} // namespace cmd
