#include "render/picture/renderer.h"

#include "sample_scenes.h"
#include "sim/base/error.h"
#include "sim/model/polytope.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <numbers>
#include <vector>

namespace {

std::array<int, 3> pixel(const render::Image& image, int x, int y) {
    const std::uint8_t* rgb = image.rgb.data() + (static_cast<std::size_t>(y) * image.width + x) * 3;
    return {rgb[0], rgb[1], rgb[2]};
}

/// Largest difference of one channel between two pixels.
int difference(const std::array<int, 3>& a, const std::array<int, 3>& b) {
    return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

render::Image drawn(const sim::SceneDef& scene, int width, int height) {
    render::Renderer renderer(scene, width, height);
    return renderer.draw(sample::start(scene));
}

/// A sample at each pixel's centre and no more.
render::Image drawn_once(const sim::SceneDef& scene, int width, int height) {
    render::Renderer renderer(scene, width, height, {.smooth_edges = false});
    return renderer.draw(sample::start(scene));
}

/// A red cube of 2 m in the picture's middle, seen along +y from (0, -10, 0); no floor.
sim::SceneDef red_cube() {
    sim::SceneDef scene;
    scene.bodies.push_back(sample::body(sim::Box{{1, 1, 1}}, {}, {0.8, 0.05, 0.05}));
    sample::set_camera(scene, {0, -10, 0}, {0, 0, 0}, sample::fov_for(40, 4.0 / 3.0));
    return scene;
}

bool is_red(const std::array<int, 3>& rgb) {
    return rgb[0] > 2 * rgb[1] && rgb[0] > 2 * rgb[2];
}

/// Mean over blocks of n x n pixels.
render::Image averaged(const render::Image& large, int n) {
    render::Image small(large.width / n, large.height / n);
    for (int y = 0; y < small.height; ++y) {
        for (int x = 0; x < small.width; ++x) {
            std::array<int, 3> sum{};
            for (int k = 0; k < n * n; ++k) {
                const std::array<int, 3> rgb = pixel(large, x * n + k % n, y * n + k / n);
                for (std::size_t c = 0; c < 3; ++c) {
                    sum[c] += rgb[c];
                }
            }
            std::uint8_t* to = small.rgb.data() + (static_cast<std::size_t>(y) * small.width + x) * 3;
            for (std::size_t c = 0; c < 3; ++c) {
                to[c] = static_cast<std::uint8_t>((sum[c] + n * n / 2) / (n * n));
            }
        }
    }
    return small;
}

/// Peak signal-to-noise ratio [dB].
double psnr(const render::Image& a, const render::Image& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        const double d = static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i]);
        sum += d * d;
    }
    return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(a.rgb.size()) / std::max(sum, 1e-9));
}

/// Output of this test program run again with the environment `settings`, drawing one picture.
std::string picture_hash_with(const std::string& settings) {
    const std::string command =
        settings + " " + testing::internal::GetArgvs().front() +
        " --gtest_also_run_disabled_tests --gtest_filter=renderer.DISABLED_prints_hash";
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::array<char, 256> line{};
    while (std::fgets(line.data(), line.size(), pipe.get()) != nullptr) {
        if (std::string(line.data()).starts_with("hash ")) {
            return line.data();
        }
    }
    return "no picture with " + settings;
}

} // namespace

TEST(renderer, cube_covers_the_pixels_that_perspective_says) {
    const render::Image image = drawn(red_cube(), 160, 120);
    ASSERT_EQ(image.width, 160);
    ASSERT_EQ(image.height, 120);
    // The near face lies 9 m away: half its side is 60 px * (1 / 9) / tan(20 degrees) = 18.32 px, its edges
    // lie at 61.68 and 98.32 across, 41.68 and 78.32 down.
    const std::array<int, 3> red = pixel(image, 80, 60);
    const std::array<int, 3> sky = pixel(image, 10, 60);
    EXPECT_TRUE(is_red(red));
    EXPECT_LE(difference(pixel(image, 62, 42), red), 2);
    EXPECT_LE(difference(pixel(image, 97, 77), red), 2);
    EXPECT_EQ(pixel(image, 60, 60), sky);
    EXPECT_EQ(pixel(image, 99, 60), sky);
    // The pixel from 61 to 62 is covered by 0.32: between two and three of eight samples.
    const double share = static_cast<double>(pixel(image, 61, 60)[1] - sky[1]) / (red[1] - sky[1]);
    EXPECT_NEAR(share, 0.32, 0.5 / 8 + 0.01);
}

TEST(renderer, what_is_drawn_may_differ_from_what_collides) {
    sim::SceneDef scene = red_cube();
    const render::Image cube = drawn(scene, 160, 120);
    scene.bodies[0].shape = sim::Sphere{1.0};
    EXPECT_NE(drawn(scene, 160, 120).rgb, cube.rgb);
    scene.bodies[0].drawn = sim::Box{{1, 1, 1}};
    EXPECT_EQ(drawn(scene, 160, 120).rgb, cube.rgb);
}

TEST(renderer, top_row_shows_what_is_above) {
    sim::SceneDef scene = red_cube();
    scene.bodies[0].pose.position.z() = 2.5;
    const render::Image image = drawn(scene, 160, 120);
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

TEST(renderer, DISABLED_prints_hash) {
    std::uint64_t hash = 0xcbf29ce484222325ull;
    for (const sim::SceneDef& scene : {sample::funnel(5, true), sample::tippe_top(), sample::office_toy()}) {
        for (const std::uint8_t byte : drawn(scene, 320, 180).rgb) {
            hash = (hash ^ byte) * 0x100000001b3ull;
        }
    }
    std::printf("hash %016llx\n", static_cast<unsigned long long>(hash));
}

TEST(renderer, threads_and_vector_width_do_not_change_a_byte) {
    const std::string expected = picture_hash_with("LP_NUM_THREADS=0");
    EXPECT_TRUE(expected.starts_with("hash ")) << expected;
    // Mesa's cache of compiled shaders does not tell vector widths apart.
    for (const char* settings : {"LP_NUM_THREADS=1", "LP_NUM_THREADS=2", "LP_NUM_THREADS=5",
                                 "MESA_SHADER_CACHE_DISABLE=true LP_NATIVE_VECTOR_WIDTH=128",
                                 "MESA_SHADER_CACHE_DISABLE=true LP_NATIVE_VECTOR_WIDTH=256"}) {
        EXPECT_EQ(picture_hash_with(settings), expected) << settings;
    }
}

// Where light is the same from everywhere, a lone white body sends back what it receives and cannot be seen.
TEST(renderer, white_furnace) {
    for (const double metallic : {0.0, 0.5, 1.0}) {
        for (const double roughness : {0.05, 0.3, 0.7, 1.0}) {
            for (const sim::Shape& shape :
                 {sim::Shape(sim::Sphere{1}), sim::Shape(sim::Box{{0.8, 0.7, 0.6}})}) {
                sim::SceneDef scene;
                scene.light.sun_intensity = 0.0;
                scene.light.sky_zenith = scene.light.sky_horizon = sim::Vec3(0.6, 0.6, 0.6);
                scene.bodies.push_back(
                    sample::body(shape, {{0, 0, 0}, sample::turn(0.7, {1, 2, 3})}, {1, 1, 1}));
                scene.bodies[0].look.metallic = metallic;
                scene.bodies[0].look.roughness = roughness;
                sample::set_camera(scene, {0, -5, 1}, {0, 0, 0}, 40);
                const render::Image image = drawn(scene, 96, 54);
                const std::array<int, 3> sky = pixel(image, 2, 2);
                int worst = 0;
                for (int i = 0; i < image.width * image.height; ++i) {
                    worst = std::max(worst, difference(pixel(image, i % image.width, i / image.width), sky));
                }
                EXPECT_LE(worst, 1) << "metallic " << metallic << " roughness " << roughness;
            }
        }
    }
}

/// A cube of 1 m on a floor of one colour.
sim::SceneDef cube_on_floor(const sim::Vec3& to_sun) {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.bodies.back().look.pattern_color = scene.bodies.back().look.color;
    scene.bodies.push_back(sample::body(sim::Box{}, {{0, 0, 0.5}, sim::Quat::Identity()}, {0.5, 0.5, 0.5}));
    scene.light.to_sun = to_sun.normalized();
    return scene;
}

// The sun at 45 degrees in the x-z plane: the shadow ends at x = 1.5, y = -0.5 .. 0.5.
TEST(renderer, shadow_edge_lies_where_geometry_says) {
    sim::SceneDef scene = cube_on_floor({-1, 0, 1});
    // From straight above, 10 m high: 1 m is 180 px * (1 / 10) / tan(20 degrees) = 49.45 px.
    sample::set_camera(scene, {0, 0, 10}, {0, 0, 0}, 40);
    const render::Image image = drawn(scene, 640, 360);
    const double px = 180.0 / 10.0 / std::tan(20.0 * std::numbers::pi / 180.0);
    const auto green = [&](double x, double y) {
        return pixel(image, static_cast<int>(320 + x * px), static_cast<int>(180 - y * px))[1];
    };
    const int lit = green(2.5, 0.0);
    const int dark = green(1.2, 0.0);
    EXPECT_LT(dark + 30, lit);
    // Light fades from the middle outwards, by less than a level here.
    EXPECT_NEAR(green(-1.5, 0.0), lit, 1);
    // The half shadow is four texels of 0.9 thousandths of the view distance wide: 36 mm, on the slanting
    // floor 51 mm. So 26 mm and half a pixel of 20 mm on both sides of the edge.
    EXPECT_NEAR(green(1.5 + 0.04, 0.0), lit, 1);
    EXPECT_NEAR(green(1.5 - 0.04, 0.0), dark, 3);
    EXPECT_NEAR(green(1.25, 0.5 - 0.04), dark, 3);
    EXPECT_NEAR(green(1.25, 0.5 + 0.04), lit, 1);
    // No gap between the cube and its shadow.
    EXPECT_LT(green(0.62, 0.0), dark + 5);
}

TEST(renderer, no_light_comes_through_where_a_body_stands_flush_on_the_floor) {
    sim::SceneDef scene = cube_on_floor({-0.05, 0, 1});
    // The foot of the cube's dark side in the middle, from 2.7 m: a texel of the shadow map has three pixels.
    sample::set_camera(scene, {3, -0.5, 1}, {0.5, 0, 0}, 6);
    const render::Image image = drawn(scene, 640, 360);
    const int dark = pixel(image, 320, 195)[1];
    for (int y = 181; y < 195; ++y) {
        EXPECT_LT(pixel(image, 320, y)[1], dark + 5) << y;
    }
}

TEST(renderer, no_light_comes_through_where_a_hull_stands_flush_on_a_body) {
    sim::SceneDef scene = cube_on_floor({-0.4, 0.3, 1});
    scene.bodies[0].shape = sim::Box{{5, 5, 0.5}};
    scene.bodies[0].pose.position = sim::Vec3(0, 0, -0.5);
    std::vector<sim::Vec3> corners;
    for (int k = 0; k < 8; ++k) {
        corners.emplace_back((k & 1) - 0.5, ((k >> 1) & 1) - 0.5, ((k >> 2) & 1) - 0.5);
    }
    scene.bodies[1].shape = sim::Hull{std::make_shared<const sim::Polytope>(*sim::convex_hull(corners))};
    sample::set_camera(scene, {3, -0.5, 1}, {0.5, 0, 0}, 6); // the foot of the cube's dark side
    const render::Image image = drawn(scene, 640, 360);
    const int dark = pixel(image, 320, 195)[1];
    for (int y = 181; y < 195; ++y) {
        EXPECT_LT(pixel(image, 320, y)[1], dark + 5) << y;
    }
}

TEST(renderer, ground_is_darker_where_a_body_rests) {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.light.sun_intensity = 0.0;
    scene.bodies.back().look.color = sim::Vec3(0.4, 0.4, 0.4);
    scene.bodies.back().look.pattern_color = scene.bodies.back().look.color;
    scene.bodies.push_back(sample::body(sim::Box{}, {{0, 0, 0.5}, sim::Quat::Identity()}, {0.5, 0.5, 0.5}));
    sample::set_camera(scene, {0, 0, 10}, {0, 0, 0}, 40);
    const render::Image image = drawn(scene, 640, 360);
    const int far = pixel(image, 320 + 120, 180)[1];
    const int near = pixel(image, 320 + 31, 180)[1];
    EXPECT_LT(near + 10, far);
    scene.output.ambient_occlusion = false;
    const render::Image open = drawn(scene, 640, 360);
    EXPECT_NEAR(pixel(open, 320 + 120, 180)[1], far, 2);
    EXPECT_NEAR(pixel(open, 320 + 31, 180)[1], far, 2);
}

TEST(renderer, empty_scene_is_all_sky) {
    sim::SceneDef scene;
    sample::set_camera(scene, {0, -10, 0}, {0, 0, 0}, 40);
    const render::Image image = drawn(scene, 32, 18);
    EXPECT_GT(pixel(image, 16, 2)[2], 50);
    // Below the horizon the sky keeps its horizon's colour.
    EXPECT_EQ(pixel(image, 16, 12), pixel(image, 3, 17));
}

TEST(renderer, camera_inside_a_body_sees_out_of_it) {
    sim::SceneDef scene = red_cube();
    sample::set_camera(scene, {0, 0, 0}, {0, 5, 0}, 40);
    EXPECT_FALSE(is_red(pixel(drawn(scene, 64, 36), 32, 18)));
    scene.bodies[0].shape = sim::Sphere{1};
    EXPECT_FALSE(is_red(pixel(drawn(scene, 64, 36), 32, 18)));
}

TEST(renderer, views_straight_down_and_along_the_floor_are_whole) {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.bodies.push_back(sample::body(sim::Box{}, {{0, 0, 0.5}, sim::Quat::Identity()}, {0.8, 0.05, 0.05}));
    sample::set_camera(scene, {0, 0, 8}, {0, 0, 0}, 40);
    EXPECT_TRUE(is_red(pixel(drawn(scene, 64, 36), 32, 18)));
    // The eye 1 mm above the floor: the lower half is floor, the upper half cube and sky.
    sample::set_camera(scene, {0, -8, 0.001}, {0, 0, 0.001}, 40);
    const render::Image image = drawn(scene, 64, 36);
    EXPECT_TRUE(is_red(pixel(image, 32, 16)));
    EXPECT_FALSE(is_red(pixel(image, 32, 20)));
}

TEST(renderer, body_far_larger_than_the_view_keeps_the_shadows_of_small_ones) {
    sim::SceneDef scene;
    // A block of 2 km whose top is the ground.
    scene.bodies.push_back(
        sample::body(sim::Box{{1000, 1000, 1000}}, {{0, 0, -1000}, sim::Quat::Identity()}, {0.5, 0.5, 0.5}));
    scene.bodies.push_back(sample::body(sim::Box{}, {{0, 0, 0.5}, sim::Quat::Identity()}, {0.5, 0.5, 0.5}));
    scene.light.to_sun = sim::Vec3(-1, 0, 1).normalized();
    sample::set_camera(scene, {0, 0, 10}, {0, 0, 0}, 40);
    const render::Image image = drawn(scene, 320, 180);
    EXPECT_LT(pixel(image, 160 + 30, 90)[1] + 30, pixel(image, 160 - 30, 90)[1]);
}

TEST(renderer, poses_that_are_no_numbers_are_left_out) {
    sim::SceneDef scene = red_cube();
    sim::Snapshot snapshot = sample::start(scene);
    render::Renderer renderer(scene, 64, 36);
    snapshot.bodies[0].position.x() = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(is_red(pixel(renderer.draw(snapshot), 32, 18)));
}

TEST(renderer, draws_100000_bodies) {
    sim::SceneDef scene;
    sample::add_floor(scene);
    for (int i = 0; i < 100000; ++i) {
        const sim::Vec3 at(i % 50, (i / 50) % 50, i / 2500);
        scene.bodies.push_back(
            i % 2 == 0
                ? sample::body(sim::Box{{0.3, 0.3, 0.3}}, {at, sim::Quat::Identity()}, {0.8, 0.05, 0.05})
                : sample::body(sim::Sphere{0.3}, {at, sim::Quat::Identity()}, {0.8, 0.05, 0.05}));
    }
    sample::set_camera(scene, {-40, -60, 60}, {25, 25, 15}, 40);
    EXPECT_TRUE(is_red(pixel(drawn(scene, 160, 90), 80, 45)));
}

// Two references: 16 samples a pixel, the frame drawn four times as large without smooth edges, blocks
// averaged; and the same with smooth edges, 128 samples a pixel.
TEST(renderer, edges_are_better_than_those_of_4_samples_and_within_45_db_of_16_and_of_the_finest) {
    const std::array<sim::SceneDef, 3> scenes{sample::funnel(6), sample::incline(), sample::office_toy()};
    for (const sim::SceneDef& scene : scenes) {
        const render::Image ours = drawn(scene, 960, 540);
        const render::Image reference = averaged(drawn_once(scene, 3840, 2160), 4);
        const double finest = psnr(ours, averaged(drawn(scene, 3840, 2160), 4));
        const double near = psnr(ours, reference);
        const double four_samples = psnr(averaged(drawn_once(scene, 1920, 1080), 2), reference);
        RecordProperty("edges_db_" + scene.name, std::to_string(finest));
        std::printf("%s: %.1f dB from 128 samples, %.1f dB from 16, from which 4 samples are %.1f dB\n",
                    scene.name.c_str(), finest, near, four_samples);
        EXPECT_GE(finest, 45.0) << scene.name;
        EXPECT_GE(near, 45.0) << scene.name;
        // Samples smooth what polished balls mirror too; smooth edges do not.
        if (scene.name != "office_toy") {
            EXPECT_GT(near, four_samples) << scene.name;
        }
    }
}

// The camera moves by 0.17 pixels from picture to picture: what does not crawl or shimmer changes as
// evenly as in pictures of 16 samples. Roughness of a pixel's course: the square of its second difference in
// time.
TEST(renderer, slow_cameras_see_less_shimmer_than_4_samples_have) {
    sim::SceneDef scene = sample::funnel(4);
    const auto roughness = [&scene](int scale) {
        std::vector<render::Image> pictures;
        for (int k = 0; k < 4; ++k) {
            // 0.17 px * (2 * 46 m * tan(20 degrees) / 540 px) = 10.5 mm.
            sample::set_camera(scene, {26 + 0.0105 * k, -36, 24}, {0.0105 * k, 0, 11}, 40);
            pictures.push_back(scale == 1 ? drawn(scene, 960, 540)
                                          : averaged(drawn_once(scene, 960 * scale, 540 * scale), scale));
        }
        double sum = 0.0;
        for (std::size_t k = 2; k < pictures.size(); ++k) {
            for (std::size_t i = 0; i < pictures[k].rgb.size(); ++i) {
                const int change = pictures[k].rgb[i] - 2 * pictures[k - 1].rgb[i] + pictures[k - 2].rgb[i];
                sum += change * change;
            }
        }
        return sum;
    };
    const double reference = roughness(4);
    const double ours = roughness(1) / reference;
    const double four_samples = roughness(2) / reference;
    std::printf("roughness over that of 16 samples: %.2f; of 4 samples: %.2f\n", ours, four_samples);
    EXPECT_LT(ours, four_samples);
}

// A dark slat before the sky, 6 pixels wide. Its side, two thirds of a pixel more, leans by two pixels, so
// that it holds no pixel's centre in some rows: the same share of all rows is covered.
TEST(renderer, thin_faces_of_boxes_are_not_dashed) {
    sim::SceneDef scene;
    scene.light.sun_intensity = 0.0;
    scene.light.sky_zenith = scene.light.sky_horizon = sim::Vec3(1, 1, 1);
    const sim::Quat place = sample::turn(0.02, sim::Vec3::UnitY()) * sample::turn(-0.067, sim::Vec3::UnitZ());
    scene.bodies.push_back(sample::body(sim::Box{{0.06, 0.1, 2}}, {{0, 0, 0}, place}, {0, 0, 0}));
    scene.bodies[0].look.roughness = 1.0;
    // 50 pixels a metre: tan(angle / 2) = 1 m / 20 m.
    sample::set_camera(scene, {0, -20, 0}, {0, 0, 0},
                       sample::fov_for(360.0 / std::numbers::pi * std::atan(0.05), 1.0));
    const render::Image image = drawn(scene, 100, 100);
    const int sky = pixel(image, 5, 50)[1];
    const int slat = pixel(image, 50, 50)[1];
    double least = 100.0;
    double most = 0.0;
    for (int y = 0; y < 100; ++y) {
        double covered = 0.0; // [px]
        for (int x = 0; x < 100; ++x) {
            covered += static_cast<double>(sky - pixel(image, x, y)[1]) / (sky - slat);
        }
        least = std::min(least, covered);
        most = std::max(most, covered);
    }
    EXPECT_NEAR(0.5 * (least + most), 6.67, 0.2);
    EXPECT_LT(most - least, 0.3) << "one of eight samples at either edge";
}

// A ball before the sky: as wide as it is, smooth at its rim, and sky beside it.
TEST(renderer, round_edges_before_the_sky_have_the_coverage_of_a_disc) {
    sim::SceneDef scene;
    scene.light.sun_intensity = 0.0;
    scene.light.sky_zenith = scene.light.sky_horizon = sim::Vec3(1, 1, 1);
    scene.bodies.push_back(sample::body(sim::Sphere{1}, {}, {0, 0, 0}));
    scene.bodies[0].look.roughness = 1.0;
    sample::set_camera(scene, {0, -20, 0}, {0, 0, 0}, sample::fov_for(20, 1.0));
    const render::Image image = drawn(scene, 120, 120);
    const int sky = pixel(image, 5, 5)[1];
    const int ball = pixel(image, 60, 60)[1];
    double covered = 0.0;
    for (int i = 0; i < 120 * 120; ++i) {
        covered += static_cast<double>(sky - pixel(image, i % 120, i / 120)[1]) / (sky - ball);
    }
    // Radius on the picture: 60 px * tan(asin(1 / 20)) / tan(10 degrees) = 17.04 px. The ball is a little
    // brighter towards its rim, where it mirrors more.
    const double radius = 60.0 * std::tan(std::asin(0.05)) / std::tan(10.0 * std::numbers::pi / 180.0);
    const double area = std::numbers::pi * radius * radius;
    EXPECT_NEAR(covered, area, 0.03 * area);
    EXPECT_EQ(pixel(image, 60 - 19, 60)[1], sky);
}

// A white square that crosses a dark sky: while the shutter is open its edges run over `run` pixels.
TEST(renderer, motion_blur_spreads_moving_edges_evenly) {
    sim::SceneDef scene;
    scene.light.sky_zenith = scene.light.sky_horizon = sim::Vec3(0, 0, 0);
    scene.light.to_sun = sim::Vec3(0, -1, 0);
    scene.bodies.push_back(sample::body(sim::Box{}, {}, {0.9, 0.9, 0.9}));
    scene.bodies[0].velocity = sim::Vec3(10, 0, 0);
    sample::set_camera(scene, {0, -10, 0}, {0, 0, 0}, sample::fov_for(40, 4.0 / 3.0));
    render::Renderer renderer(scene, 160, 120);
    const sim::Snapshot snapshot = sample::start(scene);
    const render::Image sharp = renderer.draw(snapshot);
    EXPECT_EQ(renderer.draw_blurred(snapshot, 0.02, 1).rgb, sharp.rgb);
    const render::Image blurred = renderer.draw_blurred(snapshot, 0.02, 32);
    // 0.2 m are 60 px * (0.2 / 9.5) / tan(20 degrees) = 3.5 px; the right edge rests at 80 + 8.7 px.
    EXPECT_EQ(pixel(blurred, 80, 60), pixel(sharp, 80, 60));
    const double full = std::pow(pixel(sharp, 80, 60)[1], 2);
    double light = 0.0;
    for (int x = 80; x < 100; ++x) {
        light += std::pow(pixel(blurred, x, 60)[1], 2) / full;
    }
    EXPECT_NEAR(light, 60.0 * (0.5 / 9.5) / std::tan(20.0 * std::numbers::pi / 180.0), 0.2);
    // The edge runs from 86.9 to 90.4 px: pixel 87 is covered for 0.84 of the time.
    EXPECT_NEAR(std::pow(pixel(blurred, 87, 60)[1], 2) / full, 0.84, 0.05);
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
