/// tumble export and the page on trajectory.h5: what other programs read.
#include "render/film/video_reader.h"
#include "sim/base/file_io.h"
#include "sim/record/trajectory.h"
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <stdexcept>
#include <vector>

using test::Outcome;
using Json = nlohmann::json;

namespace {

/// A binary glTF file: a head of 12 bytes, and chunks of length, kind and content.
struct Glb {
    Json json;
    std::string data;

    explicit Glb(const std::string& bytes) {
        const auto number = [&](std::size_t at) {
            std::uint32_t value = 0;
            std::memcpy(&value, bytes.data() + at, 4);
            return value;
        };
        if (bytes.substr(0, 4) != "glTF" || number(4) != 2 || number(8) != bytes.size()) {
            throw std::runtime_error("no glTF 2.0");
        }
        const std::size_t length = number(12);
        json = Json::parse(bytes.substr(20, length));
        data = bytes.substr(28 + length, number(20 + length));
    }

    /// Numbers of an accessor.
    std::vector<float> floats(std::size_t accessor) const {
        const Json& of = json["accessors"][accessor];
        const Json& view = json["bufferViews"][of["bufferView"].get<std::size_t>()];
        std::vector<float> values(view["byteLength"].get<std::size_t>() / sizeof(float));
        std::memcpy(values.data(), data.data() + view.value("byteOffset", std::size_t{0}),
                    values.size() * sizeof(float));
        return values;
    }
};

/// The position of a node at a time, as a player of the animation computes it.
sim::Vec3 animated(const Glb& glb, std::size_t node, double time) {
    for (const Json& channel : glb.json["animations"][0]["channels"]) {
        if (channel["target"]["node"] != node || channel["target"]["path"] != "translation") {
            continue;
        }
        const Json& sampler = glb.json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
        const std::vector<float> times = glb.floats(sampler["input"]), values = glb.floats(sampler["output"]);
        std::size_t k = 0;
        while (k + 2 < times.size() && static_cast<double>(times[k + 1]) <= time) {
            ++k;
        }
        const double share = (time - times[k]) / (times[k + 1] - times[k]);
        sim::Vec3 at;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            at[static_cast<int>(axis)] =
                (1.0 - share) * values[3 * k + axis] + share * values[3 * (k + 1) + axis];
        }
        return at;
    }
    throw std::runtime_error("not animated");
}

} // namespace

class exports : public test::Program {};

TEST_F(exports, gltf_moves_every_body_as_it_was_recorded) {
    ASSERT_EQ(tumble("simulate block.toml --quiet").code, 0);
    const Outcome outcome = tumble("export out/block --gltf block.glb");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const Glb glb(bytes("block.glb"));
    EXPECT_EQ(glb.json["asset"]["version"], "2.0");
    EXPECT_EQ(glb.json["animations"].size(), 1u);
    EXPECT_EQ(glb.json["cameras"].size(), 1u);
    const sim::TrajectoryReader trajectory(folder / "out/block/trajectory.h5");
    std::size_t node = 0;
    std::size_t body = 0;
    while (trajectory.info().body_masses[body] == 0.0) {
        ++body;
    }
    while (glb.json["nodes"][node]["name"] != trajectory.info().body_names[body]) {
        ++node;
    }
    for (std::size_t record = 0; record < trajectory.steps().size(); ++record) {
        const sim::Snapshot state = trajectory.read(record);
        // A tenth of the tolerance of 1e-4 m, and the rounding of floats of a few metres.
        EXPECT_LT((animated(glb, node, state.time) - state.bodies[body].position).norm(), 1e-5 + 2e-6)
            << record;
    }
}

TEST_F(exports, an_opening_that_gltf_cannot_move_is_told) {
    constexpr const char* camera = R"(
[[camera]]
name = "zoom"
keys = [{ time = 0, eye = [4, -7, 3], target = [0, 0, 0] },
        { time = 0.1, eye = [4, -7, 3], target = [0, 0, 0], fov_degrees = 20 }]
)";
    sim::write_file(folder / "zoom.toml", bytes("block.toml") + camera);
    ASSERT_EQ(tumble("simulate block.toml zoom.toml --quiet").code, 0);
    EXPECT_NE(
        tumble("export out/zoom --gltf zoom.glb").out.find("glTF moves no camera's opening: that of 'zoom'"),
        std::string::npos);
    EXPECT_EQ(tumble("export out/block --gltf block.glb").out.find("opening"), std::string::npos);
}

TEST_F(exports, csv_has_a_row_a_body_and_record) {
    ASSERT_EQ(tumble("simulate block.toml --quiet").code, 0);
    ASSERT_EQ(tumble("export out/block --csv block.csv").code, 0);
    const std::string text = bytes("block.csv");
    EXPECT_EQ(tumble("export out/block/trajectory.h5 --csv -").out, text);
    const sim::TrajectoryReader trajectory(folder / "out/block/trajectory.h5");
    std::istringstream lines(text);
    std::string line;
    std::getline(lines, line);
    EXPECT_TRUE(line.starts_with("step,time_s,body,x_m,y_m,z_m,qw,")) << line;
    std::size_t rows = 0;
    while (std::getline(lines, line)) {
        ++rows;
    }
    EXPECT_EQ(rows, trajectory.steps().size() * trajectory.info().body_names.size());
}

/// A ball that is released at 0.25 s, and one after the end.
TEST_F(exports, what_is_released_later_is_not_there_before) {
    sim::write_file(folder / "late.toml", R"([output]
duration = 0.5
fps = 20
[[lattice]]
name = "ball"
count = [1, 1, 2]
spacing = [1, 1, 0]
release = 0.25
release_interval = 1
body = { shape = { kind = "sphere", radius = 0.1 } }
)");
    ASSERT_EQ(tumble("simulate late.toml --quiet").code, 0);
    ASSERT_EQ(tumble("export out/late --csv late.csv --gltf late.glb").code, 0);
    const std::string table = bytes("late.csv");
    EXPECT_NE(table.find("\n250,0.25,\"ball_0\",0,0,0,1,"), std::string::npos) << table;
    EXPECT_EQ(table.find("\n200,"), std::string::npos);
    EXPECT_EQ(table.find("ball_1"), std::string::npos);
    const Glb glb(bytes("late.glb"));
    std::vector<std::vector<float>> hidden_until;
    for (const Json& channel : glb.json["animations"][0]["channels"]) {
        const Json& sampler = glb.json["animations"][0]["samplers"][channel["sampler"].get<std::size_t>()];
        if (channel["target"]["path"] == "scale") {
            EXPECT_EQ(sampler["interpolation"], "STEP");
            hidden_until.push_back(glb.floats(sampler["input"]));
            EXPECT_EQ(glb.floats(sampler["output"])[0], 0.0f);
        }
    }
    EXPECT_EQ(hidden_until, (std::vector<std::vector<float>>{{0.0f, 0.25f}, {0.0f}}));
}

TEST_F(exports, what_cannot_be_made_is_refused) {
    EXPECT_EQ(tumble("export out/block").err, "tumble: export: expected --gltf FILE or --csv FILE\n");
    EXPECT_EQ(tumble("export out/block --gltf x.gltf").err,
              "tumble: --gltf 'x.gltf': expected a name that ends in .glb\n");
    EXPECT_EQ(tumble("export nowhere --csv x.csv").code, 3);
    EXPECT_FALSE(std::filesystem::exists(folder / "x.csv"));
}

/// The example of the page, as it stands there; by the Python whose h5py is a package of Debian.
TEST_F(exports, the_example_for_h5py_runs) {
    ASSERT_EQ(tumble("simulate block.toml --quiet").code, 0);
    const std::string page = sim::read_text_file(TUMBLE_SOURCE_DIR "/sim/record/README.md");
    const std::string head = "```python\n";
    const std::size_t from = page.find(head) + head.size();
    sim::write_file(folder / "example.py", page.substr(from, page.find("```", from) - from));
    const Outcome outcome = shell("/usr/bin/python3 example.py out/block/trajectory.h5");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(outcome.out.starts_with("block to ")) << outcome.out;
    EXPECT_NE(outcome.out.find(" falls "), std::string::npos) << outcome.out;
}

/// Two films of different rates and sizes: a second of either is a second of both.
TEST_F(exports, films_run_side_by_side_in_step) {
    ASSERT_EQ(tumble("run block.toml --size 96x54 --out a --quiet").code, 0);
    ASSERT_EQ(tumble("run block.toml --size 64x64 --fps 10 --out b --quiet").code, 0);
    ASSERT_EQ(tumble("side-by-side a/block b/block --label one --label two -o both.mp4").out,
              "both.mp4: 8 frames of 2 films\n");
    render::VideoReader reader(folder / "both.mp4");
    EXPECT_EQ(reader.fps(), 20.0);
    std::vector<render::Image> frames;
    for (render::Image image; reader.read(image);) {
        frames.push_back(image);
    }
    ASSERT_EQ(frames.size(), 8u);
    EXPECT_EQ(frames[0].width, 192);
    const int strip = frames[0].height - 64; // with the labels, above the pictures
    EXPECT_GT(strip, 20);
    EXPECT_LT(strip, 32);
    const auto brightest = [&](int top, int bottom) {
        const auto row = [&](int y) { return frames[0].rgb.begin() + 3 * 192 * y; };
        return *std::max_element(row(top), row(bottom));
    };
    EXPECT_GT(brightest(0, strip), 200);
    EXPECT_LT(brightest(strip, strip + 16), 200);
    // The right half changes each second frame only; the left half each frame. Lossy: beyond 8 of 255.
    const auto change = [&](std::size_t k, int from, int to) {
        int most = 0;
        for (int y = strip; y < strip + 64; ++y) {
            for (int x = from; x < to; ++x) {
                const std::size_t at = 3 * static_cast<std::size_t>(y * 192 + x);
                most = std::max(most, std::abs(frames[k].rgb[at] - frames[k - 1].rgb[at]));
            }
        }
        return most;
    };
    EXPECT_GT(change(1, 0, 96), 16);
    EXPECT_LE(change(1, 96, 192), 8);
    EXPECT_GT(change(2, 96, 192), 16);
    EXPECT_EQ(tumble("side-by-side a/block -o x.mp4").code, 2);
    EXPECT_EQ(tumble("side-by-side a/block b/nowhere -o x.mp4").code, 3);
    EXPECT_FALSE(std::filesystem::exists(folder / "x.mp4"));
}
