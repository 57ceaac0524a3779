#include "render/overlay/figure.h"

#include "render/overlay/canvas.h"
#include "render/overlay/plot.h"
#include "render/overlay/text.h"
#include "sim/base/utf8.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace render {

namespace {

using glm::dvec2;
using glm::vec2;
using glm::vec3;

constexpr float text_size = 13.0f, figure_title_size = 15.0f; // [px]
constexpr vec3 ink(0.13f), frame_color(0.45f), grid_color(0.87f);

/// What a figure is drawn of.
struct Stroke {
    std::vector<vec2> points;
    vec3 color;
    float width, dash;
};
struct Fill {
    std::vector<vec2> points;
    vec3 color;
    float alpha;
};
struct Words {
    vec2 at; ///< on the baseline
    float size;
    std::string text;
    TextAlign align;
};
struct Sheet {
    int width, height;
    std::vector<Fill> areas; ///< below all
    std::vector<Stroke> strokes;
    std::vector<Fill> marks; ///< over the strokes
    std::vector<Words> words;
};

/// Where values lie on the sheet.
struct Scale {
    double lower = 0.0, upper = 1.0; ///< of the values; their logarithms
    float from = 0.0f, to = 1.0f;    ///< [px]
    bool is_logarithmic = false;
    double tick = 1.0;

    float operator()(double value) const {
        const double x = is_logarithmic ? std::log10(value) : value;
        return from + static_cast<float>((x - lower) / (upper - lower)) * (to - from);
    }
    std::string text(double value) const {
        return is_logarithmic ? fmt::format("1e{:.0f}", value) : tick_text(value, tick);
    }
};

bool is_shown(const Chart& chart, const dvec2& p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && (!chart.x.is_logarithmic || p.x > 0.0) &&
           (!chart.y.is_logarithmic || p.y > 0.0);
}

/// The range of all points along an axis, to whole ticks.
Scale scale_of(const Chart& chart, int axis, float from, float to) {
    Scale scale{.from = from, .to = to, .is_logarithmic = (axis == 0 ? chart.x : chart.y).is_logarithmic};
    double lower = std::numeric_limits<double>::infinity(), upper = -lower;
    for (const Series& series : chart.series) {
        for (const dvec2& p : series.points) {
            if (is_shown(chart, p)) {
                const double x = scale.is_logarithmic ? std::log10(p[axis]) : p[axis];
                lower = std::min(lower, x);
                upper = std::max(upper, x);
            }
        }
    }
    if (!(lower <= upper)) {
        lower = 0.0;
        upper = 1.0;
    }
    if (scale.is_logarithmic) {
        constexpr double margin = 0.05; // of a decade: no point on the frame
        scale.lower = std::floor(lower - margin);
        scale.upper = std::ceil(upper + margin);
        scale.tick = std::max(1.0, std::ceil((scale.upper - scale.lower) / 10.0));
    } else {
        const std::array<double, 2> range = nice_range(lower, upper);
        scale.lower = range[0];
        scale.upper = range[1];
        scale.tick = tick_spacing(range, 5);
    }
    return scale;
}

/// The outline of a mark about 0, of half width 1.
std::vector<vec2> outline_of(Mark mark) {
    const auto regular = [](int corners, double turn) {
        std::vector<vec2> points;
        for (int i = 0; i < corners; ++i) {
            const double angle = 2.0 * std::numbers::pi * i / corners + turn;
            points.emplace_back(std::sin(angle), -std::cos(angle));
        }
        return points;
    };
    switch (mark) {
    case Mark::square:
        return {{-0.9f, -0.9f}, {0.9f, -0.9f}, {0.9f, 0.9f}, {-0.9f, 0.9f}};
    case Mark::up:
        return {{0.0f, -1.1f}, {1.1f, 0.9f}, {-1.1f, 0.9f}};
    case Mark::down:
        return {{0.0f, 1.1f}, {1.1f, -0.9f}, {-1.1f, -0.9f}};
    case Mark::diamond:
        return {{0.0f, -1.2f}, {1.1f, 0.0f}, {0.0f, 1.2f}, {-1.1f, 0.0f}};
    case Mark::pentagon:
        return regular(5, 0.0);
    default:
        return regular(24, 0.0);
    }
}

void add_mark(Sheet& sheet, const Series& series, const vec2& at) {
    const float size = series.mark_size;
    if (series.mark == Mark::star) {
        for (int i = 0; i < 4; ++i) {
            const double angle = std::numbers::pi * i / 4.0;
            const vec2 arm = size * vec2(std::cos(angle), std::sin(angle));
            sheet.strokes.push_back({{at - arm, at + arm}, series.color, 1.6f, 0.0f});
        }
        return;
    }
    std::vector<vec2> points = outline_of(series.mark);
    for (vec2& p : points) {
        p = at + size * p;
    }
    if (series.mark == Mark::ring) {
        points.push_back(points.front());
        sheet.strokes.push_back({points, series.color, 1.6f, 0.0f});
    } else {
        sheet.marks.push_back({points, series.color, 1.0f});
    }
}

void add_series(Sheet& sheet, const Chart& chart, const Series& series, const Scale& x, const Scale& y) {
    std::vector<vec2> line;
    for (const dvec2& p : series.points) {
        if (!is_shown(chart, p)) {
            continue;
        }
        const vec2 at(x(p.x), y(p.y));
        if (series.has_steps && !line.empty()) {
            line.emplace_back(at.x, line.back().y);
        }
        line.push_back(at);
        if (series.mark != Mark::none) {
            add_mark(sheet, series, at);
        }
    }
    if (series.is_area) {
        sheet.areas.push_back({line, series.color, 0.25f});
    } else if (series.line > 0.0f) {
        sheet.strokes.push_back({line, series.color, series.line, series.dash});
    }
}

/// Lines of the grid and numbers beside them. axis: 0 is x.
void add_ticks(Sheet& sheet, const Scale& scale, int axis, const vec2& lower, const vec2& upper) {
    const auto first = static_cast<std::int64_t>(std::ceil(scale.lower / scale.tick - 1e-9));
    const auto last = static_cast<std::int64_t>(std::floor(scale.upper / scale.tick + 1e-9));
    for (std::int64_t i = first; i <= last; ++i) {
        const double value = static_cast<double>(i) * scale.tick;
        const float at = scale.from + static_cast<float>((value - scale.lower) / (scale.upper - scale.lower)) *
                                          (scale.to - scale.from);
        if (axis == 0) {
            sheet.strokes.push_back({{{at, lower.y}, {at, upper.y}}, grid_color, 1.0f, 0.0f});
            sheet.words.push_back({{at, upper.y + 17.0f}, text_size, scale.text(value), TextAlign::center});
        } else {
            sheet.strokes.push_back({{{lower.x, at}, {upper.x, at}}, grid_color, 1.0f, 0.0f});
            sheet.words.push_back({{lower.x - 7.0f, at + 4.5f}, text_size, scale.text(value), TextAlign::right});
        }
    }
}

/// A line and a mark of each curve, and its name.
void add_key(Sheet& sheet, const Chart& chart, vec2 at) {
    for (const Series& series : chart.series) {
        if (series.title.empty()) {
            continue;
        }
        const vec2 middle = at + vec2(15.0f, -4.5f);
        if (series.is_area) {
            sheet.areas.push_back({{middle + vec2(-13.0f, -5.0f), middle + vec2(13.0f, -5.0f),
                                    middle + vec2(13.0f, 5.0f), middle + vec2(-13.0f, 5.0f)},
                                   series.color,
                                   0.25f});
        } else if (series.line > 0.0f) {
            sheet.strokes.push_back(
                {{middle - vec2(13.0f, 0.0f), middle + vec2(13.0f, 0.0f)}, series.color, series.line, series.dash});
        }
        if (series.mark != Mark::none) {
            add_mark(sheet, series, middle);
        }
        sheet.words.push_back({at + vec2(35.0f, 0.0f), text_size, series.title, TextAlign::left});
        at.y += 19.0f;
    }
}

void add_chart(Sheet& sheet, const Chart& chart, const Font& font, const vec2& corner, const vec2& size) {
    float key_width = 0.0f;
    for (const Series& series : chart.series) {
        if (chart.has_key && !series.title.empty()) {
            key_width = std::max(key_width, font.width(series.title, text_size) + 48.0f);
        }
    }
    key_width = std::min(key_width, 0.5f * size.x);
    const vec2 lower = corner + vec2(66.0f, chart.title.empty() ? 30.0f : 52.0f);
    const vec2 upper = corner + size - vec2(18.0f + key_width, 46.0f);
    const Scale x = scale_of(chart, 0, lower.x, upper.x), y = scale_of(chart, 1, upper.y, lower.y);
    add_ticks(sheet, x, 0, lower, upper);
    add_ticks(sheet, y, 1, lower, upper);
    sheet.strokes.push_back({{lower, {upper.x, lower.y}, upper, {lower.x, upper.y}, lower}, frame_color, 1.0f, 0.0f});
    for (const Series& series : chart.series) {
        add_series(sheet, chart, series, x, y);
    }
    for (const PointLabel& label : chart.labels) {
        if (is_shown(chart, label.at)) {
            sheet.words.push_back({{x(label.at.x), y(label.at.y) - 11.0f}, text_size, label.text, TextAlign::center});
        }
    }
    if (!chart.title.empty()) {
        sheet.words.push_back({corner + vec2(10.0f, 22.0f), figure_title_size, chart.title, TextAlign::left});
    }
    sheet.words.push_back({{corner.x + 10.0f, lower.y - 10.0f}, text_size, chart.y.label, TextAlign::left});
    sheet.words.push_back({{0.5f * (lower.x + upper.x), upper.y + 37.0f}, text_size, chart.x.label, TextAlign::center});
    if (chart.has_key) {
        add_key(sheet, chart, {upper.x + 14.0f, lower.y + 12.0f});
    }
}

Sheet sheet_of(const Figure& figure, const Font& font) {
    Sheet sheet{figure.width, figure.height, {}, {}, {}, {}};
    const auto count = static_cast<int>(figure.charts.size());
    const int rows = (count + figure.columns - 1) / figure.columns;
    const vec2 size(static_cast<float>(figure.width) / static_cast<float>(figure.columns),
                    static_cast<float>(figure.height) / static_cast<float>(std::max(1, rows)));
    for (int i = 0; i < count; ++i) {
        const int row = i / figure.columns;
        const vec2 corner(static_cast<float>(i % figure.columns) * size.x, static_cast<float>(row) * size.y);
        add_chart(sheet, figure.charts[static_cast<std::size_t>(i)], font, corner, size);
    }
    return sheet;
}

std::string svg_color(const vec3& color) {
    const auto level = [](float x) { return static_cast<int>(std::lround(255.0f * x)); };
    return fmt::format("#{:02x}{:02x}{:02x}", level(color.r), level(color.g), level(color.b));
}

std::string svg_points(const std::vector<vec2>& points) {
    std::string text;
    for (const vec2& p : points) {
        text += fmt::format("{}{:.2f},{:.2f}", text.empty() ? "" : " ", p.x, p.y);
    }
    return text;
}

/// For text in XML: what it cannot hold is a question mark.
std::string xml_text(const std::string& text) {
    std::string result;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t length = sim::utf8_length(std::string_view(text).substr(i));
        const char c = text[i];
        result += c == '&'                                              ? "&amp;"
                  : c == '<'                                            ? "&lt;"
                  : c == '>'                                            ? "&gt;"
                  : length == 0 || static_cast<unsigned char>(c) < 0x20 ? "?"
                                                                        : text.substr(i, length);
        i += std::max<std::size_t>(1, length);
    }
    return result;
}

std::string svg_fill(const Fill& fill) {
    return fmt::format("<polygon points=\"{}\" fill=\"{}\" fill-opacity=\"{}\"/>\n", svg_points(fill.points),
                       svg_color(fill.color), fill.alpha);
}

/// Fills a polygon: each pixel by the share of four lines through it that lies inside, to a 255th.
void fill_polygon(Canvas& canvas, const Fill& fill) {
    constexpr int lines = 4; // a pixel
    vec2 lower(static_cast<float>(canvas.width()), static_cast<float>(canvas.height())), upper(0.0f);
    for (const vec2& p : fill.points) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    const int x0 = std::max(0, static_cast<int>(lower.x)), y0 = std::max(0, static_cast<int>(lower.y));
    const int width = std::min(canvas.width(), static_cast<int>(upper.x) + 2) - x0;
    const int height = std::min(canvas.height(), static_cast<int>(upper.y) + 2) - y0;
    if (width <= 0 || height <= 0) {
        return;
    }
    std::vector<float> share(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0.0f);
    for (int line = 0; line < lines * height; ++line) {
        const float y = static_cast<float>(y0) + (static_cast<float>(line) + 0.5f) / lines;
        std::vector<float> cuts;
        for (std::size_t i = 0; i < fill.points.size(); ++i) {
            const vec2& a = fill.points[i];
            const vec2& b = fill.points[(i + 1) % fill.points.size()];
            if ((a.y <= y) != (b.y <= y)) {
                cuts.push_back(a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x) - static_cast<float>(x0));
            }
        }
        std::sort(cuts.begin(), cuts.end());
        float* row = share.data() + static_cast<std::ptrdiff_t>(line / lines) * width;
        for (std::size_t i = 0; i + 1 < cuts.size(); i += 2) {
            for (int x = std::max(0, static_cast<int>(cuts[i])); x < width && static_cast<float>(x) < cuts[i + 1];
                 ++x) {
                const auto left = static_cast<float>(x);
                row[x] += std::max(0.0f, std::min(cuts[i + 1], left + 1.0f) - std::max(cuts[i], left)) / lines;
            }
        }
    }
    std::vector<std::uint8_t> coverage(share.size());
    std::transform(share.begin(), share.end(), coverage.begin(),
                   [](float s) { return static_cast<std::uint8_t>(std::lround(255.0f * std::min(1.0f, s))); });
    canvas.mask({x0, y0, width, height, coverage}, {fill.color, fill.alpha});
}

} // namespace

std::string figure_svg(const Figure& figure) {
    const Sheet sheet = sheet_of(figure, Font());
    std::string svg = fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" "
                                  "viewBox=\"0 0 {0} {1}\" font-family=\"Roboto, sans-serif\">\n"
                                  "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n",
                                  sheet.width, sheet.height);
    for (const Fill& fill : sheet.areas) {
        svg += svg_fill(fill);
    }
    for (const Stroke& stroke : sheet.strokes) {
        const std::string dash = stroke.dash > 0.0f ? fmt::format(" stroke-dasharray=\"{}\"", stroke.dash) : "";
        svg += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{}/>\n",
                           svg_points(stroke.points), svg_color(stroke.color), stroke.width, dash);
    }
    for (const Fill& fill : sheet.marks) {
        svg += svg_fill(fill);
    }
    constexpr std::array<const char*, 3> anchors{"start", "middle", "end"};
    for (const Words& words : sheet.words) {
        svg +=
            fmt::format("<text x=\"{:.2f}\" y=\"{:.2f}\" font-size=\"{}\" text-anchor=\"{}\" fill=\"{}\">{}</text>\n",
                        words.at.x, words.at.y, words.size, anchors[static_cast<std::size_t>(words.align)],
                        svg_color(ink), xml_text(words.text));
    }
    return svg + "</svg>\n";
}

Image figure_image(const Figure& figure) {
    Font font;
    const Sheet sheet = sheet_of(figure, font);
    Image image(sheet.width, sheet.height);
    std::fill(image.rgb.begin(), image.rgb.end(), std::uint8_t{255});
    Canvas canvas(image);
    for (const Fill& fill : sheet.areas) {
        fill_polygon(canvas, fill);
    }
    for (const Stroke& stroke : sheet.strokes) {
        canvas.stroke(stroke.points, {{stroke.color, 1.0f}, stroke.width, stroke.dash});
    }
    for (const Fill& fill : sheet.marks) {
        fill_polygon(canvas, fill);
    }
    for (const Words& words : sheet.words) {
        font.draw(canvas, words.at, words.text, {words.size, {ink, 1.0f}, words.align});
    }
    return image;
}

} // namespace render
