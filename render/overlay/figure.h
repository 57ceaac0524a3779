#pragma once
/// Diagrams: curves and marks over two axes, each linear or logarithmic, as SVG and as a picture. Same figure, same
/// bytes.
#include "render/picture/image.h"

#include <glm/glm.hpp>

#include <string>
#include <vector>

namespace render {

enum class Mark { none, disc, square, up, down, diamond, pentagon, ring, star };

/// Points joined by lines, or with a mark each, or both; or an area.
struct Series {
    std::string title{};              ///< in the key; empty: not there
    glm::vec3 color{0.0f};            ///< display values
    std::vector<glm::dvec2> points{}; ///< in the units of the axes; with is_area: its outline
    float line = 1.6f;                ///< [px] width; 0: no lines
    float dash = 0.0f;                ///< [px]; 0: unbroken
    Mark mark = Mark::none;
    float mark_size = 4.0f; ///< [px] half of its width
    bool has_steps = false; ///< lines go level to the next point, then up or down
    bool is_area = false;   ///< filled, a quarter opaque
};

struct Axis {
    std::string label;
    bool is_logarithmic = false; ///< points at 0 and below are left out
};

/// A text beside a point.
struct PointLabel {
    glm::dvec2 at{0.0};
    std::string text;
};

struct Chart {
    std::string title{};
    Axis x{}, y{};
    std::vector<Series> series{};
    std::vector<PointLabel> labels{};
    bool has_key = true; ///< to the right of the axes
};

/// Charts of equal size in rows.
struct Figure {
    int width = 1000, height = 560; ///< [px]
    int columns = 1;
    std::vector<Chart> charts;
};

std::string figure_svg(const Figure& figure);
Image figure_image(const Figure& figure);

} // namespace render
