// What is drawn over the pictures, from the command line to the frames.
#include "render/film/video_reader.h"
#include "tests/program/program_fixture.h"

using namespace test;

namespace {

/// Everything over the picture, with records between the frames; a second camera.
constexpr const char* rich_scene = R"(
[overlay]
show = ["title", "time", "contacts", "energy", "points", "normals", "impulses", "trails", "contact_paths", "plots"]
[[plot]]
quantity = "inclination"
bodies = ["block"]
[[plot]]
quantity = "contacts"
[[camera]]
name = "main"
eye = [4, -6, 3]
target = [0, 0, 0.5]
[[camera]]
name = "from \"above\""
eye = [0, -1, 9]
target = [0, 0, 0]
)";

class overlay_program : public Program {
protected:
    void SetUp() override {
        Program::SetUp();
        std::string text = std::string(scene_text) + rich_scene;
        text.insert(text.find("width"), "record_every = 5\n");
        sim::write_file(folder / "rich.toml", text);
    }
};

} // namespace

TEST_F(overlay_program, run_later_rendering_and_slices_draw_the_same_frames) {
    ASSERT_EQ(tumble("run rich.toml --out whole").code, 0);
    ASSERT_EQ(tumble("render whole/rich/trajectory.h5 --out later").code, 0);
    ASSERT_EQ(tumble("run rich.toml --frames 5:8 --out slice").code, 0);
    ASSERT_EQ(tumble("render whole/rich/trajectory.h5 --frames 5:8 --out late_slice").code, 0);
    ASSERT_EQ(tumble("run rich.toml --show none --out plain").code, 0);
    for (int k = 0; k < frame_count; ++k) {
        const std::string name = "rich/" + render::frame_file_name(k);
        EXPECT_TRUE(bytes("whole/" + name) == bytes("later/" + name)) << k;
        EXPECT_FALSE(bytes("whole/" + name) == bytes("plain/" + name)) << k;
        if (k >= 5) {
            EXPECT_TRUE(bytes("whole/" + name) == bytes("slice/" + name)) << k;
            EXPECT_TRUE(bytes("whole/" + name) == bytes("late_slice/" + name)) << k;
        }
    }
}

TEST_F(overlay_program, contacts_that_were_not_recorded_are_refused_by_name) {
    ASSERT_EQ(tumble("simulate block.toml").code, 0);
    const Outcome outcome = tumble("render out/block/trajectory.h5 --show points");
    EXPECT_EQ(outcome.code, 2);
    expect_one_line(outcome.err);
    EXPECT_NE(outcome.err.find("has not recorded the contacts"), std::string::npos) << outcome.err;
    EXPECT_EQ(tumble("render out/block/trajectory.h5 --show title,time,energy,trails").code, 0);
}

TEST_F(overlay_program, options_choose_camera_layers_and_colours) {
    ASSERT_EQ(tumble("run rich.toml --show none --out plain --no-video").code, 0);
    const std::string frame = "rich/" + render::frame_file_name(7);
    for (const std::string option : {"--camera 'from \"above\"'", "--color-by speed", "--show time"}) {
        const std::string show = option == "--show time" ? "" : " --show none ";
        ASSERT_EQ(tumble("render plain/rich/trajectory.h5 --out other --no-video " + option + show).code, 0);
        EXPECT_FALSE(bytes("plain/" + frame) == bytes("other/" + frame)) << option;
    }
    const Outcome camera = tumble("check rich.toml --camera side");
    EXPECT_EQ(camera.code, 2);
    EXPECT_NE(camera.err.find("there is no camera 'side'"), std::string::npos) << camera.err;
    const Outcome show = tumble("check rich.toml --show time,titel");
    EXPECT_EQ(show.code, 2);
    EXPECT_NE(show.err.find("did you mean 'title'?"), std::string::npos) << show.err;
}

TEST_F(overlay_program, poster_sheet_and_animation_come_from_the_same_run_and_from_join) {
    const std::string stills = " --poster 0.25 --sheet 5 --webp";
    ASSERT_EQ(tumble("run block.toml --out a" + stills).code, 0);
    ASSERT_EQ(tumble("join a/block --out b" + stills).code, 0);
    for (const std::string name : {"block/block_poster.png", "block/block_sheet.png", "block/block.webp"}) {
        EXPECT_TRUE(bytes("a/" + name) == bytes("b/" + name)) << name;
    }
    // Frame 5 of 20 a second; three columns and two rows with gaps of 8 px, none enlarged.
    EXPECT_TRUE(bytes("a/block/block_poster.png") == bytes("a/block/" + render::frame_file_name(5)));
    const render::Image sheet = render::read_image(folder / "a/block/block_sheet.png");
    EXPECT_EQ(sheet.width, 3 * 328 + 8);
    EXPECT_EQ(sheet.height, 2 * 188 + 8);
    const render::Image last = render::read_image(folder / "a/block" / render::frame_file_name(7));
    const std::size_t corner = 3 * (static_cast<std::size_t>(196) * sheet.width + 336);
    EXPECT_TRUE(std::equal(last.rgb.begin(), last.rgb.begin() + 3 * 320,
                           sheet.rgb.begin() + static_cast<long>(corner)));
    EXPECT_EQ(bytes("a/block/block.webp").substr(0, 4), "RIFF");
    EXPECT_NE(bytes("a/block/block.webp").find("ANIM"), std::string::npos);
    // A later run without them leaves none behind.
    ASSERT_EQ(tumble("run block.toml --out a").code, 0);
    EXPECT_EQ(files_in("a/block"), expected_files());
}

/// Mean difference of display values.
double difference_of(const render::Image& a, const render::Image& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.rgb.size() && a.rgb.size() == b.rgb.size(); ++i) {
        sum += std::abs(a.rgb[i] - b.rgb[i]);
    }
    return a.rgb.size() == b.rgb.size() ? sum / static_cast<double>(a.rgb.size()) : 255.0;
}

TEST_F(overlay_program, an_animation_has_the_size_and_rate_asked_for) {
    const std::string stills = " --webp --gif --animation-width 1000 --animation-fps 8";
    ASSERT_EQ(tumble("run block.toml --out a" + stills).code, 0);
    ASSERT_EQ(tumble("join a/block --out b" + stills).code, 0);
    for (const std::string name : {"block/block.webp", "block/block.gif"}) {
        EXPECT_TRUE(bytes("a/" + name) == bytes("b/" + name)) << name;
    }
    // Of 8 frames, 20 a second: 0, 3, 5, 7. As wide as they are, in 256 colours.
    render::VideoReader reader(folder / "a/block/block.gif");
    render::Image image;
    for (const int frame : {0, 3, 5, 7}) {
        ASSERT_TRUE(reader.read(image)) << frame;
        const render::Image drawn = render::read_image(folder / "a/block" / render::frame_file_name(frame));
        EXPECT_EQ(image.width, drawn.width);
        EXPECT_LT(difference_of(image, drawn), 6.0) << frame;
    }
    EXPECT_FALSE(reader.read(image));
    EXPECT_NE(bytes("a/block/block.gif").find("NETSCAPE2.0"), std::string::npos); // played for ever
    ASSERT_EQ(tumble("join a/block --gif --animation-width 100 --quiet").code, 0);
    const Outcome alone = tumble("join a/block --animation-fps 5");
    EXPECT_EQ(alone.code, 2);
    expect_one_line(alone.err);
}

TEST_F(overlay_program, passes_lie_beside_their_frames_until_a_run_without_them) {
    ASSERT_EQ(tumble("run block.toml --out p --no-video --passes depth,rgba,depth16,rgb16").code, 0);
    std::set<std::string> found = files_in("p/block");
    for (const char* name : {"frames/frame_000007.exr", "frames/frame_000007.rgba.png", "frames/frame_000007.depth.png",
                             "frames/frame_000007.rgb16.png"}) {
        EXPECT_TRUE(found.contains(name)) << name;
    }
    // One that is missing is drawn again.
    std::filesystem::remove(folder / "p/block/frames/frame_000003.depth.png");
    ASSERT_EQ(tumble("run block.toml --out p --no-video --passes depth,rgba,depth16,rgb16 --resume").code, 0);
    EXPECT_EQ(files_in("p/block"), found);
    ASSERT_EQ(tumble("run block.toml --out p --no-video --passes rgba").code, 0);
    found = files_in("p/block");
    EXPECT_TRUE(found.contains("frames/frame_000007.rgba.png"));
    EXPECT_FALSE(found.contains("frames/frame_000007.exr"));
    EXPECT_FALSE(found.contains("frames/frame_000007.depth.png"));
    EXPECT_FALSE(found.contains("frames/frame_000007.rgb16.png"));
}

TEST_F(overlay_program, stills_without_the_frames_are_refused) {
    for (const char* options :
         {"--poster 0 --no-png", "--sheet 4 --frames 0:3", "--sheet 0", "--poster -1"}) {
        const Outcome outcome = tumble("run block.toml " + std::string(options));
        EXPECT_EQ(outcome.code, 2) << options;
        expect_one_line(outcome.err);
    }
    EXPECT_EQ(files_in("out"), std::set<std::string>{});
}
