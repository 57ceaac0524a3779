/// Going on after an interruption, slices of a film, and joining them.
#include "render/picture/image.h"
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

namespace fs = std::filesystem;
using test::expect_one_line;
using test::Outcome;

namespace {

class resume : public test::Program {
protected:
    /// All files of a whole run but its times.
    void expect_same_results(const std::string& a, const std::string& b) const {
        EXPECT_EQ(files_in(a), expected_files());
        EXPECT_EQ(files_in(b), expected_files());
        for (const std::string& name : expected_files()) {
            if (name != "summary.json") {
                EXPECT_TRUE(bytes(a + "/" + name) == bytes(b + "/" + name)) << name;
            }
        }
        const auto summary = [this](const std::string& run) {
            nlohmann::json json = nlohmann::json::parse(bytes(run + "/summary.json"));
            json.erase("wall_time_s");
            json.erase("stage_ms_per_step");
            json.erase("picture_ms_per_frame");
            return json;
        };
        EXPECT_EQ(summary(a), summary(b));
    }
};

} // namespace

TEST_F(resume, a_killed_run_goes_on_and_ends_with_the_same_bytes) {
    ASSERT_EQ(tumble("run block.toml --out whole").code, 0);
    // The simulation is slowed by tiny steps so that the kill comes in between; it is run again, frames are
    // kept.
    shell("\"$TUMBLE\" run block.toml --quiet & process=$!\n"
          "until [ -e out/block/frames/frame_000002.png ]; do sleep 0.001; done\n"
          "kill -KILL $process; wait $process");
    ASSERT_TRUE(fs::exists(folder / "out/block/frames/frame_000001.png"));
    const fs::file_time_type time = fs::last_write_time(folder / "out/block/frames/frame_000001.png");
    const Outcome outcome = tumble("run block.toml --resume");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(fs::last_write_time(folder / "out/block/frames/frame_000001.png"), time);
    expect_same_results("whole/block", "out/block");
}

TEST_F(resume, without_an_earlier_run_it_starts_from_nothing) {
    ASSERT_EQ(tumble("run block.toml --out whole").code, 0);
    ASSERT_EQ(tumble("run block.toml --resume").code, 0);
    expect_same_results("whole/block", "out/block");
}

TEST_F(resume, a_damaged_or_missing_frame_is_drawn_again) {
    ASSERT_EQ(tumble("run block.toml --out whole").code, 0);
    ASSERT_EQ(tumble("run block.toml").code, 0);
    fs::resize_file(folder / "out/block/frames/frame_000003.png", 700);
    fs::remove(folder / "out/block/frames/frame_000005.png");
    ASSERT_EQ(tumble("run block.toml --resume").code, 0);
    expect_same_results("whole/block", "out/block");
}

TEST_F(resume, other_settings_are_refused_by_name_and_nothing_is_removed) {
    ASSERT_EQ(tumble("run block.toml").code, 0);
    const Outcome tolerance = tumble("run block.toml --resume --tolerance 1e-6");
    EXPECT_EQ(tolerance.code, 2);
    expect_one_line(tolerance.err);
    EXPECT_NE(tolerance.err.find("cannot go on in out/block: simulation.tolerance is 1e-06, was not set"),
              std::string::npos)
        << tolerance.err;
    const Outcome slice = tumble("run block.toml --frames 0:2 --size 640x360");
    EXPECT_EQ(slice.code, 2);
    EXPECT_NE(slice.err.find("output.width is 640, was 320"), std::string::npos) << slice.err;
    EXPECT_EQ(files_in("out/block"), expected_files());
}

TEST_F(resume, frames_without_a_record_are_not_used) {
    ASSERT_EQ(tumble("run block.toml").code, 0);
    fs::remove(folder / "out/block/frames/run.json");
    const Outcome outcome = tumble("run block.toml --resume");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("of an unknown run"), std::string::npos) << outcome.err;
}

TEST_F(resume, slices_of_several_processes_at_once_join_to_the_same_film) {
    ASSERT_EQ(tumble("run block.toml --out whole").code, 0);
    const Outcome outcome = shell("\"$TUMBLE\" run block.toml --frames 0:3 & a=$!\n"
                                  "\"$TUMBLE\" run block.toml --frames 3:7 & b=$!\n"
                                  "\"$TUMBLE\" run block.toml --frames 7:8 & c=$!\n"
                                  "wait $a && wait $b && wait $c && \"$TUMBLE\" join out/block");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    std::set<std::string> expected = expected_files();
    expected.erase("trajectory.h5");
    expected.erase("summary.json");
    EXPECT_EQ(files_in("out/block"), expected);
    for (const std::string& name : expected) {
        EXPECT_TRUE(bytes("whole/block/" + name) == bytes("out/block/" + name)) << name;
    }
}

TEST_F(resume, slices_in_several_folders_and_of_a_trajectory_join_to_the_same_film) {
    ASSERT_EQ(tumble("run block.toml --out whole").code, 0);
    ASSERT_EQ(tumble("run block.toml --frames 0:5 --out a").code, 0);
    ASSERT_EQ(tumble("render whole/block/trajectory.h5 --frames 5:8 --out b").code, 0);
    const Outcome outcome = tumble("join a/block b/block --out c");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(bytes("c/block/block.mp4") == bytes("whole/block/block.mp4"));
}

TEST_F(resume, join_refuses_missing_frames_other_sizes_and_other_settings) {
    ASSERT_EQ(tumble("run block.toml --frames 0:5 --out a").code, 0);
    const Outcome missing = tumble("join a/block");
    EXPECT_EQ(missing.code, 4);
    EXPECT_NE(missing.err.find("frame 5 of 8 is missing"), std::string::npos) << missing.err;
    ASSERT_EQ(tumble("run block.toml --frames 5:8 --out b --fps 20.0 --set simulation.time_step=0.002").code,
              0);
    const Outcome other = tumble("join a/block b/block");
    EXPECT_EQ(other.code, 2);
    EXPECT_NE(other.err.find("simulation.time_step is 0.002, was not set"), std::string::npos) << other.err;
    EXPECT_EQ(tumble("join nowhere").code, 3);
    ASSERT_EQ(tumble("run block.toml --out a").code, 0);
    sim::write_file(folder / "a/block/frames/frame_000004.png", render::encode_png(render::Image(16, 9)));
    const Outcome size = tumble("join a/block");
    EXPECT_EQ(size.code, 4);
    EXPECT_NE(size.err.find("frame_000004.png has 16x9 pixels, expected 320x180"), std::string::npos)
        << size.err;
}

TEST_F(resume, wrong_frame_ranges_are_refused) {
    for (const char* range : {"3", "3:3", "5:3", "0:9", "-1:3", "a:b", "1:2:3"}) {
        const Outcome outcome = tumble("run block.toml --frames=" + std::string(range));
        EXPECT_EQ(outcome.code, 2) << range;
        EXPECT_NE(outcome.err.find("expected A:B with 0 <= A < B <= 8"), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(tumble("run block.toml --frames 0:2 --no-png").code, 2);
    EXPECT_FALSE(fs::exists(folder / "out"));
}
