#include "render/overlay/figure.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace {

using namespace render;

std::array<int, 3> pixel(const Image& image, int x, int y) {
    const std::size_t i =
        3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
    return {image.rgb[i], image.rgb[i + 1], image.rgb[i + 2]};
}

/// A curve from (1, 1) to (100, 100): its frame goes over the decades 1e-1 to 1e3.
Figure diagonal() {
    Chart chart;
    chart.x = {"x", true};
    chart.y = {"y", true};
    chart.series = {
        {.color = {1, 0, 0}, .points = {{1, 1}, {10, 10}, {100, 100}}, .mark = Mark::square, .mark_size = 5.0f}};
    return {.width = 484, .height = 476, .charts = {chart}}; // of the axes: 400 by 400, from (66, 30)
}

TEST(figure, points_lie_where_their_logarithms_say) {
    const Image image = figure_image(diagonal());
    for (const int decade : {1, 2, 3}) { // of four, 100 px each
        EXPECT_EQ(pixel(image, 66 + 100 * decade, 430 - 100 * decade), (std::array<int, 3>{255, 0, 0})) << decade;
    }
    EXPECT_EQ(pixel(image, 66 + 150, 430 - 50), (std::array<int, 3>{255, 255, 255}));
    const std::string svg = figure_svg(diagonal());
    EXPECT_NE(svg.find("<polyline points=\"166.00,330.00 266.00,230.00 366.00,130.00\""), std::string::npos) << svg;
    EXPECT_NE(svg.find(">1e-1</text>"), std::string::npos);
    EXPECT_EQ(svg, figure_svg(diagonal()));
}

TEST(figure, an_area_is_a_quarter_opaque_and_a_line_over_it_is_not) {
    Chart chart;
    chart.series = {{.color = {0, 0, 0}, .points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}}, .is_area = true},
                    {.color = {0, 0, 1}, .points = {{0, 0.5}, {1, 0.5}}, .line = 6.0f}};
    const Image image = figure_image({.width = 484, .height = 476, .charts = {chart}});
    EXPECT_NEAR(pixel(image, 66 + 210, 230 - 10)[0], 191, 1);
    EXPECT_EQ(pixel(image, 66 + 210, 230), (std::array<int, 3>{0, 0, 255}));
}

TEST(figure, texts_cannot_end_an_element_and_are_valid_utf8) {
    Figure figure = diagonal();
    figure.charts[0].title = "a</text><script>\n\xFF\xC3\xA4'\"";
    const std::string svg = figure_svg(figure);
    EXPECT_NE(svg.find(">a&lt;/text&gt;&lt;script&gt;??\xC3\xA4'\"</text>"), std::string::npos) << svg;
    EXPECT_NO_THROW(figure_image(figure));
}

TEST(figure, numbers_that_no_axis_has_are_left_out) {
    Figure figure = diagonal();
    const std::string before = figure_svg(figure);
    for (const glm::dvec2& p :
         {glm::dvec2(0, 1), glm::dvec2(1, -1), glm::dvec2(std::nan(""), 1), glm::dvec2(1, INFINITY)}) {
        figure.charts[0].series[0].points.push_back(p);
    }
    EXPECT_EQ(figure_svg(figure), before);
    figure.charts[0].series.clear();
    EXPECT_NO_THROW(figure_image(figure));
    figure.charts.clear();
    EXPECT_NO_THROW(figure_image(figure));
}

} // namespace
