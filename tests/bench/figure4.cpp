#include "tests/bench/figure4.h"

#include "render/overlay/figure.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

namespace bench {

namespace {

/// One phase: what it solved in each step, and the time it took [ms].
struct Phase {
    std::string what; ///< "collision"
    double paper;     ///< [ms] each, on a 3.4 GHz Pentium 4
    std::vector<glm::dvec2> points{};

    /// Least squares through the origin [ms] each.
    double each() const {
        double xy = 0.0, xx = 0.0;
        for (const glm::dvec2& p : points) {
            xy += p.x * p.y;
            xx += p.x * p.x;
        }
        return xx > 0.0 ? xy / xx : 0.0;
    }
};

render::Chart chart_of(const Phase& phase) {
    double most = 0.0, longest = 0.0;
    for (const glm::dvec2& p : phase.points) {
        most = std::max(most, p.x);
        longest = std::max(longest, p.y);
    }
    const auto line = [&](const std::string& title, double each, const glm::vec3& color, float dash) {
        const double end = each > 0.0 ? std::min(most, 1.2 * longest / each) : most;
        return render::Series{
            .title = title, .color = color, .points = {{0.0, 0.0}, {end, each * end}}, .line = 2.0f, .dash = dash};
    };
    render::Chart chart;
    chart.title = phase.what + " phase";
    chart.x.label = phase.what + "s in the step";
    chart.y.label = "time of the phase [ms]";
    chart.series = {{.title = "a step",
                     .color = {0.13f, 0.45f, 0.65f},
                     .points = phase.points,
                     .line = 0.0f,
                     .mark = render::Mark::disc,
                     .mark_size = 1.2f},
                    line(fmt::format("{:.3g} ms each", phase.each()), phase.each(), {0.78f, 0.06f, 0.18f}, 0.0f),
                    line(fmt::format("the paper: {} ms", phase.paper), phase.paper, glm::vec3(0.0f), 5.0f)};
    return chart;
}

} // namespace

void write_figure4(std::span<const StepCounts> steps, const std::filesystem::path& folder) {
    Phase collision{"collision", 0.075}, contact{"contact", 0.015};
    for (const StepCounts& step : steps) {
        if (step.collisions > 0) {
            collision.points.emplace_back(step.collisions, step.collisions_ms);
        }
        if (step.contacts > 0) {
            contact.points.emplace_back(step.contacts, step.contacts_ms);
        }
    }
    const render::Figure figure{
        .width = 1200, .height = 440, .columns = 2, .charts = {chart_of(collision), chart_of(contact)}};
    const std::string text =
        fmt::format("collision phase: {:.5f} ms a collision  (the paper: {} on a 3.4 GHz Pentium 4)\n"
                    "contact phase:   {:.5f} ms a contact    (the paper: {})\n",
                    collision.each(), collision.paper, contact.each(), contact.paper);
    sim::write_file(folder / "figure4.svg", render::figure_svg(figure));
    sim::write_file(folder / "figure4.png", render::encode_png(render::figure_image(figure)));
    sim::write_file(folder / "figure4.txt", text);
    std::fputs(text.c_str(), stdout);
}

} // namespace bench
