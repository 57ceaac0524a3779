#include "render/overlay/overlay.h"
#include "render/overlay/palette.h"
#include "render/picture/renderer.h"
#include "sim/base/error.h"
#include "tests/render/sample_scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

using namespace render;

namespace {

constexpr int picture_width = 320;
constexpr int picture_height = 240;

/// A cube of 2 m on the floor, seen from the side.
sim::SceneDef cube_scene() {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.bodies.push_back(sample::body(sim::Box{{1, 1, 1}}, {sim::Vec3(0, 0, 1), sim::Quat::Identity()},
                                        sim::Vec3(0.3, 0.3, 0.3)));
    scene.bodies.back().mass.mass = 1.0;
    sample::set_camera(scene, {0, -10, 1}, {0, 0, 1}, sample::fov_for(40.0, 4.0 / 3.0));
    return scene;
}

sim::ContactSnapshot contact_at(float x, float y, float z, bool is_sticking) {
    return {{0, 1}, {x, y, z}, -Eigen::Vector3f::UnitZ(), {0, 0, -1}, is_sticking};
}

glm::vec3 color_at(const Image& image, int x, int y) {
    const std::uint8_t* rgb =
        &image.rgb[3 * (static_cast<std::size_t>(y) * picture_width + static_cast<std::size_t>(x))];
    return glm::vec3(rgb[0], rgb[1], rgb[2]) / 255.0f;
}

/// The picture with its overlay, and without.
struct Pair {
    Image plain;
    Image drawn;
};
Pair draw(const sim::SceneDef& scene, const sim::Snapshot& snapshot, double film_time = 0.0) {
    Renderer renderer(scene, picture_width, picture_height);
    Overlay overlay(scene);
    Pair pair{renderer.draw(snapshot), {}};
    pair.drawn = pair.plain;
    overlay.draw(pair.drawn, {film_time, snapshot, {}, renderer.depth()});
    return pair;
}

} // namespace

TEST(overlay, nothing_asked_for_changes_nothing) {
    const sim::SceneDef scene = cube_scene();
    EXPECT_FALSE(Overlay(scene).is_needed());
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(0, -1, 1, true)};
    const Pair pair = draw(scene, snapshot);
    EXPECT_EQ(pair.plain.rgb, pair.drawn.rgb);
}

// The view is 2 * 9 * tan(20 degrees) = 6.551 m high at the cube's front, so 1 m is 36.63 px there.
TEST(overlay, contacts_lie_where_perspective_says_in_the_colours_of_sticking_and_sliding) {
    sim::SceneDef scene = cube_scene();
    sample::show(scene, sim::Shown::points);
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(-0.5f, -1, 1.25f, true), contact_at(0.5f, -1, 1.25f, false)};
    const Pair pair = draw(scene, snapshot);
    const int y = static_cast<int>(picture_height / 2 - 0.25 * 36.63);
    const int x = static_cast<int>(0.5 * 36.63);
    EXPECT_LT(glm::length(color_at(pair.drawn, picture_width / 2 - x, y) - category_color(1)), 0.02f);
    EXPECT_LT(glm::length(color_at(pair.drawn, picture_width / 2 + x, y) - category_color(5)), 0.02f);
    EXPECT_EQ(color_at(pair.drawn, picture_width / 2, y), color_at(pair.plain, picture_width / 2, y));
}

TEST(overlay, contacts_behind_a_body_are_faint) {
    sim::SceneDef scene = cube_scene();
    sample::show(scene, sim::Shown::points);
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(0, 1, 1, true)};
    const Pair pair = draw(scene, snapshot);
    const glm::vec3 before = color_at(pair.plain, picture_width / 2, picture_height / 2);
    const glm::vec3 after = color_at(pair.drawn, picture_width / 2, picture_height / 2);
    EXPECT_GT(glm::length(after - before), 0.02f);
    EXPECT_LT(glm::length(after - before), 0.65f * glm::length(category_color(1) - before));
}

TEST(overlay, impulses_point_the_way_the_moving_body_is_pushed) {
    sim::SceneDef scene = cube_scene();
    sample::show(scene, sim::Shown::impulses);
    scene.overlay.arrow_scale = 1.0;
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(0, -1, 1, true)}; // 1 N s down on the floor, up on the cube
    const Pair pair = draw(scene, snapshot);
    EXPECT_GT(glm::length(color_at(pair.drawn, picture_width / 2, picture_height / 2 - 20) -
                          color_at(pair.plain, picture_width / 2, picture_height / 2 - 20)),
              0.1f);
    EXPECT_EQ(color_at(pair.drawn, picture_width / 2, picture_height / 2 + 20),
              color_at(pair.plain, picture_width / 2, picture_height / 2 + 20));
}

// An impact that stops a body of 2 kg after a fall of 0.05 view distances has an arrow of that length; twice the impulse,
// twice the length: 1 m.
TEST(overlay, impacts_have_arrows_of_their_own_colour_and_scale) {
    sim::SceneDef scene = cube_scene();
    sample::show(scene, sim::Shown::impulses);
    scene.bodies[0].mass.mass = 0.0;
    scene.bodies[1].mass.mass = 2.0;
    const sim::CameraKey& key = scene.cameras.front().keys.front();
    const double length = 0.05 * (key.eye - key.target).norm();
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.impacts = {contact_at(0, -1, 1, true)};
    snapshot.impacts[0].impulse.z() =
        static_cast<float>(-2.0 * 2.0 * std::sqrt(2.0 * scene.step.gravity.norm() * length));
    const Pair pair = draw(scene, snapshot);
    const auto above = static_cast<int>(0.5 * 2.0 * length * 36.63);
    // The line is less than a pixel wide: between the body's colour and its own.
    const glm::vec3 found = color_at(pair.drawn, picture_width / 2, picture_height / 2 - above);
    const glm::vec3 before = color_at(pair.plain, picture_width / 2, picture_height / 2 - above);
    EXPECT_LT(glm::length(found - category_color(3)), 0.75f * glm::length(before - category_color(3)));
    EXPECT_LT(glm::length(found - category_color(3)), 0.75f * glm::length(found - category_color(1)));
    for (const int beyond : {-12, static_cast<int>(2.0 * length * 36.63) + 12}) {
        EXPECT_EQ(color_at(pair.drawn, picture_width / 2, picture_height / 2 - beyond),
                  color_at(pair.plain, picture_width / 2, picture_height / 2 - beyond));
    }
}

TEST(overlay, a_contact_behind_the_camera_is_left_out) {
    sim::SceneDef scene = cube_scene();
    sample::show(scene, sim::Shown::normals);
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(0, -11, 1, true)};
    const Pair pair = draw(scene, snapshot);
    EXPECT_EQ(pair.plain.rgb, pair.drawn.rgb);
}

TEST(overlay, same_state_gives_the_same_bytes) {
    sim::SceneDef scene = cube_scene();
    scene.title = "A cube";
    for (int i = 0; i < sim::shown_count; ++i) {
        scene.overlay.show[static_cast<std::size_t>(i)] = true;
    }
    scene.plots.push_back({.title = "", .quantity = sim::PlotQuantity::energy, .bodies = {}, .range = {}});
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(-0.5f, -1, 1.25f, true), contact_at(0.5f, -1, 1.25f, false)};
    NoteTaker taker(scene);
    taker.observe(snapshot);
    Renderer renderer(scene, picture_width, picture_height);
    Image images[2];
    for (Image& image : images) {
        image = renderer.draw(snapshot);
        Overlay overlay(scene);
        overlay.draw(image, {0.0, snapshot, *taker.notes(), renderer.depth()});
    }
    EXPECT_EQ(images[0].rgb, images[1].rgb);
}

TEST(body_colors, speeds_are_on_the_scale_and_what_stands_keeps_its_look) {
    sim::SceneDef scene = cube_scene();
    scene.overlay.color_by = sim::ColorBy::speed;
    scene.overlay.color_range = {{0.0, 10.0}};
    const BodyColors colors(scene);
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.bodies[1].velocity = sim::Vec3(3, 4, 0);
    const std::vector<sim::Vec3> found = colors.of(snapshot);
    const glm::vec3 middle = linear_from_display(scale_color(0.5f));
    EXPECT_EQ(found[0], scene.bodies[0].look.color);
    EXPECT_NEAR(found[1].y(), static_cast<double>(middle.y), 1e-6);
}

TEST(body_colors, loads_and_contacts_are_summed_over_a_body) {
    sim::SceneDef scene = cube_scene();
    sim::Snapshot snapshot = sample::start(scene);
    snapshot.contacts = {contact_at(0, 0, 0, true), contact_at(1, 0, 0, true)};
    for (const auto& [by, sum] : {std::pair{sim::ColorBy::contacts, 2.0}, {sim::ColorBy::impulse, 2.0}}) {
        scene.overlay.color_by = by;
        scene.overlay.color_range = {{0.0, 2.0 * sum}};
        const glm::vec3 middle = linear_from_display(scale_color(0.5f));
        EXPECT_NEAR(BodyColors(scene).of(snapshot)[1].x(), static_cast<double>(middle.x), 1e-6);
    }
}

TEST(body_colors, equal_materials_share_a_colour_and_a_line_of_the_legend) {
    sim::SceneDef scene = cube_scene();
    for (const double mu : {0.1, 0.4, 0.1}) {
        scene.bodies.push_back(scene.bodies[1]);
        scene.bodies.back().material = {0.5, mu, mu};
    }
    scene.overlay.color_by = sim::ColorBy::material;
    const BodyColors colors(scene);
    const std::vector<sim::Vec3> found = colors.of(sample::start(scene));
    EXPECT_EQ(found[2], found[4]);
    EXPECT_NE(found[2], found[3]);
    ASSERT_EQ(colors.entries().size(), 3u);
    EXPECT_EQ(colors.entries()[1].text, "e 0.5  \u03bc 0.1");
}

// Brightness rises along the scale, so that it can be read without seeing hues; the categories differ in it
// or in blueness.
TEST(palette, scale_rises_in_lightness_throughout) {
    const auto lightness = [](const glm::vec3& display) {
        return glm::dot(linear_from_display(display), glm::vec3(0.2126f, 0.7152f, 0.0722f));
    };
    for (int i = 0; i < 64; ++i) {
        EXPECT_LT(lightness(scale_color(static_cast<float>(i) / 64)),
                  lightness(scale_color(static_cast<float>(i + 1) / 64)));
    }
    EXPECT_NEAR(display_from_linear(linear_from_display(glm::vec3(0.3f)))[1], 0.3f, 1e-6f);
}

/// Pixels that differ, in a part of the picture.
int changed_pixels(const Pair& pair, int from_row, int to_row) {
    int count = 0;
    for (int y = from_row; y < to_row; ++y) {
        for (int x = 0; x < picture_width; ++x) {
            count += color_at(pair.plain, x, y) != color_at(pair.drawn, x, y) ? 1 : 0;
        }
    }
    return count;
}

TEST(overlay, a_caption_is_there_at_its_time_and_place_and_fades) {
    sim::SceneDef scene = cube_scene();
    scene.captions = {{"A cube of 2 m", sim::CaptionPlace::bottom, 1.0, 2.0, 0.5}};
    const sim::Snapshot snapshot = sample::start(scene);
    EXPECT_EQ(changed_pixels(draw(scene, snapshot, 0.9), 0, picture_height), 0);
    EXPECT_EQ(changed_pixels(draw(scene, snapshot, 3.0), 0, picture_height), 0);
    const Pair whole = draw(scene, snapshot, 2.0);
    EXPECT_GT(changed_pixels(whole, picture_height - 60, picture_height), 1000);
    EXPECT_EQ(changed_pixels(whole, 0, picture_height - 60), 0);
    // Half faded in: a panel's pixel beside the text is half as far from the plain picture.
    const Pair half = draw(scene, snapshot, 1.25);
    const int x = picture_width / 2, y = picture_height - 11;
    const float full = glm::length(color_at(whole.drawn, x, y) - color_at(whole.plain, x, y));
    ASSERT_GT(full, 0.03f);
    EXPECT_NEAR(glm::length(color_at(half.drawn, x, y) - color_at(half.plain, x, y)), 0.5f * full, 0.008f); // 2 / 255
}

TEST(overlay, a_card_covers_the_picture_and_long_lines_wrap) {
    sim::SceneDef scene = cube_scene();
    const char* text = "One thousand cubes fall through a funnel of four plates";
    scene.captions = {{text, sim::CaptionPlace::card, 0.0, 2.0, 0.5}};
    const Pair pair = draw(scene, sample::start(scene), 0.0); // without fading in: the film begins with it
    EXPECT_EQ(color_at(pair.drawn, 0, 0), color_at(pair.drawn, picture_width - 1, picture_height - 1));
    const Font font;
    const std::vector<std::string> lines =
        font.lines("one two three\nfour", 20.0f, font.width("one two", 20.0f) + 1.0f);
    EXPECT_EQ(lines, (std::vector<std::string>{"one two", "three", "four"}));
    EXPECT_EQ(font.lines("abcabc", 20.0f, font.width("abc", 20.0f) + 0.5f), (std::vector<std::string>{"abc", "abc"}));
}

TEST(overlay, the_legend_of_colours_is_below_a_title_as_wide_as_the_picture) {
    sim::SceneDef scene = cube_scene();
    sample::show(scene, sim::Shown::title);
    scene.title = "One thousand cubes fall through a funnel of four plates";
    const Pair title = draw(scene, sample::start(scene));
    scene.overlay.color_by = sim::ColorBy::speed;
    const Pair both = draw(scene, sample::start(scene));
    const int x = 220; // where both are
    int title_end = 0, legend_top = 0;
    for (int y = picture_height / 2; y > 0; --y) {
        title_end = title_end == 0 && color_at(title.drawn, x, y) != color_at(title.plain, x, y) ? y + 1 : title_end;
        legend_top = color_at(both.drawn, x, y) != color_at(title.drawn, x, y) ? y : legend_top;
    }
    EXPECT_GT(title_end, 8);
    EXPECT_GT(legend_top, title_end);
}

/// A PNG file, 8 pixels wide and 4 high: the left half red, the right half clear.
std::string half_red_logo() {
    std::vector<std::uint8_t> rgba;
    for (int i = 0; i < 8 * 4; ++i) {
        const bool is_red = i % 8 < 4;
        rgba.insert(rgba.end(), {255, 0, 0, static_cast<std::uint8_t>(is_red ? 255 : 0)});
    }
    const std::vector<std::uint8_t> png = encode_png(PngKind::rgba8, 8, 4, rgba);
    return {png.begin(), png.end()};
}

TEST(overlay, a_logo_is_drawn_with_its_alpha_in_its_corner_over_cards_and_beside_title_and_legends) {
    sim::SceneDef scene = cube_scene();
    scene.overlay.logo = half_red_logo();
    scene.overlay.logo_height = 0.25; // 60 of 240 px high, 120 px wide
    scene.overlay.logo_at = sim::LogoCorner::bottom_left;
    const int edge = 8; // 18 / 720 of 320 px
    Pair pair = draw(scene, sample::start(scene));
    EXPECT_EQ(color_at(pair.drawn, edge + 30, picture_height - edge - 30), glm::vec3(1, 0, 0));
    EXPECT_EQ(color_at(pair.drawn, edge + 90, picture_height - edge - 30),
              color_at(pair.plain, edge + 90, picture_height - edge - 30));
    EXPECT_EQ(color_at(pair.drawn, edge + 30, picture_height - edge - 62),
              color_at(pair.plain, edge + 30, picture_height - edge - 62));
    scene.captions = {{"card", sim::CaptionPlace::card}};
    EXPECT_EQ(color_at(draw(scene, sample::start(scene)).drawn, edge + 30, picture_height - edge - 30),
              glm::vec3(1, 0, 0));

    scene.captions.clear();
    sample::show(scene, sim::Shown::title);
    scene.title = "One thousand cubes fall through a funnel of four plates"; // does not fit into one line
    sample::show(scene, sim::Shown::points);
    scene.overlay.color_by = sim::ColorBy::speed;
    for (const sim::LogoCorner corner :
         {sim::LogoCorner::top_left, sim::LogoCorner::top_right, sim::LogoCorner::bottom_left}) {
        scene.overlay.logo_at = corner;
        pair = draw(scene, sample::start(scene));
        const int clear = corner == sim::LogoCorner::top_right ? picture_width - edge - 30 : edge + 90;
        const int top = corner == sim::LogoCorner::bottom_left ? picture_height - edge - 60 : edge;
        for (int y = top; y < top + 60; ++y) {
            EXPECT_EQ(color_at(pair.drawn, clear, y), color_at(pair.plain, clear, y)) << y;
        }
    }

    scene.overlay.logo.resize(scene.overlay.logo.size() / 2);
    EXPECT_THROW(check_overlay(scene), sim::Error);
}

TEST(overlay, a_caption_at_the_top_comes_below_the_title) {
    sim::SceneDef scene = cube_scene();
    scene.captions = {{"ooo", sim::CaptionPlace::top}};
    scene.title = "A title from the left to the right of the picture";
    sample::show(scene, sim::Shown::title);
    Pair pair = draw(scene, sample::start(scene), 1.0);
    const int top = pair.drawn.texts.at(0).y;
    EXPECT_GE(pair.drawn.texts.at(pair.drawn.texts.size() - 1).y, top + 12);
}

TEST(overlay, a_letter_that_the_font_lacks_is_refused_by_its_name) {
    sim::SceneDef scene = cube_scene();
    scene.name = "film";
    scene.captions = {{"Größe Ωμ Привет"}};
    EXPECT_NO_THROW(check_overlay(scene));
    scene.captions = {{"ok"}, {"ok \u6f22"}};
    try {
        check_overlay(scene);
        FAIL() << "no error";
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::usage);
        EXPECT_STREQ(error.what(), "film: caption 1: the font lacks \u6f22 (U+6F22), expected Latin, Cyrillic, or "
                                   "Greek without accents");
    }
}
