// Deliberate changes of shader, light, camera, mesh, simulation and scene are called changed, with the right cause and
// the bodies they concern; harmless ones are not. The scenes are the project's own.
#include "render/compare/pair.h"
#include "render/compare/source.h"
#include "render/gl/shader.h"
#include "render/picture/body_image.h"
#include "render/picture/renderer.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"
#include "tests/support/out_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <random>

namespace {

namespace fs = std::filesystem;
using sim::SceneDef;
using sim::Snapshot;

/// What a change is made to.
struct Drawing {
    SceneDef scene;
    Snapshot snapshot;
    render::RenderSettings settings;
};

sim::BodyDef& body(SceneDef& scene, const std::string& name) {
    return *std::find_if(scene.bodies.begin(), scene.bodies.end(), [&](const sim::BodyDef& b) { return b.name == name; });
}
sim::BodySnapshot& state(Drawing& d, const std::string& name) {
    return d.snapshot.bodies[static_cast<std::size_t>(&body(d.scene, name) - d.scene.bodies.data())];
}

struct Change {
    const char* name;
    const char* scene;
    std::vector<std::string> overrides; ///< as by --set
    std::function<void(Drawing&)> edit;
    diff::Cause cause;
    const char* body; ///< named in the findings; null: none
    diff::BodyChange::Kind kind = diff::BodyChange::Kind::moved;
};

void shader(Drawing& d, const char* line) {
    d.settings.shader_lines = line;
}

using enum diff::BodyChange::Kind;
using enum diff::Cause;

const Change changes[] = {
    {"shader: mixing", "inclined_blocks", {}, [](Drawing& d) { shader(d, "#define mix(a, b, t) mix(a, b, (t) * 0.5)\n"); }, drawing, nullptr},
    {"shader: square root", "office_toy", {}, [](Drawing& d) { shader(d, "#define sqrt(x) (0.9 * sqrt(x))\n"); }, drawing, nullptr},
    {"shader: products", "tippe_top", {}, [](Drawing& d) { shader(d, "#define max(a, b) (max(a, b) * 1.03)\n"); }, drawing, nullptr},
    {"shadow map: a sixteenth", "inclined_blocks", {}, [](Drawing& d) { d.settings.shadow_size = 64; }, drawing, nullptr},
    {"light: sun", "inclined_blocks", {"light.sun_intensity=3.6"}, {}, scene, nullptr},
    {"light: direction", "office_toy", {"light.to_sun=[-0.4, -0.6, 0.9]"}, {}, scene, nullptr},
    {"light: sky", "tippe_top", {"light.sky_intensity=1.2"}, {}, scene, nullptr},
    {"camera: opening", "inclined_blocks", {"camera.main.fov_degrees=36.5"}, {}, scene, nullptr},
    {"camera: place", "office_toy", {"camera.main.eye=[0.436, -0.90, 0.32]"}, {}, scene, nullptr},
    {"mesh: a longer block", "inclined_blocks", {}, [](Drawing& d) { std::get<sim::Box>(body(d.scene, "block 0.42").shape).half_extents *= 1.2; }, unknown, "block 0.42", recoloured},
    {"mesh: a smaller ball", "office_toy", {}, [](Drawing& d) { std::get<sim::Sphere>(body(d.scene, "ball 3").shape).radius *= 0.7; }, unknown, nullptr},
    {"solver: a block is 10 cm ahead", "inclined_blocks", {}, [](Drawing& d) { state(d, "block 0.34").position.x() += 0.1; }, simulation, "block 0.34", moved},
    {"solver: a ball swings less", "office_toy", {}, [](Drawing& d) { state(d, "ball 1").position.x() += 0.010; }, simulation, "ball 1", moved},
    {"solver: a reflecting ball is a pixel ahead", "office_toy", {}, [](Drawing& d) { state(d, "ball 3").position.x() += 0.0036; }, simulation, "ball 3", moved},
    {"solver: the top turns", "tippe_top", {}, [](Drawing& d) { state(d, "top").orientation = sim::Quat(Eigen::AngleAxisd(0.1, sim::Vec3::UnitY())) * state(d, "top").orientation; }, simulation, nullptr},
    {"scene: a body is missing", "inclined_blocks", {}, [](Drawing& d) { body(d.scene, "block 0.50").look.visible = false; }, unknown, "block 0.50", missing},
    {"scene: a post is missing", "office_toy", {}, [](Drawing& d) { body(d.scene, "post back left").look.visible = false; }, unknown, "post back left", missing},
    {"scene: another colour", "inclined_blocks", {}, [](Drawing& d) { std::swap(body(d.scene, "block 0.25").look.color.x(), body(d.scene, "block 0.25").look.color.z()); }, unknown, "block 0.25", recoloured},
    {"scene: rougher metal", "office_toy", {"body.ball 2.roughness=0.7"}, {}, scene, "ball 2", recoloured},
};

diff::Picture picture_of(const render::Image& image) {
    diff::Picture picture;
    picture.width = image.width;
    picture.height = image.height;
    picture.rgb = image.rgb;
    return picture;
}

/// Draws, keeps picture and bodies in a folder, and says what made them.
diff::Source draw(Drawing drawing, const fs::path& folder) {
    fs::create_directories(folder);
    drawing.scene.output.width = 320;
    drawing.scene.output.height = 180;
    render::Renderer renderer(drawing.scene, 320, 180, drawing.settings);
    sim::write_file(folder / "f.png", diff::encode_png(picture_of(renderer.draw(drawing.snapshot))));
    render::write_body_image(folder, "f.png", drawing.scene, drawing.snapshot, renderer.body_ids());
    diff::Source source;
    source.path = folder / "f.png";
    source.origin.state_hash = fmt::format("{:016x}", sim::state_hash(drawing.snapshot));
    source.origin.shaders_hash = render::shaders_hash() + drawing.settings.shader_lines + fmt::format("{}", drawing.settings.shadow_size);
    source.origin.renderer = renderer.renderer_string();
    source.scene_text = drawing.scene.text;
    source.overrides = drawing.scene.overrides;
    return source;
}

Drawing start_of(const std::string& scene, const std::vector<std::string>& overrides = {}) {
    Drawing drawing;
    drawing.scene = sim::load_scene(fs::path(TUMBLE_SCENE_DIR) / (scene + ".toml"), overrides);
    drawing.snapshot = sim::World(drawing.scene).take_snapshot();
    return drawing;
}

diff::Frame compared(const diff::Picture& a, const diff::Picture& b) {
    diff::DifferenceMap map;
    diff::Frame frame;
    diff::judge(a, b, {}, map, frame);
    return frame;
}

template <typename Change>
diff::Picture each_channel(diff::Picture picture, Change change) {
    for (std::uint8_t& v : picture.rgb) {
        v = static_cast<std::uint8_t>(std::clamp<int>(change(v), 0, 255));
    }
    return picture;
}

/// Of a picture `factor` times as large: the mean of the samples of each pixel that `takes` says.
diff::Picture sampled(const diff::Picture& large, int factor, const std::function<bool(int x, int y)>& takes) {
    diff::Picture picture;
    picture.width = large.width / factor;
    picture.height = large.height / factor;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                int sum = 0;
                int count = 0;
                for (int j = 0; j < factor; ++j) {
                    for (int i = 0; i < factor; ++i) {
                        if (takes(i, j)) {
                            sum += large.rgb[static_cast<std::size_t>(((y * factor + j) * large.width + x * factor + i) * 3 + c)];
                            ++count;
                        }
                    }
                }
                picture.rgb.push_back(static_cast<std::uint8_t>((sum + count / 2) / count));
            }
        }
    }
    return picture;
}

} // namespace

TEST(mutations, deliberate_changes_are_caught_and_named) {
    const fs::path folder = test::out_folder("mutations");
    fs::remove_all(folder);
    for (const Change& change : changes) {
        SCOPED_TRACE(change.name);
        const diff::Source before = draw(start_of(change.scene), folder / "before");
        Drawing drawing = start_of(change.scene, change.overrides);
        if (change.edit) {
            change.edit(drawing);
        }
        const diff::Source after = draw(drawing, folder / "after");
        diff::Case result;
        result.frames.resize(1);
        diff::PairMemory memory;
        diff::Frame& frame = result.frames[0];
        diff::compare_files({before.path, after.path}, {}, memory, frame);
        EXPECT_EQ(frame.tier, diff::Tier::changed) << frame.message;
        result.tier = frame.tier;
        diff::find_cause(before, after, result);
        EXPECT_STREQ(diff::name_of(result.cause), diff::name_of(change.cause));
        if (change.body != nullptr) {
            const auto named = std::find_if(frame.bodies.begin(), frame.bodies.end(), [&](const diff::BodyChange& b) { return b.name == change.body; });
            ASSERT_NE(named, frame.bodies.end()) << frame.message;
            EXPECT_STREQ(diff::name_of(named->kind), diff::name_of(change.kind));
        }
    }
}

TEST(mutations, harmless_differences_are_noise) {
    // No scene with rods thinner than a pixel: they are drawn one pixel wide, in larger pictures thinner.
    for (const char* name : {"inclined_blocks", "tippe_top"}) {
        const Drawing drawing = start_of(name);
        render::Renderer renderer(drawing.scene, 320, 180);
        const diff::Picture picture = picture_of(renderer.draw(drawing.snapshot));
        render::Renderer large_renderer(drawing.scene, 1280, 720);
        const diff::Picture large = picture_of(large_renderer.draw(drawing.snapshot));
        std::mt19937 random(7);
        const auto one_in = [&random](unsigned n) { return random() % n == 0; };
        const std::pair<const char*, diff::Picture> harmless[] = {
            {"one level up in some channels", each_channel(picture, [&](int v) { return v + one_in(5); })},
            {"one level up or down", each_channel(picture, [&](int v) { return v + static_cast<int>(random() % 3) - 1; })},
            {"grain of up to 3 levels", each_channel(picture, [&](int v) { return v + static_cast<int>(random() % 7) - 3; })},
            {"single channels 31 levels off", each_channel(picture, [&](int v) { return one_in(4000) ? v + 31 : v; })},
            {"16 samples in a grid", sampled(large, 4, [](int, int) { return true; })},
            {"4 samples on a rotated grid", sampled(large, 4, [](int x, int y) { return (y == 0 && x == 1) || (y == 1 && x == 3) || (y == 2 && x == 0) || (y == 3 && x == 2); })},
            {"4 samples on the other diagonal", sampled(large, 4, [](int x, int y) { return (y == 0 && x == 2) || (y == 1 && x == 0) || (y == 2 && x == 3) || (y == 3 && x == 1); })},
            {"4 samples in the middle", sampled(large, 4, [](int x, int y) { return x % 3 != 0 && y % 3 != 0; })},
            {"4 samples in the corners", sampled(large, 4, [](int x, int y) { return x % 3 == 0 && y % 3 == 0; })},
            {"8 samples in a chequered pattern", sampled(large, 4, [](int x, int y) { return (x + y) % 2 == 0; })},
            {"2 samples on the diagonal", sampled(large, 4, [](int x, int y) { return x == y && x % 3 != 0; })},
        };
        for (const auto& [what, other] : harmless) {
            const diff::Frame frame = compared(picture, other);
            EXPECT_EQ(frame.tier, diff::Tier::noise) << name << ", " << what << ": " << frame.message;
        }
    }
}
