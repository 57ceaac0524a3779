#include "render/overlay/overlay.h"

#include "render/overlay/closed_form.h"
#include "render/overlay/palette.h"
#include "render/overlay/plot.h"
#include "sim/base/error.h"
#include "sim/model/film_clock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace render {

namespace {

using sim::Shown;

/// Pictures smaller than this [px] have text as large as one of this height.
constexpr float least_height = 320.0f;
/// Sizes in 1/720 of the picture's height, or of its width where that is less.
constexpr float edge = 18.0f;
constexpr float padding = 14.0f;
constexpr float title_size = 20.0f;
constexpr float value_size = 15.0f;
constexpr float label_size = 12.5f;
constexpr float caption_size = 24.0f;
constexpr float large_caption_size = 40.0f;
constexpr glm::vec3 card_color{0.055f, 0.07f, 0.1f};
constexpr glm::vec2 plot_size(372.0f, 214.0f);

/// "12.4 MJ": three digits, a prefix from the magnitude of `largest`.
std::string energy_text(double joule) {
    constexpr const char* prefixes[] = {"n", "\u03bc", "m", "", "k", "M", "G"};
    int power = 0;
    double value = std::abs(joule);
    while (value >= 999.5 && power < 3) {
        value /= 1000.0;
        ++power;
    }
    while (value < 0.9995 && value > 0.0 && power > -3) {
        value *= 1000.0;
        --power;
    }
    const int digits = value >= 99.95 ? 0 : value >= 9.995 ? 1 : 2;
    const bool is_zero = joule == 0.0 || value < 0.005;
    return fmt::format("{}{:.{}f} {}J", joule < 0.0 && !is_zero ? "\u2212" : "", is_zero ? 0.0 : value,
                       digits, is_zero ? "" : prefixes[power + 3]);
}

/// 12345 -> "12 345".
std::string count_text(std::int64_t count) {
    const std::string digits = std::to_string(count);
    std::string text;
    for (std::size_t i = 0; i < digits.size(); ++i) {
        const bool is_gap = i > 0 && (digits.size() - i) % 3 == 0;
        text += is_gap ? fmt::format(" {}", digits[i]) : fmt::format("{}", digits[i]);
    }
    return text;
}

} // namespace

Overlay::Overlay(const sim::SceneDef& scene)
    : scene_(scene), colors_(scene), world_(scene),
      has_text_((scene.overlay.shows(Shown::title) && !scene.title.empty()) ||
                scene.overlay.shows(Shown::time) || scene.overlay.shows(Shown::contacts) ||
                scene.overlay.shows(Shown::energy)),
      has_plots_(scene.overlay.shows(Shown::plots) && !scene.plots.empty()) {}

void check_overlay(const sim::SceneDef& scene) {
    try {
        if (!scene.overlay.logo.empty()) {
            decode_png(scene.overlay.logo);
        }
    } catch (const sim::Error& error) {
        throw sim::Error(error.code(), fmt::format("{}: overlay: logo: {}", scene.name, error.what()));
    }
    const Font font;
    const auto check = [&](const std::string& text, const std::string& where) {
        if (const std::string letter = font.missing_letter(text); !letter.empty()) {
            throw sim::Error(sim::ExitCode::usage,
                             fmt::format("{}: {}: the font lacks {}, expected Latin, Cyrillic, or Greek without accents",
                                         scene.name, where, letter));
        }
    };
    if (scene.overlay.shows(Shown::title)) {
        check(scene.title, "title");
    }
    for (std::size_t i = 0; i < scene.captions.size(); ++i) {
        check(scene.captions[i].text, fmt::format("caption {}", i));
    }
    for (std::size_t i = 0; i < scene.plots.size() && scene.overlay.shows(Shown::plots); ++i) {
        check(scene.plots[i].title, fmt::format("plot {}", i));
        for (const int body : scene.plots[i].bodies) {
            check(scene.bodies[static_cast<std::size_t>(body)].name, fmt::format("plot {}", i));
        }
    }
}

void Overlay::draw(Image& image, const Moment& moment) {
    scale_ = std::max(static_cast<float>(std::min(image.width, image.height)), least_height) / 720.0f;
    text_end_ = glm::vec2(0.0f);
    Canvas canvas(image);
    fit_logo(std::min(image.width, image.height));
    if (needs_depth()) {
        world_.draw(canvas, moment.snapshot, moment.notes, moment.depth, scale_);
    }
    draw_text(canvas, moment.snapshot);
    draw_plots(canvas, moment.snapshot, moment.notes);
    draw_color_legend(canvas);
    draw_contact_legend(canvas);
    for (const sim::CaptionDef& caption : scene_.captions) {
        draw_caption(canvas, caption, moment.film_time);
    }
    draw_logo(canvas);
}

/// As high as a picture of this height or width [px] needs it.
void Overlay::fit_logo(int picture_size) {
    const int height = std::max(1, static_cast<int>(std::lround(scene_.overlay.logo_height * picture_size)));
    if (!scene_.overlay.logo.empty() && logo_.height != height) {
        logo_ = resized(decode_png(scene_.overlay.logo), height);
    }
}

void Overlay::draw_logo(Canvas& canvas) const {
    const sim::LogoCorner at = scene_.overlay.logo_at;
    const int space = static_cast<int>(std::lround(edge * scale_));
    const bool is_left = at == sim::LogoCorner::top_left || at == sim::LogoCorner::bottom_left;
    const bool is_top = at == sim::LogoCorner::top_left || at == sim::LogoCorner::top_right;
    canvas.picture(is_left ? space : canvas.width() - space - logo_.width,
                   is_top ? space : canvas.height() - space - logo_.height, logo_);
}

float Overlay::beside_logo(sim::LogoCorner corner) const {
    return logo_.width > 0 && scene_.overlay.logo_at == corner ? static_cast<float>(logo_.width) + edge * scale_ : 0.0f;
}

float Overlay::top_from(float left) const {
    return text_end_.x < left ? edge * scale_ : text_end_.y + padding * scale_;
}

void Overlay::draw_caption(Canvas& canvas, const sim::CaptionDef& caption, double film_time) {
    const double left = caption.time + caption.duration - film_time;
    if (film_time < caption.time || left <= 0.0) {
        return;
    }
    // What the film begins with is there at once.
    const double from_ends = caption.time > 0.0 ? std::min(film_time - caption.time, left) : left;
    const double shown = from_ends < caption.fade ? from_ends / caption.fade : 1.0;
    const auto faded = [&](Paint paint) {
        paint.alpha *= static_cast<float>(shown);
        return paint;
    };
    const bool is_card = caption.place == sim::CaptionPlace::card;
    const bool is_large = is_card || caption.place == sim::CaptionPlace::middle;
    const glm::vec2 picture(static_cast<float>(canvas.width()), static_cast<float>(canvas.height()));
    const float size = (is_large ? large_caption_size : caption_size) * scale_;
    const float widest = picture.x - 2.0f * (edge + padding) * scale_;
    const std::vector<std::string> lines = font_.lines(caption.text, size, widest);
    float width = 0.0f;
    for (const std::string& line : lines) {
        width = std::max(width, font_.width(line, size));
    }
    const float row = 1.35f * size;
    const float height = row * static_cast<float>(lines.size() - 1) + Font::digit_height(size);
    glm::vec2 top(0.5f * picture.x, 0.5f * (picture.y - height));
    if (caption.place == sim::CaptionPlace::bottom) {
        top.y = picture.y - (edge + padding) * scale_ - height;
    } else if (caption.place == sim::CaptionPlace::top) {
        top.y = std::max((edge + padding) * scale_, text_end_.y + 2.0f * padding * scale_);
    }
    if (is_card) {
        canvas.panel({0.0f, 0.0f}, picture, 0.0f, faded({card_color, 1.0f}));
    } else {
        const glm::vec2 half(0.5f * width + padding * scale_, padding * scale_);
        canvas.panel({top.x - half.x, top.y - half.y}, {top.x + half.x, top.y + height + half.y}, 8.0f * scale_,
                     faded(panel_paint()));
    }
    float baseline = top.y + Font::digit_height(size);
    for (const std::string& line : lines) {
        font_.draw(canvas, {top.x, baseline}, line, {size, faded(text_paint()), TextAlign::center});
        baseline += row;
    }
}

namespace {

/// One of the numbers in a row. One after the other, each as wide as it may become: numbers that change do not shift the
/// others.
struct Value {
    const char* label;
    std::string text;
    const char* widest;
};

std::vector<Value> shown_values(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    std::vector<Value> values;
    if (scene.overlay.shows(Shown::time)) {
        values.push_back({"time", fmt::format("{:.2f} s", snapshot.time), "00.00 s"});
    }
    if (scene.overlay.shows(Shown::contacts)) {
        values.push_back({"contacts", count_text(snapshot.contact_count), "0 000"});
    }
    if (scene.overlay.shows(Shown::energy)) {
        const Energies now = energies(scene, snapshot);
        values.push_back({"kinetic", energy_text(now.kinetic), "0.00 MJ"});
        values.push_back({"potential", energy_text(now.potential), "0.00 MJ"});
    }
    return values;
}

} // namespace

void Overlay::draw_text(Canvas& canvas, const sim::Snapshot& snapshot) {
    if (!has_text_) {
        return;
    }
    const std::vector<Value> values = shown_values(scene_, snapshot);
    const bool has_title = scene_.overlay.shows(Shown::title) && !scene_.title.empty();
    const float label_gap = 7.0f * scale_;
    const float value_gap = 20.0f * scale_;
    const float size = value_size * scale_;
    const auto width_of = [&](const Value& value) {
        return font_.width(value.label, size) + label_gap +
               std::max(font_.width(value.widest, size), font_.width(value.text, size));
    };
    float row = 0.0f;
    for (const Value& value : values) {
        row += (row > 0.0f ? value_gap : 0.0f) + width_of(value);
    }
    const float title_em = title_size * scale_;
    const float after_logo = beside_logo(sim::LogoCorner::top_left);
    const float widest = static_cast<float>(canvas.width()) - 2.0f * (edge + padding) * scale_ - after_logo -
                         beside_logo(sim::LogoCorner::top_right);
    const std::vector<std::string> title =
        has_title ? font_.lines(scene_.title, title_em, widest) : std::vector<std::string>{};
    float title_width = 0.0f;
    for (const std::string& line : title) {
        title_width = std::max(title_width, font_.width(line, title_em));
    }
    const float title_row = 1.3f * title_em;
    const float title_height =
        has_title ? Font::digit_height(title_em) + title_row * static_cast<float>(title.size() - 1) : 0.0f;
    const float row_height = values.empty() ? 0.0f : Font::digit_height(size);
    const float between = has_title && !values.empty() ? 13.0f * scale_ : 0.0f;
    const float inset = padding * scale_;
    const glm::vec2 lower(edge * scale_ + after_logo, edge * scale_);
    const glm::vec2 upper =
        lower + 2.0f * inset + glm::vec2(std::max(title_width, row), title_height + between + row_height);
    canvas.panel(lower, upper, 8.0f * scale_, panel_paint());
    text_end_ = upper;
    glm::vec2 at = lower + inset;
    for (std::size_t i = 0; i < title.size(); ++i) {
        const float baseline = at.y + Font::digit_height(title_em) + title_row * static_cast<float>(i);
        font_.draw(canvas, {at.x, baseline}, title[i], {title_em, text_paint()});
    }
    at.y += title_height + between + row_height;
    for (const Value& value : values) {
        font_.draw(canvas, at, value.label, {size, dim_paint()});
        font_.draw(canvas, at + glm::vec2(font_.width(value.label, size) + label_gap, 0.0f), value.text,
                   {size, text_paint()});
        at.x += width_of(value) + value_gap;
    }
}

namespace {

/// Title, unit and names of a plot's curves.
PlotPicture describe_plot(const sim::SceneDef& scene, const sim::PlotDef& plot) {
    PlotPicture picture;
    picture.duration = sim::simulated_duration(scene.output);
    const auto name = [&](const char* title, const char* unit) {
        picture.title = plot.title.empty() ? title : plot.title;
        picture.unit = unit;
    };
    switch (plot.quantity) {
    case sim::PlotQuantity::energy:
        name("energy", "J");
        picture.curves = {{"kinetic", category_color(0), {}, {}},
                          {"potential", category_color(1), {}, {}},
                          {"sum", {0.97f, 0.98f, 1.0f}, {}, {}}};
        break;
    case sim::PlotQuantity::contacts:
        name("contacts", "");
        picture.curves = {{"", category_color(1), {}, {}}};
        break;
    case sim::PlotQuantity::inclination:
        name("inclination", "degrees");
        picture.tick = 45.0;
        break;
    case sim::PlotQuantity::distance:
        name("distance", "m");
        break;
    }
    for (const int index : plot.bodies) {
        const sim::BodyDef& body = scene.bodies[static_cast<std::size_t>(index)];
        picture.curves.push_back({plot.bodies.size() > 1 ? body.name : "", panel_color(body), {}, {}});
    }
    return picture;
}

/// The closed form over the film's length, or to the end of the incline.
Curve reference_curve(const sim::SceneDef& scene, int body, int incline) {
    constexpr int count = 240;
    const SlidingBlock block = sliding_block(scene, body, incline);
    Curve curve;
    for (int i = 0; i <= count; ++i) {
        const double t = sim::simulated_duration(scene.output) * i / count;
        const double distance = block.distance(t);
        if (distance > block.end) {
            break;
        }
        curve.push_back({t, distance});
    }
    return curve;
}

/// The plot's own range, or one that holds its values so far.
std::array<double, 2> value_range(const sim::PlotDef& plot, const PlotPicture& picture) {
    if (plot.range) {
        return *plot.range;
    }
    double lower = 0.0;
    double upper = 0.0;
    for (const PlotCurve& curve : picture.curves) {
        for (const Curve* points : {&curve.points, &curve.reference}) {
            for (const CurvePoint& point : *points) {
                lower = std::min(lower, point.value);
                upper = std::max(upper, point.value);
            }
        }
    }
    return nice_range(lower, upper);
}

} // namespace

void Overlay::draw_plots(Canvas& canvas, const sim::Snapshot& snapshot, const Notes& notes) {
    if (!has_plots_) {
        return;
    }
    const glm::vec2 size = plot_size * scale_;
    const bool is_at_top = scene_.overlay.plots_at == sim::PlotCorner::top_right;
    const float before_logo = beside_logo(is_at_top ? sim::LogoCorner::top_right : sim::LogoCorner::bottom_right);
    glm::vec2 lower = glm::vec2(canvas.width(), canvas.height()) - edge * scale_ - size;
    lower.x -= before_logo;
    lower.y = is_at_top ? top_from(lower.x) : lower.y;
    for (std::size_t i = 0; i < scene_.plots.size() && i < notes.plots.size(); ++i) {
        const sim::PlotDef& plot = scene_.plots[i];
        PlotPicture picture = describe_plot(scene_, plot);
        const std::vector<double> now = plot_values(scene_, plot, snapshot);
        for (std::size_t k = 0; k < picture.curves.size(); ++k) {
            picture.curves[k].points = notes.plots[i][k];
            if (plot.closed_form_on >= 0) {
                picture.note = "dashed: closed form";
                picture.curves[k].reference = reference_curve(scene_, plot.bodies[k], plot.closed_form_on);
            }
        }
        picture.range = value_range(plot, picture);
        draw_plot(canvas, font_, picture, {lower, lower + size, scale_});
        lower.y += (is_at_top ? 1.0f : -1.0f) * (size.y + 10.0f * scale_);
    }
}

void Overlay::draw_color_legend(Canvas& canvas) {
    if (!colors_.is_needed() || (!colors_.is_scale() && colors_.entries().empty())) {
        return;
    }
    const float size = label_size * scale_;
    const float line = 1.6f * size;
    glm::vec2 content(std::round(240.0f * scale_), std::round(10.0f * scale_) + 2.5f * size);
    if (!colors_.is_scale()) {
        content = {0.0f, static_cast<float>(colors_.entries().size()) * line - 0.7f * size};
        for (const LegendEntry& entry : colors_.entries()) {
            content.x = std::max(content.x, font_.width(entry.text, size) + 1.6f * size);
        }
    }
    // At the right, where the plots are not.
    const float inset = padding * scale_;
    const glm::vec2 outer = content + 2.0f * inset;
    const bool is_below = has_plots_ && scene_.overlay.plots_at == sim::PlotCorner::top_right;
    const float before_logo = beside_logo(is_below ? sim::LogoCorner::bottom_right : sim::LogoCorner::top_right);
    const glm::vec2 far(static_cast<float>(canvas.width()) - edge * scale_ - before_logo - outer.x,
                        static_cast<float>(canvas.height()) - edge * scale_ - outer.y);
    const glm::vec2 lower = glm::round(glm::vec2(far.x, is_below ? far.y : top_from(far.x)));
    canvas.panel(lower, lower + outer, 8.0f * scale_, panel_paint());
    if (colors_.is_scale()) {
        draw_scale(canvas, glm::round(lower + inset), content.x);
        return;
    }
    glm::vec2 at = lower + inset;
    for (const LegendEntry& entry : colors_.entries()) {
        canvas.disc(at + 0.4f * size, 0.45f * size, {entry.color, 1.0f});
        font_.draw(canvas, at + glm::vec2(1.6f * size, 0.76f * size), entry.text, {size, text_paint()});
        at.y += line;
    }
}

/// The title, the bar of colours `width` [px] wide, and its numbers.
void Overlay::draw_scale(Canvas& canvas, const glm::vec2& at, float width) {
    const float size = label_size * scale_;
    const std::array<double, 2>& range = colors_.range();
    const double spacing = tick_spacing(range, 4);
    font_.draw(canvas, at + glm::vec2(0.0f, Font::digit_height(size)), colors_.title(), {size, text_paint()});
    const float top = at.y + std::round(1.35f * size);
    const float bottom = top + std::round(10.0f * scale_);
    for (float x = 0.0f; x < width; x += 1.0f) {
        canvas.panel({at.x + x, top}, {at.x + x + 1.0f, bottom}, 0.0f,
                     {scale_color((x + 0.5f) / width), 1.0f});
    }
    for (double k = std::ceil(range[0] / spacing - 1e-9); k * spacing <= range[1] + 1e-9 * spacing; ++k) {
        const auto share = static_cast<float>((k * spacing - range[0]) / (range[1] - range[0]));
        font_.draw(canvas, {at.x + share * width, bottom + 1.15f * size}, tick_text(k * spacing, spacing),
                   {size, dim_paint(), TextAlign::center});
    }
}

void Overlay::draw_contact_legend(Canvas& canvas) {
    const std::vector<LegendEntry> entries = world_.legend();
    if (entries.empty()) {
        return;
    }
    const float size = label_size * scale_;
    const float inset = padding * scale_;
    const float before_text = 1.3f * size;
    const float between = 2.0f * size;
    float width = -between;
    for (const LegendEntry& entry : entries) {
        width += before_text + font_.width(entry.text, size) + between;
    }
    const float bottom = static_cast<float>(canvas.height()) - edge * scale_;
    const glm::vec2 lower(edge * scale_ + beside_logo(sim::LogoCorner::bottom_left), bottom - 2.0f * inset - 0.8f * size);
    canvas.panel(lower, {lower.x + width + 2.0f * inset, bottom}, 8.0f * scale_, panel_paint());
    glm::vec2 at = lower + inset;
    for (const LegendEntry& entry : entries) {
        canvas.disc(at + glm::vec2(0.4f * size), 0.42f * size, {entry.color, 1.0f});
        font_.draw(canvas, at + glm::vec2(before_text, 0.76f * size), entry.text, {size, text_paint()});
        at.x += before_text + font_.width(entry.text, size) + between;
    }
}

} // namespace render
