/// What is promised is kept or said: --strict, and limits of memory and size.
#include "tests/program/program_fixture.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <regex>

namespace fs = std::filesystem;
using test::Outcome;

namespace {

using promises = test::Program;

/// Two boxes, one on the other, fall onto the floor at 100 m/s. One sweep visits each contact once: whichever is first, the
/// momentum left is shared by two equal masses and goes on into the floor, or into the lower box, at 50 m/s or more.
constexpr const char* tower_text = R"([output]
duration = 0.1
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[body]]
name = "lower"
shape = { kind = "box", half_extents = [0.5, 0.5, 0.5] }
density = 1000
position = [0, 0, 0.6]
velocity = [0, 0, -100]
[[body]]
name = "upper"
shape = { kind = "box", half_extents = [0.5, 0.5, 0.5] }
density = 1000
position = [0, 0, 1.6]
velocity = [0, 0, -100]
)";
constexpr const char* missed = "simulate tower.toml --set simulation.iteration_limit=1 ";

} // namespace

TEST_F(promises, a_missed_promise_ends_a_strict_run_with_its_time_bodies_and_amount) {
    sim::write_file(folder / "tower.toml", std::string(tower_text));
    const Outcome lenient = tumble(std::string(missed) + "--no-strict");
    EXPECT_EQ(lenient.code, 0) << lenient.err;
    const nlohmann::json summary = nlohmann::json::parse(bytes("out/tower/summary.json"));
    EXPECT_GT(int(summary["steps_above_tolerance"]) + int(summary["steps_at_iteration_limit"]), 0);
    const Outcome strict = tumble(std::string(missed) + "--strict --quiet");
    EXPECT_EQ(strict.code, 5);
    test::expect_one_line(strict.err);
    EXPECT_TRUE(strict.err.starts_with("tumble: tower: at 0.0")) << strict.err;
    EXPECT_NE(strict.err.find(" m"), std::string::npos) << strict.err;
    EXPECT_TRUE(fs::exists(folder / "out/tower/summary.json")); // what was computed is there to be looked at
    EXPECT_EQ(shell("export CI=true; \"$TUMBLE\" " + std::string(missed) + "--quiet").code, 5);
    EXPECT_EQ(shell("export CI=true; \"$TUMBLE\" " + std::string(missed) + "--quiet --no-strict").code, 0);
    EXPECT_EQ(shell("export CI=false; \"$TUMBLE\" " + std::string(missed) + "--quiet").code, 0);
    EXPECT_EQ(tumble("simulate tower.toml --quiet --strict").code, 0);
}

TEST_F(promises, a_joint_that_is_torn_open_is_named_with_its_gap) {
    // Two hands draw the ends of a rod apart.
    std::string text = "[output]\nduration = 0.05\n";
    for (const auto& [name, x] : {std::pair("left", -1), std::pair("right", 1)}) {
        text += fmt::format("[[body]]\nname = \"{}\"\nshape = {{ kind = \"sphere\", radius = 0.1 }}\nposition = [{}, 0, 1]\n"
                            "keys = [{{ time = 0, position = [{}, 0, 1] }}, {{ time = 1, position = [{}, 0, 1] }}]\n",
                            name, x, x, 2 * x);
    }
    text += "[[body]]\nname = \"rod\"\nshape = { kind = \"capsule\", radius = 0.1, length = 0.8 }\ndensity = 1000\n"
            "position = [0, 0, 1]\n";
    for (const auto& [name, x] : {std::pair("left", -0.5), std::pair("right", 0.5)}) {
        text += fmt::format("[[joint]]\nname = \"{0} end\"\nkind = \"ball\"\nbodies = [\"rod\", \"{0}\"]\n"
                            "anchor = [{1}, 0, 1]\n",
                            name, x);
    }
    sim::write_file(folder / "torn.toml", text);
    const Outcome strict = tumble("simulate torn.toml --strict --quiet");
    EXPECT_EQ(strict.code, 5);
    test::expect_one_line(strict.err);
    EXPECT_TRUE(std::regex_search(
        strict.err, std::regex("at 0\\.\\d+ s joint '(left|right) end' was left open by 0.0\\d+ m; \\d+ of 50 steps")))
        << strict.err;
    EXPECT_GT(double(nlohmann::json::parse(bytes("out/torn/summary.json"))["max_joint_gap_m"]), 0.001);
}

TEST_F(promises, a_run_that_gains_energy_says_so_and_ends_a_strict_one) {
    // It rolls with its centre of mass off the ball's, five steps a radian.
    sim::write_file(folder / "rolls.toml", std::string(R"(
[simulation]
time_step = "1/50"
tolerance = 1e-4
[output]
duration = 60
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
friction = 0.3
[[body]]
name = "egg"
shape = { kind = "sphere", radius = 0.1 }
mass = 1
centre_of_mass = [0, 0, -0.045]
inertia = [0.004, 0.004, 0.005]
position = [0, 0, 0.1]
velocity = [1, 0, 0]
angular_velocity = [0, 10, 0]
friction = 0.3
)"));
    const Outcome lenient = tumble("simulate rolls.toml --no-strict");
    EXPECT_EQ(lenient.code, 0) << lenient.err;
    EXPECT_NE(lenient.out.find("% of the energy that it turned over"), std::string::npos) << lenient.out;
    EXPECT_GT(double(nlohmann::json::parse(bytes("out/rolls/summary.json"))["max_energy_gain"]), 1e-3);
    const Outcome strict = tumble("simulate rolls.toml --strict --quiet");
    EXPECT_EQ(strict.code, 5);
    EXPECT_NE(strict.err.find("rolls: energy grew by "), std::string::npos) << strict.err;
}

TEST_F(promises, under_every_limit_of_addresses_a_run_works_or_says_in_one_sentence_why_not) {
    if (test::has_sanitizer) {
        GTEST_SKIP();
    }
    for (const std::string command : {"simulate block.toml", "run block.toml --duration 0.1 --size 64x36"}) {
        bool has_failed = false, has_worked = false;
        for (int megabytes = 30; megabytes <= 1400; megabytes += megabytes < 100 ? 7 : 90) {
            const Outcome outcome =
                shell("ulimit -v " + std::to_string(1024 * megabytes) + "; \"$TUMBLE\" " + command + " --quiet");
            EXPECT_TRUE(outcome.code == 0 || outcome.code == 5) << megabytes << " MB: " << outcome.code << outcome.err;
            if (outcome.code == 5) {
                test::expect_one_line(outcome.err);
                EXPECT_NE(outcome.err.find("out of memory"), std::string::npos) << outcome.err;
            }
            (outcome.code == 0 ? has_worked : has_failed) = true;
        }
        EXPECT_TRUE(has_failed && has_worked);
    }
}

TEST_F(promises, without_the_libraries_of_films_all_else_works_and_a_film_is_refused_before_anything_is_drawn) {
    const std::string without = "HIDDEN_LIBRARY=libavformat LD_PRELOAD='" TUMBLE_CARD "' \"$TUMBLE\" ";
    const Outcome film = shell(without + "run block.toml --quiet");
    EXPECT_EQ(film.code, 3);
    EXPECT_EQ(film.err, "tumble: films, GIFs and encoders by name need FFmpeg's libraries; --no-video leaves films out: "
                        "libHidden.so: cannot open shared object file: No such file or directory\n");
    EXPECT_TRUE(files_in("out/block").empty());
    const Outcome frames = shell(without + "run block.toml --quiet --no-video --poster 0.1");
    EXPECT_EQ(frames.code, 0) << frames.err;
    EXPECT_TRUE(files_in("out/block").contains("block_poster.png"));
    EXPECT_EQ(shell(without + "check block.toml").code, 0);
}

TEST_F(promises, a_film_larger_than_the_encoder_takes_is_refused_before_anything_is_drawn) {
    const Outcome outcome = tumble("run block.toml --size 16384x16384");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_NE(outcome.err.find("a film of 16384x16384 has 272646144 pixels with the encoder's margin of 128 each way, "
                               "expected at most 268435455, x264's limit"),
              std::string::npos)
        << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "out"));
}
