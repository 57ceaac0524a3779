#pragma once
/// Diagrams of a study: error against cost, and the quantities of chaotic scenes over time.
#include "render/overlay/figure.h"
#include "render/study/table.h"

#include <filesystem>
#include <span>

namespace cmd {

/// A curve a knob over both logarithmic axes; settings as given, and the Pareto front.
render::Figure study_diagram(const study::Plan& plan, const study::Table& table);

/// The quantities over time, of a statistical plan: the reference with its spread, the settings as given and the
/// cheapest on the front.
render::Figure study_statistics(const study::Plan& plan, const study::Table& table,
                                std::span<const study::Point> points, std::span<const study::Point> references);

/// What each engine reaches at which cost, one curve an engine: error, of a statistical plan the largest overlap, for errors
/// within the spread do not tell engines apart.
render::Chart study_fronts(const study::Plan& plan, const study::Table& table);

/// Writes NAME.svg and NAME.png. Throws sim::Error (io).
void write_figure(const render::Figure& figure, const std::filesystem::path& folder, const char* name);

} // namespace cmd
