#include "render/picture/passes.h"
#include "render/picture/renderer.h"

#include "sample_scenes.h"
#include "tests/support/out_folder.h"

#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

namespace {

constexpr int passes_width = 160;
constexpr int passes_height = 120;

/// A box, a ball that flies to the right and spins, and a cylinder on a floor, seen along +y from (0, -10, 1).
sim::SceneDef shapes() {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.bodies.push_back(sample::body(sim::Box{{0.5, 0.5, 0.5}}, {{-2, 0, 0.5}}, {0.9, 0.1, 0.1}));
    scene.bodies.push_back(sample::body(sim::Sphere{0.5}, {{0, 0, 1}}, {0.1, 0.9, 0.1}));
    scene.bodies.back().velocity = sim::Vec3(3, 0, 0);
    scene.bodies.back().angular_velocity = sim::Vec3(0, 0, 2);
    scene.bodies.push_back(sample::body(sim::Cylinder{0.5, 0.5}, {{2, 0, 0.5}}, {0.1, 0.1, 0.9}));
    sample::set_camera(scene, {0, -10, 1}, {0, 0, 1}, sample::fov_for(40, 4.0 / 3.0));
    scene.output.passes.fill(true);
    return scene;
}

/// Calls use(source) with what a film would hand to the passes of a scene's start.
void with_passes(const sim::SceneDef& scene, double frame_time, const auto& use) {
    const sim::Snapshot snapshot = sample::start(scene);
    const auto plan = std::make_shared<const render::PicturePlan>(scene, passes_width, passes_height,
                                                                render::RenderSettings{.is_deep = true});
    const render::DrawList list = plan->list(snapshot);
    render::Renderer renderer(plan);
    render::RawPicture raw;
    render::DepthPicture depth;
    renderer.begin(list, true);
    renderer.finish(raw, depth);
    use(render::PassSource{*plan, raw, list, depth, snapshot, frame_time});
}

std::map<std::string, render::Channel> passes_of(const sim::SceneDef& scene, double frame_time) {
    std::map<std::string, render::Channel> channels;
    with_passes(scene, frame_time, [&](const render::PassSource& source) {
        for (render::Channel& channel : render::make_passes(source, scene.output)) {
            const std::string name = channel.name;
            channels[name] = std::move(channel);
        }
    });
    return channels;
}

/// Pixels a metre at the plane y = 0, 10 m before the eye; and the pixel that shows a place on it.
const double pixels_per_metre = 60.0 / std::tan(20.0 * std::numbers::pi / 180.0) / 10.0;
std::size_t pixel_at(double x, double z) {
    const int column = static_cast<int>(std::floor(80.0 + pixels_per_metre * x));
    const int row = static_cast<int>(std::floor(60.0 - pixels_per_metre * (z - 1.0)));
    return static_cast<std::size_t>(row) * passes_width + static_cast<std::size_t>(column);
}

} // namespace

TEST(passes, are_what_geometry_says) {
    const double frame_time = 0.1;
    std::map<std::string, render::Channel> found = passes_of(shapes(), frame_time);
    ASSERT_EQ(found.size(), 8u);
    const auto value = [&](const char* name, std::size_t pixel) { return found[name].values.at(pixel); };
    const auto normal = [&](std::size_t pixel) {
        return std::array{value("normal.X", pixel), value("normal.Y", pixel), value("normal.Z", pixel)};
    };
    // The ball, half a pixel (3 cm) from its middle both ways, and where its surface leans by 30 degrees.
    const std::size_t ball = pixel_at(0.01, 1.01);
    EXPECT_EQ(found["body.id"].counts.at(ball), 3u);
    EXPECT_NEAR(value("depth.Z", ball), 9.5, 2e-3);
    EXPECT_NEAR(normal(ball)[1], -1.0, 5e-3);
    const std::size_t right = pixel_at(0.25 * 10.0 / 9.57, 1.01);
    EXPECT_NEAR(normal(right)[0], 0.5, 0.04);
    EXPECT_NEAR(value("depth.Z", right), 10.0 - 0.5 * std::cos(std::asin(normal(right)[0])), 5e-3);
    // It flies 0.3 m to the right; its front turns to the right by 0.2 rad, 0.1 m at the middle, and away from the eye.
    const double turn = 0.2;
    const double to_x = 0.3 + 0.5 * std::sin(turn);
    EXPECT_NEAR(value("motion.X", ball), pixels_per_metre * 10.0 * to_x / (10.0 - 0.5 * std::cos(turn)), 0.15);
    EXPECT_NEAR(value("motion.Y", ball), 0.0, 0.05);
    // The box and the cylinder look at the eye; the floor looks up.
    const std::size_t box = pixel_at(-2.0, 0.8);
    EXPECT_EQ(found["body.id"].counts.at(box), 2u);
    EXPECT_NEAR(value("depth.Z", box), 9.5, 1e-3);
    EXPECT_EQ(normal(box), (std::array{0.0f, -1.0f, 0.0f}));
    EXPECT_NEAR(value("motion.X", box), 0.0, 1e-3);
    EXPECT_NEAR(normal(pixel_at(2.1, 0.8))[1], -1.0, 0.05);
    const std::size_t floor = pixel_at(0.0, -2.0);
    EXPECT_EQ(found["body.id"].counts.at(floor), 1u);
    EXPECT_EQ(normal(floor), (std::array{0.0f, 0.0f, 1.0f}));
    const std::size_t sky = pixel_at(0.0, 4.0);
    EXPECT_EQ(found["body.id"].counts.at(sky), 0u);
    EXPECT_TRUE(std::isinf(value("depth.Z", sky)));
    EXPECT_EQ(normal(sky), (std::array{0.0f, 0.0f, 0.0f}));
    // Alpha: bodies whole, floor and sky not; the ball's area before the sky.
    EXPECT_EQ(value("alpha.A", box), 1.0f);
    EXPECT_EQ(value("alpha.A", floor) + value("alpha.A", sky), 0.0f);
    double area = 0.0;
    for (std::size_t k = 0; k < passes_width * 60; ++k) { // above the horizon
        area += k % passes_width > 60 && k % passes_width < 100 ? value("alpha.A", k) : 0.0;
    }
    const double radius = 10.0 * pixels_per_metre * std::tan(std::asin(0.05));
    EXPECT_NEAR(area, 0.5 * std::numbers::pi * radius * radius, 0.02 * area);
}

TEST(passes, motion_follows_the_camera_too) {
    sim::SceneDef scene = shapes();
    // In 0.1 s the eye and its target move by 0.5 m to the right.
    scene.cameras[0].keys = {{0.0, {0, -10, 1}, {0, 0, 1}}, {0.1, {0.5, -10, 1}, {0.5, 0, 1}}};
    std::map<std::string, render::Channel> found = passes_of(scene, 0.1);
    EXPECT_NEAR(found["motion.X"].values.at(pixel_at(-2.0, 0.8)), -pixels_per_metre * 10.0 * 0.5 / 9.5, 0.02);
    EXPECT_NEAR(found["motion.X"].values.at(pixel_at(0.0, 4.0)), 0.0, 1e-3); // the sky is far
}

TEST(passes, bodies_before_nothing_keep_their_colour_at_their_edges) {
    with_passes(shapes(), 0.1, [&](const render::PassSource& source) {
        const render::Image frame = source.plan.picture(source.raw, source.list);
        const std::vector<std::uint8_t> samples = render::rgba_samples(source);
        ASSERT_EQ(samples.size(), frame.rgb.size() / 3 * 4);
        const auto of = [&](std::size_t pixel, std::size_t channel) { return int{samples.at(4 * pixel + channel)}; };
        for (const std::size_t pixel : {pixel_at(-2.0, 0.8), pixel_at(0.01, 1.01)}) {
            EXPECT_EQ(of(pixel, 3), 255);
            for (std::size_t c = 0; c < 3; ++c) {
                EXPECT_EQ(of(pixel, c), frame.rgb[3 * pixel + c]);
            }
        }
        EXPECT_EQ(of(pixel_at(0.0, -2.0), 3), 0); // the floor
        EXPECT_EQ(of(pixel_at(0.0, 4.0), 3), 0);  // the sky
        int edges = 0;
        for (std::size_t k = 0; k < passes_width * 60; ++k) { // the green ball, above the horizon
            if (k % passes_width > 60 && k % passes_width < 100 && of(k, 3) > 0 && of(k, 3) < 255) {
                ++edges;
                EXPECT_GT(of(k, 1), 5 * of(k, 0) / 4) << k;
                EXPECT_GT(of(k, 1), 60) << k; // not mixed with the dark
            }
        }
        EXPECT_GT(edges, 20);
        const std::vector<std::uint8_t> depth = render::depth16_samples(source);
        const auto millimetres = [&](std::size_t pixel) { return 256 * depth.at(2 * pixel) + depth.at(2 * pixel + 1); };
        EXPECT_EQ(millimetres(pixel_at(-2.0, 0.8)), 9500);
        EXPECT_EQ(millimetres(pixel_at(0.0, 4.0)), 65535);
        // As files.
        const std::filesystem::path path = test::out_folder("rgba.png");
        std::filesystem::create_directories(path.parent_path());
        const auto back = [&](render::PngKind kind, const std::vector<std::uint8_t>& written) {
            const std::vector<std::uint8_t> bytes = render::encode_png(kind, passes_width, passes_height, written);
            std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()),
                                                        static_cast<std::streamsize>(bytes.size()));
            return render::read_image(path); // without alpha; the high bytes of 16 bits
        };
        const render::Image color = back(render::PngKind::rgba8, samples);
        const render::Image gray = back(render::PngKind::gray16, depth);
        for (const std::size_t pixel : {pixel_at(-2.0, 0.8), pixel_at(0.3, 1.2), pixel_at(0.0, -2.0)}) {
            EXPECT_EQ(color.rgb.at(3 * pixel + 1), of(pixel, 1));
            EXPECT_EQ(gray.rgb.at(3 * pixel), depth.at(2 * pixel));
        }
    });
}

TEST(passes, picture_in_16_bits_is_the_frame_with_more_levels) {
    with_passes(shapes(), 0.1, [&](const render::PassSource& source) {
        const render::Image frame = source.plan.picture(source.raw, source.list);
        const std::vector<std::uint8_t> samples = render::rgb16_samples(source);
        ASSERT_EQ(samples.size(), 2 * frame.rgb.size());
        std::set<int> between; // sixteenths of a level
        for (std::size_t k = 0; k < frame.rgb.size(); ++k) {
            const double level = (256 * samples[2 * k] + samples[2 * k + 1]) / 257.0;
            ASSERT_NEAR(level, frame.rgb[k], 1.01) << k; // at edges the frame's colours were rounded twice
            between.insert(static_cast<int>(16.0 * (level - std::floor(level))));
        }
        EXPECT_EQ(between.size(), 16u);
        EXPECT_EQ(render::encode_png(render::PngKind::rgb16, passes_width, passes_height, samples).at(24), 16);
    });
}

TEST(passes, come_back_from_an_exr_file) {
    const int columns = 7, rows = 3;
    std::vector<render::Channel> channels{{.name = "depth.Z"}, {.name = "body.id"}};
    for (int k = 0; k < columns * rows; ++k) {
        channels[0].values.push_back(k == 4 ? std::numeric_limits<float>::infinity() : 0.1f * static_cast<float>(k));
        channels[1].counts.push_back(static_cast<std::uint32_t>(100000 * k));
    }
    const std::vector<std::uint8_t> bytes = render::encode_exr(channels, columns, rows);
    EXPECT_EQ(bytes, render::encode_exr(channels, columns, rows));
    const std::filesystem::path path = test::out_folder("passes.exr");
    std::filesystem::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()),
                                                static_cast<std::streamsize>(bytes.size()));
    std::vector<float> depth(columns * rows);
    std::vector<std::uint32_t> id(columns * rows);
    {
        Imf::InputFile file(path.c_str());
        ASSERT_EQ(file.header().dataWindow().max, Imath::V2i(columns - 1, rows - 1));
        Imf::FrameBuffer buffer;
        buffer.insert("depth.Z", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(depth.data()), 4, 4 * columns));
        buffer.insert("body.id", Imf::Slice(Imf::UINT, reinterpret_cast<char*>(id.data()), 4, 4 * columns));
        file.setFrameBuffer(buffer);
        file.readPixels(0, rows - 1);
    }
    std::filesystem::remove(path);
    EXPECT_EQ(depth, channels[0].values);
    EXPECT_EQ(id, channels[1].counts);
}
