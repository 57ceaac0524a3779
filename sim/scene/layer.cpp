#include "sim/scene/layer.h"

#include "sim/scene/inlined.h"

#include <algorithm>

namespace sim {

namespace {

/// Indices of the bodies that a key names.
std::vector<int> read_bodies(Section& section, const BodyFinder& find) {
    std::vector<int> bodies;
    for (const std::string& name : section.texts("bodies")) {
        bodies.push_back(find(name, section.place_of("bodies"), section.title()));
        if (bodies.back() < 0) {
            section.fail("bodies", "the world does not move, expected names of bodies");
        }
    }
    return bodies;
}

} // namespace

OverlayDef read_overlay(const TextSource& source, const TreeNode& node, const BodyFinder& find) {
    Section section(source, node, scene_section("overlay"), "overlay");
    OverlayDef overlay;
    for (const int word : section.words("show")) {
        overlay.show[static_cast<std::size_t>(word)] = true;
    }
    overlay.color_by = static_cast<ColorBy>(section.choice("color_by"));
    if (overlay.color_by >= ColorBy::speed && section.has("color_range")) {
        overlay.color_range = section.interval("color_range");
    }
    overlay.arrow_scale = section.optional_number("arrow_scale").value_or(0.0);
    overlay.trail_time = section.optional_number("trail_time").value_or(0.0);
    overlay.bodies = read_bodies(section, find);
    overlay.plots_at = static_cast<PlotCorner>(section.choice("plots_at"));
    overlay.zero_height = section.number("zero_height");
    if (section.has("logo")) {
        overlay.logo = read_logo(section);
    }
    overlay.logo_at = static_cast<LogoCorner>(section.choice("logo_at"));
    overlay.logo_height = section.number("logo_height");
    section.finish("without colours by a quantity");
    return overlay;
}

CaptionDef read_caption(const TextSource& source, const TreeNode& node, const std::string& title) {
    Section section(source, node, scene_section("caption"), title);
    CaptionDef caption;
    caption.text = section.lines("text");
    if (caption.text.find_first_not_of(" \t\n") == std::string::npos) {
        section.fail("text", "text is empty, expected what is to be read");
    }
    caption.place = static_cast<CaptionPlace>(section.choice("place"));
    caption.time = section.number("time");
    caption.duration = section.number("duration");
    caption.fade = section.number("fade");
    return caption;
}

PlotDef read_plot(const TextSource& source, const TreeNode& node, const std::string& title,
                  const SceneDef& scene, const BodyFinder& find) {
    Section section(source, node, scene_section("plot"), title);
    PlotDef plot;
    plot.title = section.text("title");
    plot.quantity = static_cast<PlotQuantity>(section.choice("quantity"));
    if (section.has("range")) {
        plot.range = section.interval("range");
    }
    const bool is_of_bodies =
        plot.quantity == PlotQuantity::inclination || plot.quantity == PlotQuantity::distance;
    if (is_of_bodies) {
        plot.bodies = read_bodies(section, find);
        if (plot.bodies.empty()) {
            section.fail("bodies", "no bodies are named, expected at least one for this quantity");
        }
    }
    if (plot.quantity == PlotQuantity::distance && section.has("closed_form_on")) {
        plot.closed_form_on =
            find(section.text("closed_form_on"), section.place_of("closed_form_on"), section.title());
        if (plot.closed_form_on < 0 ||
            !std::holds_alternative<Box>(scene.bodies[static_cast<std::size_t>(plot.closed_form_on)].shape)) {
            section.fail("closed_form_on", "the body is no box, expected the name of one");
        }
    }
    section.finish("for this quantity");
    return plot;
}

} // namespace sim
