#pragma once
/// A plot of curves over time, drawn into a picture.
#include "render/overlay/canvas.h"
#include "render/overlay/notes.h"
#include "render/overlay/text.h"

#include <array>
#include <string>
#include <vector>

namespace render {

/// One curve of a plot.
struct PlotCurve {
    std::string name;
    glm::vec3 color{1.0f}; ///< display values
    Curve points;
    Curve reference; ///< the closed form, dashed; may be empty
};

struct PlotPicture {
    std::string title;
    std::string unit;
    double duration = 1.0;         ///< [s] of the time axis
    std::array<double, 2> range{}; ///< of the value axis
    double tick = 0.0;             ///< between its ticks; 0: chosen
    std::string note;              ///< written at the top right
    std::vector<PlotCurve> curves;
};

/// Distance between ticks of an axis, 1, 2 or 5 times a power of ten, with about `count` of them.
double tick_spacing(const std::array<double, 2>& range, int count);
/// The range rounded outwards to such ticks; never empty.
std::array<double, 2> nice_range(double lower, double upper);
/// A tick's number, with no more digits than its spacing needs; a true minus sign.
std::string tick_text(double value, double spacing);

/// Where a plot's panel lies [px].
struct PlotPlace {
    glm::vec2 lower;
    glm::vec2 upper;
    float scale = 1.0f; ///< [px] 1/720 of the picture's height
};
void draw_plot(Canvas& canvas, Font& font, const PlotPicture& plot, const PlotPlace& place);

/// The look that all panels share.
Paint panel_paint();
Paint text_paint();
Paint dim_paint();

} // namespace render
