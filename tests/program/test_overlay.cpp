// What is drawn over the pictures, from the command line to the frames.
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
