#include "render/overlay/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace render {

namespace {

/// Distances in a plot, in 1/720 of the picture's height.
constexpr float margin = 12.0f;
constexpr float plot_title_size = 15.0f;
constexpr float plot_label_size = 12.5f;
constexpr float curve_width = 2.6f;
/// Names of curves are written no closer than this.
constexpr float name_spacing = 14.5f;

std::string with_minus(std::string text) {
    if (text.starts_with('-')) {
        text.replace(0, 1, "\u2212");
    }
    return text;
}

/// The part of a plot inside its axes.
struct Axes {
    glm::vec2 lower; ///< [px] top left
    glm::vec2 upper; ///< [px] bottom right
    double duration;
    std::array<double, 2> range;
    double tick; ///< between ticks of the value axis

    glm::vec2 place(const CurvePoint& point) const {
        const double x = point.time / duration;
        const double y = (point.value - range[0]) / (range[1] - range[0]);
        return {lower.x + (upper.x - lower.x) * static_cast<float>(std::clamp(x, 0.0, 1.0)),
                upper.y - (upper.y - lower.y) * static_cast<float>(std::clamp(y, 0.0, 1.0))};
    }
    std::vector<glm::vec2> place(const Curve& curve) const {
        std::vector<glm::vec2> points;
        for (const CurvePoint& point : curve) {
            points.push_back(place(point));
        }
        return points;
    }
};

void draw_axes(Canvas& canvas, Font& font, const Axes& axes, float scale) {
    const Pen grid{{{1.0f, 1.0f, 1.0f}, 0.16f}, scale, 0.0f};
    const float size = plot_label_size * scale;
    const float drop = 0.5f * Font::digit_height(size);
    const double rise = axes.tick;
    for (double k = std::ceil(axes.range[0] / rise - 1e-9); k * rise <= axes.range[1] + 1e-9 * rise; ++k) {
        const glm::vec2 left = axes.place({0.0, k * rise});
        canvas.stroke(std::array{left, glm::vec2(axes.upper.x, left.y)}, grid);
        font.draw(canvas, left + glm::vec2(-6.0f * scale, drop), tick_text(k * rise, rise),
                  {size, dim_paint(), TextAlign::right});
    }
    const double step = tick_spacing({0.0, axes.duration}, 6);
    for (double k = 0.0; k * step <= axes.duration * (1.0 + 1e-9); ++k) {
        const glm::vec2 bottom = axes.place({k * step, axes.range[0]});
        const bool is_last = (k + 1.0) * step > axes.duration * (1.0 + 1e-9);
        font.draw(canvas, bottom + glm::vec2(0.0f, 6.0f * scale + 2.0f * drop),
                  tick_text(k * step, step) + (is_last ? " s" : ""), {size, dim_paint(), TextAlign::center});
    }
}

/// The curves' names to the right of the axes, each near the end of its curve and clear of the others.
void draw_names(Canvas& canvas, Font& font, const PlotPicture& plot, const Axes& axes, float scale) {
    std::vector<std::pair<float, const PlotCurve*>> names;
    for (const PlotCurve& curve : plot.curves) {
        if (!curve.points.empty() && !curve.name.empty()) {
            names.emplace_back(axes.place(curve.points.back()).y, &curve);
        }
    }
    std::ranges::stable_sort(names, {}, &std::pair<float, const PlotCurve*>::first);
    const float spacing = name_spacing * scale;
    float lowest = axes.lower.y;
    for (std::size_t i = 0; i < names.size(); ++i) {
        names[i].first = std::max(names[i].first, lowest);
        lowest = names[i].first + spacing;
    }
    float highest = axes.upper.y;
    for (std::size_t i = names.size(); i-- > 0;) {
        names[i].first = std::min(names[i].first, highest);
        highest = names[i].first - spacing;
    }
    const float size = plot_label_size * scale;
    for (const auto& [y, curve] : names) {
        font.draw(canvas, {axes.upper.x + 9.0f * scale, y + 0.5f * Font::digit_height(size)}, curve->name,
                  {size, {curve->color, 1.0f}});
    }
}

} // namespace

Paint panel_paint() {
    return {{0.045f, 0.06f, 0.085f}, 0.74f};
}
Paint text_paint() {
    return {{0.97f, 0.98f, 1.0f}, 1.0f};
}
Paint dim_paint() {
    return {{0.74f, 0.78f, 0.84f}, 1.0f};
}

double tick_spacing(const std::array<double, 2>& range, int count) {
    const double rough = std::max(range[1] - range[0], 1e-300) / count;
    const double power = std::pow(10.0, std::floor(std::log10(rough)));
    for (const double step : {1.0, 2.0, 5.0}) {
        if (step * power >= rough * (1.0 - 1e-9)) {
            return step * power;
        }
    }
    return 10.0 * power;
}

std::array<double, 2> nice_range(double lower, double upper) {
    if (!(upper - lower > 1e-9 * std::max(std::abs(lower), std::abs(upper)))) {
        const double half = std::max(0.1 * std::abs(lower), 1e-9);
        lower -= half;
        upper += half;
    }
    const double step = tick_spacing({lower, upper}, 4);
    return {std::floor(lower / step + 1e-9) * step, std::ceil(upper / step - 1e-9) * step};
}

std::string tick_text(double value, double spacing) {
    if (spacing >= 1e5 || spacing < 1e-4) {
        return with_minus(value == 0.0 ? "0" : fmt::format("{:.3g}", value));
    }
    const int digits = std::max(0, static_cast<int>(std::ceil(-std::log10(spacing) - 1e-9)));
    const std::string text = fmt::format("{:.{}f}", std::abs(value) < 1e-9 * spacing ? 0.0 : value, digits);
    return with_minus(text);
}

void draw_plot(Canvas& canvas, Font& font, const PlotPicture& plot, const PlotPlace& place) {
    const auto& [lower, upper, scale] = place;
    canvas.panel(lower, upper, 8.0f * scale, panel_paint());
    const float size = plot_label_size * scale;
    const double rise = plot.tick > 0.0 ? plot.tick : tick_spacing(plot.range, 4);
    float left = 0.0f;
    for (double k = std::ceil(plot.range[0] / rise - 1e-9); k * rise <= plot.range[1] + 1e-9 * rise; ++k) {
        left = std::max(left, font.width(tick_text(k * rise, rise), size));
    }
    float right = 0.0f;
    for (const PlotCurve& curve : plot.curves) {
        right = std::max(right, font.width(curve.name, size));
    }
    const float border = margin * scale;
    const Axes axes{{lower.x + border + left + 6.0f * scale, lower.y + border + 1.9f * plot_title_size * scale},
                    {upper.x - border - (right > 0.0f ? right + 6.0f * scale : 4.0f * scale),
                     upper.y - border - 1.25f * size},
                    plot.duration,
                    plot.range,
                    rise};
    const float baseline = lower.y + border + Font::digit_height(plot_title_size * scale);
    font.draw(canvas, {lower.x + border, baseline}, plot.title, {plot_title_size * scale, text_paint()});
    font.draw(canvas, {lower.x + border + font.width(plot.title + "  ", plot_title_size * scale), baseline}, plot.unit,
              {plot_title_size * scale, dim_paint()});
    draw_axes(canvas, font, axes, scale);
    font.draw(canvas, {upper.x - border, baseline}, plot.note, {size, dim_paint(), TextAlign::right});
    for (const PlotCurve& curve : plot.curves) {
        canvas.stroke(axes.place(curve.points), {{curve.color, 1.0f}, curve_width * scale, 0.0f});
    }
    // Over the curves: where both agree, both are seen.
    for (const PlotCurve& curve : plot.curves) {
        canvas.stroke(axes.place(curve.reference), {{{1.0f, 1.0f, 1.0f}, 0.85f}, 1.1f * scale, 4.0f * scale});
    }
    for (const PlotCurve& curve : plot.curves) {
        if (!curve.points.empty()) {
            canvas.disc(axes.place(curve.points.back()), 3.4f * scale, {curve.color, 1.0f});
        }
    }
    draw_names(canvas, font, plot, axes, scale);
}

} // namespace render
