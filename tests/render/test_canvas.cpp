#include "render/overlay/canvas.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

using namespace render;

namespace {

/// Sum of all values over 255: pixels that a white shape covers on black, for one channel.
double covered(const Image& image) {
    double sum = 0.0;
    for (std::size_t i = 0; i < image.rgb.size(); i += 3) {
        sum += image.rgb[i] / 255.0;
    }
    return sum;
}

constexpr Paint white{{1.0f, 1.0f, 1.0f}, 1.0f};

} // namespace

TEST(canvas, shapes_cover_their_area) {
    Image disc(64, 64);
    Canvas(disc).disc({31.3f, 32.6f}, 20.0f, white);
    EXPECT_NEAR(covered(disc), 3.14159265 * 400.0, 2.0);
    Image panel(64, 64);
    Canvas(panel).panel({10.0f, 12.0f}, {50.0f, 42.0f}, 6.0f, white);
    EXPECT_NEAR(covered(panel), 40.0 * 30.0 - (4.0 - 3.14159265) * 36.0, 2.0);
    Image line(64, 64);
    Canvas(line).stroke(std::array{glm::vec2(10.0f, 10.0f), glm::vec2(40.0f, 50.0f)}, {white, 4.0f, 0.0f});
    EXPECT_NEAR(covered(line), 50.0 * 4.0 + 3.14159265 * 4.0, 3.0); // with round ends
    Image arrow(64, 64);
    Canvas(arrow).arrow({8.0f, 32.0f}, {56.0f, 32.0f}, 12.0f, {white, 2.0f, 0.0f});
    EXPECT_NEAR(covered(arrow), 36.0 * 2.0 + 0.42 * 12.0 * 12.0, 5.0);
}

TEST(canvas, a_line_that_crosses_itself_is_blended_once) {
    Image image(32, 32);
    const std::array points{glm::vec2(4.0f, 16.5f), glm::vec2(28.0f, 16.5f), glm::vec2(4.0f, 16.5f)};
    Canvas(image).stroke(points, {{glm::vec3(1.0f), 0.5f}, 3.0f, 0.0f});
    EXPECT_EQ(image.rgb[3 * (16 * 32 + 16)], 128);
}

TEST(canvas, half_of_a_dashed_line_is_drawn_across_its_corners) {
    Image image(128, 32);
    const std::array points{glm::vec2(4.0f, 16.5f), glm::vec2(31.0f, 16.5f), glm::vec2(124.0f, 16.5f)};
    Canvas(image).stroke(points, {white, 1.0f, 6.0f});
    // Ten dashes of 6 px, each with half a disc of 1 px at both ends.
    EXPECT_NEAR(covered(image), 60.0 + 10.0 * 0.8, 4.0);
    EXPECT_EQ(image.rgb[3 * (16 * 128 + 6)], 255);
    EXPECT_EQ(image.rgb[3 * (16 * 128 + 13)], 0);
}

TEST(canvas, what_lies_outside_is_cut_off) {
    Image image(16, 16);
    Canvas canvas(image);
    canvas.disc({-40.0f, 8.0f}, 8.0f, white);
    canvas.panel({100.0f, 100.0f}, {120.0f, 120.0f}, 3.0f, white);
    canvas.stroke(std::array{glm::vec2(-1e6f, -9.0f), glm::vec2(1e6f, -9.0f)}, {white, 2.0f, 0.0f});
    const std::vector<std::uint8_t> full(16, 255);
    canvas.mask({14, 14, 4, 4, full}, white);
    EXPECT_DOUBLE_EQ(covered(image), 4.0); // the mask's corner only
    canvas.panel({-100.0f, -100.0f}, {100.0f, 100.0f}, 0.0f, white);
    EXPECT_DOUBLE_EQ(covered(image), 256.0);
}
