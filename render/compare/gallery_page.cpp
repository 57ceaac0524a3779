#include "render/compare/gallery_page.h"

#include "render/compare/page.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <string_view>

namespace diff {

namespace {

/// A relative path as a URL.
std::string url(const std::string& path) {
    std::string text;
    for (const char c : path) {
        const auto byte = static_cast<unsigned char>(c);
        const bool is_plain =
            byte < 0x80 && (std::isalnum(byte) != 0 || std::string("/-_.~").find(c) != std::string::npos);
        text += is_plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
    }
    return text;
}

std::string link(const std::string& path, const std::string& text) {
    return fmt::format("<a href=\"{}\">{}</a>", url(path), escape_html(text));
}

/// The lines of a plot: the smallest step of 1, 2 or 5 times a power of ten that divides `range` in at most
/// `most`.
double tick_step(double range, int most) {
    const double power = std::pow(10.0, std::floor(std::log10(range / most)));
    for (const double digit : {1.0, 2.0, 5.0}) {
        if (range / (digit * power) <= most) {
            return digit * power;
        }
    }
    return 10.0 * power;
}

/// Joules with a prefix that leaves at most three digits before the point.
std::pair<double, const char*> energy_unit(double largest) {
    constexpr std::pair<double, const char*> units[] = {{1e9, "GJ"}, {1e6, "MJ"},  {1e3, "kJ"},
                                                        {1.0, "J"},  {1e-3, "mJ"}, {1e-6, "µJ"}};
    const auto* unit = std::find_if(std::begin(units), std::end(units),
                                    [largest](const auto& u) { return largest >= u.first; });
    return unit == std::end(units) ? units[5] : *unit;
}

/// Where an instant and an energy are on the plot [px], and the largest values of both.
struct PlotFrame {
    double start = 0.0;    ///< [s]
    double duration = 0.0; ///< [s]
    double least = 0.0;    ///< potential energy [J]
    double largest = 0.0;  ///< energy above the least potential one [J]

    static constexpr double width = 560, height = 200, left = 48, right = 84, top = 24, foot = 24;
    double x_of(double time) const { return left + (time - start) / duration * (width - left - right); }
    double y_of(double energy) const { return height - foot - energy / largest * (height - top - foot); }
};

PlotFrame frame_of(const std::vector<EnergySample>& samples) {
    PlotFrame frame{.start = samples.front().time, .duration = samples.back().time - samples.front().time};
    frame.least = samples.front().potential;
    for (const EnergySample& s : samples) {
        frame.least = std::min(frame.least, s.potential);
    }
    for (const EnergySample& s : samples) {
        frame.largest = std::max(frame.largest, s.kinetic + s.potential - frame.least);
    }
    return frame;
}

/// Grid and numbers.
std::string axes(const PlotFrame& frame) {
    const auto [unit, unit_name] = energy_unit(frame.largest);
    std::string svg;
    const double step = tick_step(frame.largest / unit, 4);
    for (int i = 0; i * step <= frame.largest / unit; ++i) {
        const double y = frame.y_of(i * step * unit);
        svg += fmt::format("<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
                           "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.6g}{6}</text>\n",
                           frame.left, frame.width - frame.right, y, frame.left - 6, y + 4, i * step,
                           i == 0 ? std::string(" ") + unit_name : "");
    }
    const double time_step = tick_step(frame.duration, 6);
    for (int i = 0; i * time_step <= frame.duration * (1 + 1e-9); ++i) {
        const double time = frame.start + i * time_step;
        svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{:.6g}{}</text>\n",
                           frame.x_of(time), frame.height - 6, time, i == 0 ? " s" : "");
    }
    return svg;
}

/// Kinetic, potential (above its least) and total energy over time; empty if there is nothing to draw.
std::string energy_plot(const std::vector<EnergySample>& samples) {
    if (samples.size() < 2) {
        return {};
    }
    const PlotFrame frame = frame_of(samples);
    if (!(frame.largest > 0.0) || !(frame.duration > 0.0) || !std::isfinite(frame.largest)) {
        return {};
    }
    std::string svg =
        fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"Energy over time\">\n{}",
                    frame.width, frame.height, axes(frame));
    struct Curve {
        const char* name;
        double kinetic, potential; // weights
    };
    std::vector<std::pair<double, const char*>> labels;
    for (const Curve& curve : {Curve{"potential", 0, 1}, Curve{"kinetic", 1, 0}, Curve{"total", 1, 1}}) {
        std::string points;
        double y = 0.0;
        for (const EnergySample& s : samples) {
            y = frame.y_of(curve.kinetic * s.kinetic + curve.potential * (s.potential - frame.least));
            points += fmt::format("{}{:.1f} {:.1f}", points.empty() ? "M" : "L", frame.x_of(s.time), y);
        }
        svg += fmt::format("<path class=\"{}\" d=\"{}\"/>\n", curve.name, points);
        labels.emplace_back(y, curve.name);
    }
    std::stable_sort(labels.begin(), labels.end(),
                     [](const auto& a, const auto& b) { return a.first > b.first; });
    double below =
        frame.height; // labels are 13 px apart at least, from the lowest up, so that each can be read
    for (const auto& [y, name] : labels) {
        const double place = std::min(y + 4, below - 13);
        below = place;
        svg += fmt::format("<text class=\"{0}\" x=\"{1}\" y=\"{2:.1f}\">{0}</text>\n", name,
                           frame.width - frame.right + 6, place);
    }
    return svg + "</svg>\n";
}

std::string figure(const std::string& path) {
    return fmt::format(
        "<figure><figcaption>{0}</figcaption><img src=\"{1}\" alt=\"{0}\" loading=\"lazy\"></figure>\n",
        escape_html(path), url(path));
}

std::string run_card(const GalleryRun& run) {
    std::string card = fmt::format("<article class=\"run\">\n<h2>{0}<small>{1}</small></h2>\n<div>\n",
                                   escape_html(run.name), escape_html(run.title));
    if (!run.film.empty()) {
        card += fmt::format("<video controls loop muted playsinline preload=\"{}\" src=\"{}\"{}></video>\n",
                            run.poster.empty() ? "metadata" : "none", url(run.film),
                            run.poster.empty() ? "" : fmt::format(" poster=\"{}\"", url(run.poster)));
    } else if (!run.poster.empty()) {
        card += fmt::format("<img class=\"still\" src=\"{}\" alt=\"A frame\" loading=\"lazy\">\n",
                            url(run.poster));
    }
    if (!run.film.empty() && !run.model.empty()) {
        std::string times;
        for (const double time : run.times) {
            times += fmt::format("{}{:.6g}", times.empty() ? "" : ",", time);
        }
        card += fmt::format("<button type=\"button\" data-model=\"{}\" data-times=\"[{}]\">In 3-D</button>\n",
                            escape_html(run.model), times);
    }
    card += "</div>\n<div>\n<table class=\"facts\"><tbody>\n";
    for (const auto& [name, value] : run.facts) {
        card += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", escape_html(name), escape_html(value));
    }
    card += "</tbody></table>\n";
    if (const std::string plot = energy_plot(run.energy); !plot.empty()) {
        card += "<figure class=\"plot\"><figcaption>Energy; potential above its least</figcaption>" + plot +
                "</figure>\n";
    }
    card += "</div>\n";
    if (!run.plots.empty()) {
        card += "<div class=\"links\">";
        for (const std::string& plot : run.plots) {
            card += figure(plot);
        }
        card += "</div>\n";
    }
    card += "<div class=\"links\">";
    for (const std::string& file : run.files) {
        card += link(file, file) + " ";
    }
    return card + "</div>\n</article>\n";
}

std::string count_of(std::size_t count, const char* noun) {
    return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

} // namespace

std::string model_script(const std::string& path, const std::string& bytes) {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve(bytes.size() / 3 * 4 + 64);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t three = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += i + k > bytes.size() ? '=' : letters[three >> (18 - 6 * k) & 63];
        }
    }
    return fmt::format("solid.arrived({}, \"{}\");\n", nlohmann::json(path).dump(), text);
}

std::string gallery_page(const Gallery& gallery) {
    std::string content;
    if (!gallery.reports.empty()) {
        content += "<article>\n<h2>Comparisons</h2>\n<table><tbody>\n";
        for (const GalleryReport& report : gallery.reports) {
            content +=
                fmt::format("<tr><td>{}</td><td class=\"verdict {}\">{}</td><td>{}</td></tr>\n",
                            link(report.page, report.name), report.failed > 0 ? "changed" : "identical",
                            report.failed > 0 ? fmt::format("✕ {} failed", report.failed) : "✓ passed",
                            count_of(static_cast<std::size_t>(report.cases), "case"));
        }
        content += "</tbody></table>\n</article>\n";
    }
    for (const GalleryRun& run : gallery.runs) {
        content += run_card(run);
    }
    if (!gallery.studies.empty()) {
        content += "<article>\n<h2>Studies</h2>\n";
        for (const GalleryStudy& study : gallery.studies) {
            const std::string diagram =
                study.diagram.empty() ? ""
                                      : fmt::format("<a href=\"{}\"><img src=\"{}\" alt=\"Error against cost\" "
                                                    "loading=\"lazy\"></a>",
                                                    url(study.page), url(study.diagram));
            content += fmt::format("<figure><figcaption>{}</figcaption>{}</figure>\n", link(study.page, study.name),
                                   diagram);
        }
        content += "</article>\n";
    }
    if (!gallery.plots.empty() || !gallery.texts.empty()) {
        content += "<article>\n<h2>Measurements</h2>\n";
        for (const std::string& plot : gallery.plots) {
            content += figure(plot);
        }
        for (const auto& [path, text] : gallery.texts) {
            content += fmt::format("<figure><figcaption>{}</figcaption><pre>{}</pre></figure>\n",
                                   link(path, path), escape_html(text));
        }
        content += "</article>\n";
    }
    return fill_page("gallery.html", {{"title", "tumble: results"},
                                      {"subtitle", count_of(gallery.runs.size(), "run")},
                                      {"content", content},
                                      {"program", escape_html(gallery.program)}});
}

} // namespace diff
