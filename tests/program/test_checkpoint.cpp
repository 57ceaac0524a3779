/// A simulation that was interrupted goes on from its last checkpoint, and ends with the bytes of one that was not.
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <random>

namespace fs = std::filesystem;
using test::expect_one_line;
using test::Outcome;

namespace {

/// Rocks, a chain of two links and a block on a floor: contacts, joints, impacts at which steps are divided; for a film in
/// slow motion, whose frames lie between steps.
constexpr const char* mixture_text = R"(
[simulation]
time_step = "1/8000"
impacts = "stop"
[output]
width = 64
height = 36
duration = 0.8
fps = 20
speed_keys = [{ time = 0.4, speed = 1 }, { time = 0.5, speed = 0.37 }]
[overlay]
show = ["impulses"]
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
friction = 0.3
[[body]]
name = "link"
shape = { kind = "box", size = [0.2, 0.2, 1] }
density = 1000
position = [3, 0, 2]
velocity = [1, 0, 0]
[[body]]
name = "bob"
shape = { kind = "sphere", radius = 0.2 }
density = 1000
position = [3, 0, 1.3]
[[joint]]
name = "hook"
kind = "ball"
bodies = ["link"]
anchor = [3, 0, 2.5]
[[joint]]
name = "chain"
kind = "ball"
bodies = ["link", "bob"]
anchor = [3, 0, 1.5]
[[lattice]]
name = "rock"
count = [2, 2, 2]
spacing = [1.4, 1.4, 1.4]
origin = [0, 0, 0.6]
turn_max_degrees = 180
seed = 7
[lattice.body]
shape = { kind = "rock", size = [1.3, 1.1, 0.9], corners = 14, seed = 100 }
density = 2600
restitution = 0.3
friction = 0.25
)";

class checkpoint : public test::Program {
protected:
    void SetUp() override {
        Program::SetUp();
        sim::write_file(folder / "mixture.toml", std::string(mixture_text));
    }

    /// Kills the program `seconds` after out/mixture has a checkpoint and it works there.
    Outcome killed(const std::string& arguments, const char* signal, double seconds) const {
        return shell("rm -f out/mixture/trajectory.h5.part\n\"$TUMBLE\" " + arguments + " --quiet & process=$!\n" +
                     "until [ -e out/mixture/trajectory.h5.part ] && [ -e out/mixture/checkpoint.bin ]; do\n"
                     "kill -0 $process 2>/dev/null || break; sleep 0.005; done\n" +
                     "sleep " + std::to_string(seconds) + "; kill -" + signal + " $process 2>/dev/null; wait $process");
    }

    /// Leaves a checkpoint in out/block.
    void interrupt_block() const {
        shell("\"$TUMBLE\" simulate block.toml --duration 10000 --checkpoint 0 --quiet & process=$!\n"
              "until [ -e out/block/checkpoint.bin ]; do sleep 0.005; done; kill -KILL $process; wait $process");
    }

    nlohmann::json summary(const std::string& run) const {
        nlohmann::json json = nlohmann::json::parse(bytes(run + "/summary.json"));
        for (const char* name : {"wall_time_s", "stage_ms_per_step", "picture_ms_per_frame"}) {
            json.erase(name);
        }
        json["settings"].erase("threads");
        return json;
    }

    void expect_same_run() const {
        EXPECT_EQ(files_in("out/mixture"), files_in("whole/mixture"));
        for (const std::string& name : files_in("whole/mixture")) {
            if (name != "summary.json") {
                EXPECT_TRUE(bytes("whole/mixture/" + name) == bytes("out/mixture/" + name)) << name;
            }
        }
        EXPECT_EQ(summary("whole/mixture"), summary("out/mixture"));
    }

    /// Is killed again and again, and goes on each time, until it ends; returns how often it went on from a checkpoint.
    int goes_on_until_whole(const std::string& arguments, double most_seconds, std::mt19937& random) const {
        int count = 0;
        for (int round = 0;; ++round) {
            const char* signal = round % 3 == 0 ? "KILL" : round % 3 == 1 ? "INT" : "TERM";
            // A simulation takes 0.07 s.
            const std::string words = arguments + " --resume --threads " + std::to_string(1 + round % 2) + " --checkpoint 0.01";
            count += fs::exists(folder / "out/mixture/checkpoint.bin") ? 1 : 0;
            const double after = round == 0 ? 0.0 : most_seconds * (random() / 4294967296.0);
            const Outcome outcome = killed(words, signal, after);
            if (outcome.code == 0 || round == 60) {
                EXPECT_EQ(outcome.code, 0) << outcome.err;
                return count;
            }
            EXPECT_TRUE(outcome.code == 130 || outcome.code == 128 + 9) << outcome.code << outcome.err;
        }
    }
};

} // namespace

TEST_F(checkpoint, a_simulation_killed_again_and_again_ends_with_the_same_bytes) {
    ASSERT_EQ(tumble("simulate mixture.toml --out whole --quiet").err, "");
    std::mt19937 random(3);
    const char* rounds = std::getenv("TUMBLE_SIGNALS");
    for (int i = 0; i < (rounds != nullptr ? std::atoi(rounds) : 1); ++i) {
        fs::remove_all(folder / "out");
        EXPECT_GT(goes_on_until_whole("simulate mixture.toml", 0.1, random), 0);
        expect_same_run();
    }
}

TEST_F(checkpoint, a_film_killed_again_and_again_ends_with_the_same_bytes) {
    ASSERT_EQ(tumble("run mixture.toml --out whole --quiet").err, "");
    std::mt19937 random(4);
    EXPECT_GT(goes_on_until_whole("run mixture.toml", 0.5, random), 0);
    expect_same_run();
    fs::remove_all(folder / "out");
    fs::remove_all(folder / "whole");
    ASSERT_EQ(tumble("run mixture.toml --no-png --out whole --quiet").err, "");
    EXPECT_GT(goes_on_until_whole("run mixture.toml --no-png", 0.5, random), 0);
    expect_same_run();
}

TEST_F(checkpoint, another_program_or_scene_is_refused_by_its_name) {
    sim::write_file(folder / "rock.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"));
    sim::write_file(folder / "block.toml", bytes("block.toml") +
                                               "[[body]]\nname = \"rock\"\nshape = { kind = \"hull\", file = \"rock.obj\" }\n"
                                               "density = 1000\nposition = [5, 0, 1]\n");
    interrupt_block();
    const std::string before = bytes("out/block/checkpoint.bin");
    const auto refusal = [](const Outcome& outcome) {
        EXPECT_EQ(outcome.code, 2);
        expect_one_line(outcome.err);
        return outcome.err;
    };
    const std::string go_on = "simulate block.toml --duration 10000 --resume";
    EXPECT_EQ(refusal(tumble(go_on + " --tolerance 1e-6")),
              "tumble: cannot go on in out/block: simulation.tolerance is 1e-06, was not set; run without --resume to start "
              "again\n");
    // A program that differs by a byte at its end.
    const std::string other = refusal(shell("mkdir other && cp \"$TUMBLE\" \"${TUMBLE%/*}/tumble-draw\" other && "
                                            "printf x >>other/tumble-draw && other/tumble " + go_on));
    EXPECT_TRUE(other.starts_with("tumble: cannot go on in out/block: this is tumble ")) << other;
    EXPECT_NE(other.find(", checkpoint.bin is of tumble "), std::string::npos) << other;
    sim::write_file(folder / "rock.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\n"));
    const std::string shapes = refusal(tumble(go_on));
    EXPECT_NE(shapes.find("body.rock.shape.points[3][2] is 2, was 1"), std::string::npos) << shapes;
    EXPECT_TRUE(bytes("out/block/checkpoint.bin") == before);
    // Anew it is nobody's any more.
    EXPECT_EQ(tumble("simulate block.toml --quiet").err, "");
    EXPECT_EQ(files_in("out/block"), (std::set<std::string>{"summary.json", "trajectory.h5"}));
}

TEST_F(checkpoint, a_damaged_one_is_refused_and_a_new_run_starts_without_it) {
    interrupt_block();
    std::mt19937 random(5);
    for (const char* name : {"checkpoint.bin", "checkpoint.states"}) {
        const std::string file = std::string("out/block/") + name;
        const std::string whole = bytes(file);
        for (int i = 0; i < 8; ++i) {
            std::string damaged = whole;
            // What follows the states of the checkpoint may be anything: the first half is of them.
            const std::size_t at = random() % (whole.size() / 2);
            if (i % 3 == 0) {
                damaged.resize(at);
            } else {
                damaged[at] = static_cast<char>(damaged[at] ^ (1 << random() % 8));
            }
            sim::write_file(folder / file, damaged);
            const Outcome outcome = shell("timeout -s INT 5 \"$TUMBLE\" simulate block.toml --duration 10000 --resume --quiet");
            EXPECT_EQ(outcome.code, 3) << at;
            EXPECT_EQ(outcome.err, "tumble: cannot read " + file + ": it is damaged; run without --resume to start again\n");
        }
        sim::write_file(folder / file, whole);
    }
    EXPECT_EQ(tumble("simulate block.toml --quiet").err, "");
}

TEST_F(checkpoint, a_disk_that_is_full_leaves_the_one_before) {
    const std::string simulate = "simulate mixture.toml --set output.record_every=1 --time-step 0.0005 --quiet --checkpoint 1e-4";
    ASSERT_EQ(tumble(simulate + " --out whole").err, "");
    int count = 0;
    for (const int kilobytes : {4, 100, 300, 1000}) { // no file may be larger: checkpoint.bin, trajectory, checkpoint.states
        const std::string limit = "ulimit -f " + std::to_string(kilobytes);
        const Outcome outcome = shell(limit + "; \"$TUMBLE\" " + simulate + " --resume");
        EXPECT_EQ(outcome.code, 3) << kilobytes;
        expect_one_line(outcome.err);
        EXPECT_NE(outcome.err.find("File too large"), std::string::npos) << outcome.err;
        const bool has_checkpoint = fs::exists(folder / "out/mixture/checkpoint.bin");
        EXPECT_EQ(files_in("out/mixture").size(), has_checkpoint ? 2u : 0u);
        count += has_checkpoint ? 1 : 0;
    }
    EXPECT_GT(count, 1);
    EXPECT_EQ(tumble(simulate + " --resume").err, "");
    expect_same_run();
}
