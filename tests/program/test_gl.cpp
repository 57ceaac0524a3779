/// What OpenGL is had from: OSMesa, EGL in software, graphics cards. Where there is no card, EGL's device that draws in
/// software passes for one (tests/tools/pretend_card.cpp).
#include "tests/program/program_fixture.h"

#include <sstream>
#include <unistd.h>
#include <vector>

namespace fs = std::filesystem;

using test::expect_one_line;
using test::Outcome;

namespace {

/// Before a command: egl:0 is the device that passes for a card.
constexpr const char* with_card = "LD_PRELOAD='" TUMBLE_CARD "' ";

class gl : public test::Program {
protected:
    void SetUp() override {
        Program::SetUp();
        if (shell("/sbin/ldconfig -p | grep -q libOSMesa.so.8").code != 0) {
            GTEST_SKIP() << "no OSMesa beside EGL here";
        }
    }

    /// All frames, and the film if there is one, are the same.
    void expect_same_pictures(const std::string& a, const std::string& b) const {
        const std::set<std::string> names = files_in(a);
        EXPECT_EQ(names, files_in(b));
        for (const std::string& name : names) {
            if (name.ends_with(".png") || name.ends_with(".mp4")) {
                EXPECT_TRUE(bytes(a + "/" + name) == bytes(b + "/" + name)) << name;
            }
        }
    }
};

TEST_F(gl, what_there_is_is_listed) {
    const Outcome outcome = shell(std::string(with_card) + "\"$TUMBLE\" devices");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::istringstream lines(outcome.out);
    std::vector<std::string> words;
    int automatic = 0;
    for (std::string line; std::getline(lines, line);) {
        words.push_back(line.substr(0, line.find(' ')));
        automatic += line.ends_with("; auto takes it") ? 1 : 0;
        EXPECT_NE(line.find(words.back() == "egl:0" ? "; graphics card" : "; in software"), std::string::npos) << line;
        EXPECT_NE(line.find(", OpenGL "), std::string::npos) << line;
    }
    EXPECT_EQ(automatic, 1);
    EXPECT_EQ(words, (std::vector<std::string>{"osmesa", "egl", "egl:0"}));
}

TEST_F(gl, a_film_read_through_buffers_is_the_same_film) {
    // Depths, several pictures a frame, and without part numbers.
    const std::string runs[] = {"--show points,time", "--set output.shutter=0.5 --set output.subframes=3",
                                "--preset draft --size 320x180"};
    for (const std::string& run : runs) {
        ASSERT_EQ(tumble("run block.toml --quiet --gl osmesa --out a " + run).code, 0);
        const Outcome outcome =
            shell(with_card + ("\"$TUMBLE\" run block.toml --quiet --gl egl:0 --out b " + run));
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        expect_same_pictures("a/block", "b/block");
    }
}

TEST_F(gl, what_draws_is_no_part_of_a_scene) {
    ASSERT_EQ(tumble("run block.toml --quiet --frames 0:4 --gl egl").code, 0);
    const Outcome outcome = tumble("run block.toml --quiet --resume --gl osmesa");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    ASSERT_EQ(tumble("run block.toml --quiet --out whole --set output.gl=egl").code, 0);
    EXPECT_EQ(bytes("out/block/frames/frame_000003.png"), bytes("whole/block/frames/frame_000003.png"));
}

TEST_F(gl, a_driver_that_is_lost_leaves_whole_frames_and_the_run_goes_on) {
    ASSERT_EQ(tumble("run block.toml --quiet --out whole").code, 0);
    const Outcome outcome =
        shell(with_card + std::string("CARD_LOST_AFTER=18 \"$TUMBLE\" run block.toml --quiet --gl egl:0"));
    EXPECT_EQ(outcome.code, 3);
    EXPECT_TRUE(outcome.err == "tumble: the driver of egl:0 was lost while drawing a frame\n" ||
                outcome.err == "tumble: the driver of egl:0 was lost while reading a frame\n")
        << outcome.err;
    const std::size_t kept = files_in("out/block/frames").size();
    EXPECT_GT(kept, 1u) << "run.json alone";
    EXPECT_LT(kept, 1u + test::frame_count);
    const Outcome resumed = tumble("run block.toml --quiet --resume");
    EXPECT_EQ(resumed.code, 0) << resumed.err;
    EXPECT_EQ(files_in("out/block"), expected_files());
    expect_same_pictures("whole/block", "out/block");
}

TEST_F(gl, a_device_that_cannot_draw_is_told_before_anything_is_made) {
    struct Case {
        const char* environment;
        const char* arguments;
        const char* message;
    };
    const Case cases[] = {
        {"", "--gl egl:7", "there is no graphics card egl:7: EGL finds "},
        {"__EGL_VENDOR_LIBRARY_DIRS=/nowhere", "--gl egl", "EGL: it has neither a device that draws in software nor "},
        {"MESA_GL_VERSION_OVERRIDE=3.1", "--gl egl", "EGL: its driver gives no OpenGL 4.2 core context"},
        {"MESA_GL_VERSION_OVERRIDE=3.1", "--gl osmesa", "OSMesa gives no OpenGL 4.2 core context"},
        {"MESA_EXTENSION_OVERRIDE=-GL_ARB_clip_control MESA_GL_VERSION_OVERRIDE=4.2", "--gl egl", "egl (llvmpipe"},
    };
    for (const Case& c : cases) {
        const Outcome outcome =
            shell(std::string(c.environment) + " \"$TUMBLE\" run block.toml --quiet " + c.arguments);
        EXPECT_EQ(outcome.code, 3) << c.message;
        EXPECT_TRUE(outcome.err.starts_with(std::string("tumble: ") + c.message)) << outcome.err;
        expect_one_line(outcome.err);
        EXPECT_FALSE(fs::exists(folder / "out/block/frames/run.json"));
    }
}

TEST_F(gl, a_card_whose_file_may_not_be_opened_is_told) {
    // Root may open every file, unless that right is taken from it.
    const std::string without_right =
        geteuid() == 0 ? "setpriv --inh-caps -all --bounding-set -dac_override,-dac_read_search " : "";
    const Outcome outcome = shell("touch card; chmod 0 card; CARD_NODE=card " + std::string(with_card) + without_right +
                                  "\"$TUMBLE\" run block.toml --quiet --gl egl:0");
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.err, "tumble: EGL of card: Permission denied\n");
}

TEST_F(gl, where_there_is_no_osmesa_egl_draws_the_same) {
    ASSERT_EQ(tumble("run block.toml --quiet --out a --gl osmesa").code, 0);
    const std::string without = std::string("HIDDEN_LIBRARY=OSMesa ") + with_card + "\"$TUMBLE\" ";
    const Outcome outcome = shell(without + "run block.toml --quiet --out b");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    expect_same_pictures("a/block", "b/block");
    const Outcome asked = shell(without + "run block.toml --quiet --out c --gl osmesa");
    EXPECT_EQ(asked.code, 3);
    EXPECT_EQ(asked.err,
              "tumble: OSMesa cannot be loaded: libHidden.so: cannot open shared object file: No such file or "
              "directory\n");
    const std::string devices = shell(without + "devices").out;
    EXPECT_TRUE(devices.starts_with("osmesa  cannot be used: OSMesa cannot be loaded: ")) << devices;
    EXPECT_NE(devices.find("; in software; auto takes it\negl:0"), std::string::npos) << devices;
}

TEST_F(gl, what_draws_nothing_loads_no_osmesa) {
    const Outcome outcome = shell("LD_DEBUG=files \"$TUMBLE\" check block.toml");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.err.find("libEGL"), std::string::npos);
    EXPECT_EQ(outcome.err.find("OSMesa"), std::string::npos);
}

class encoder : public test::Program {};

TEST_F(encoder, that_is_not_there_is_told_and_keeps_the_film_of_before) {
    ASSERT_EQ(tumble("run block.toml --quiet --duration 0.1").code, 0);
    const std::string film = bytes("out/block/block.mp4");
    for (const char* verb : {"run block.toml", "render out/block/trajectory.h5"}) {
        const Outcome outcome = tumble(std::string(verb) + " --quiet --set output.encoder=libx256");
        EXPECT_EQ(outcome.code, 2);
        expect_one_line(outcome.err);
        EXPECT_TRUE(outcome.err.starts_with("tumble: block: output.encoder 'libx256': expected auto or an encoder that "
                                            "this libavcodec has: "))
            << outcome.err;
        EXPECT_TRUE(outcome.err.ends_with("; did you mean 'libx265'?\n")) << outcome.err;
        EXPECT_TRUE(bytes("out/block/block.mp4") == film);
    }
}

} // namespace
