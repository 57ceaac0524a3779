#include "render/renderer.h"

#include "sample_scenes.h"
#include "sim/error.h"

#include <gtest/gtest.h>

#include <array>

namespace {

std::array<int, 3> pixel(const render::Image& image, int x, int y) {
    const std::uint8_t* rgb = image.rgb.data() + (static_cast<std::size_t>(y) * image.width + x) * 3;
    return {rgb[0], rgb[1], rgb[2]};
}

/// A red cube of 2 m in the picture's middle, seen along +y from (0, -10, 0); no floor.
sim::SceneDef red_cube() {
    sim::SceneDef scene;
    scene.bodies.push_back(sample::body(sim::Box{{1, 1, 1}}, {}, {0.8, 0.05, 0.05}));
    sample::set_camera(scene, {0, -10, 0}, {0, 0, 0}, 40);
    return scene;
}

bool is_red(const std::array<int, 3>& rgb) {
    return rgb[0] > 2 * rgb[1] && rgb[0] > 2 * rgb[2];
}

} // namespace

TEST(renderer, cube_covers_the_pixels_that_perspective_says) {
    const sim::SceneDef scene = red_cube();
    render::Renderer renderer(scene, 160, 120);
    const render::Image image = renderer.draw(sample::start(scene));
    ASSERT_EQ(image.width, 160);
    ASSERT_EQ(image.height, 120);
    // The near face lies 9 m away: half its side is 60 px * (1 / 9) / tan(20 degrees) = 18.3 px.
    EXPECT_TRUE(is_red(pixel(image, 80, 60)));
    EXPECT_TRUE(is_red(pixel(image, 80 - 17, 60 + 17)));
    EXPECT_TRUE(is_red(pixel(image, 80 + 17, 60 - 17)));
    EXPECT_FALSE(is_red(pixel(image, 80 - 20, 60)));
    EXPECT_FALSE(is_red(pixel(image, 80 + 20, 60)));
    EXPECT_FALSE(is_red(pixel(image, 80, 60 - 20)));
    EXPECT_FALSE(is_red(pixel(image, 80, 60 + 20)));
}

TEST(renderer, top_row_shows_what_is_above) {
    sim::SceneDef scene = red_cube();
    scene.bodies[0].pose.position.z() = 2.5;
    render::Renderer renderer(scene, 160, 120);
    const render::Image image = renderer.draw(sample::start(scene));
    EXPECT_TRUE(is_red(pixel(image, 80, 15)));
    EXPECT_FALSE(is_red(pixel(image, 80, 105)));
}

TEST(renderer, same_snapshot_gives_same_bytes_in_any_order) {
    const sim::SceneDef scene = sample::funnel(4);
    render::Renderer renderer(scene, 160, 90);
    sim::Snapshot moved = sample::start(scene);
    const render::Image first = renderer.draw(moved);
    moved.bodies.back().position.x() += 1.0;
    const render::Image other = renderer.draw(moved);
    EXPECT_NE(first.rgb, other.rgb);
    EXPECT_EQ(first.rgb, renderer.draw(sample::start(scene)).rgb);
}

TEST(renderer, empty_scene_is_all_sky) {
    sim::SceneDef scene;
    sample::set_camera(scene, {0, -10, 0}, {0, 0, 0}, 40);
    render::Renderer renderer(scene, 32, 18);
    const render::Image image = renderer.draw(sample::start(scene));
    EXPECT_GT(pixel(image, 16, 2)[2], 50);
    // Below the horizon the sky keeps its horizon's colour.
    EXPECT_EQ(pixel(image, 16, 12), pixel(image, 3, 17));
}

TEST(renderer, unknown_camera_is_a_usage_error_that_names_the_known_ones) {
    const sim::SceneDef scene = red_cube();
    try {
        render::Renderer renderer(scene, 32, 18, {.camera = "side"});
        FAIL() << "no error";
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::usage);
        EXPECT_NE(std::string(error.what()).find("main"), std::string::npos);
    }
}
