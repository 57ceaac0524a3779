/// What goes wrong outside the program: full disks, folders that vanish or cannot be written, a second run at
/// the same time, damaged files, little memory, signals at any instant. Nothing whole is lost, one line says
/// what happened, with the documented exit code.
#include "render/picture/image.h"
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

#include <random>
#include <sstream>
#include <vector>

namespace fs = std::filesystem;
using test::expect_one_line;
using test::Outcome;

namespace {

constexpr const char* tiny = "--size 16x9 --duration 0.1 --quiet";

class faults : public test::Program {
protected:
    /// True if this machine lets the tests mount a file system of their own, in a name space of their own.
    bool can_mount() const {
        return shell("unshare -m mount -t tmpfs -o size=4k none . 2>/dev/null").code == 0;
    }

    struct Attempt {
        int code = -1;
        std::string line; ///< all that was printed
        std::set<std::string> files;
    };

    /// Runs the command on disks of so many kB, each mounted at disk/ and prepared by a shell command.
    std::vector<Attempt> on_small_disks(const std::string& command, const std::string& sizes,
                                        const std::string& prepare = ":") const {
        const Outcome outcome = shell(
            "mkdir -p disk; unshare -m bash -c 'for k in " + sizes +
            "; do mount -t tmpfs -o size=${k}k none disk || exit 9; " + prepare + "; \"$0\" " + command +
            " >log 2>&1; echo \"@ $?\"; cat log; (cd disk && find . -type f -size +0 | sed s,^./,+,); "
            "(cd disk && find . -name \"*.part\"); cp -r disk kept_$k; umount disk; done' \"$TUMBLE\"");
        EXPECT_EQ(outcome.code, 0) << outcome.err;
        std::vector<Attempt> attempts;
        std::istringstream lines(outcome.out);
        for (std::string line; std::getline(lines, line);) {
            if (line.starts_with("@ ")) {
                attempts.push_back({std::stoi(line.substr(2)), {}, {}});
            } else if (line.starts_with("+")) {
                attempts.back().files.insert(line.substr(1));
            } else {
                attempts.back().line += line + "\n";
            }
        }
        return attempts;
    }

    /// Each attempt either succeeds and prints nothing, or says in one line which file the disk had no room
    /// for; no file is left half. Returns the names of the files that had no room.
    std::set<std::string> expect_told(const std::vector<Attempt>& attempts) const {
        std::set<std::string> full;
        for (const Attempt& attempt : attempts) {
            if (attempt.code == 0) {
                EXPECT_EQ(attempt.line, "");
                continue;
            }
            EXPECT_EQ(attempt.code, 3) << attempt.line;
            expect_one_line(attempt.line);
            EXPECT_TRUE(attempt.line.starts_with("tumble: cannot ")) << attempt.line;
            EXPECT_NE(attempt.line.find(": No space left on device"), std::string::npos) << attempt.line;
            const std::string path = attempt.line.substr(0, attempt.line.rfind(": "));
            full.insert(fs::path(path.substr(path.rfind(' ') + 1)).filename().string());
        }
        return full;
    }

    void expect_whole_pictures(const fs::path& name) const {
        for (const std::string& file : files_in(name)) {
            if (file.ends_with(".png")) {
                EXPECT_GT(render::read_image(folder / name / file).width, 0) << file;
            }
        }
    }
};

/// A file's text with one of several kinds of damage.
std::string damaged(std::string text, std::mt19937& random) {
    const auto below = [&random](std::size_t n) {
        return static_cast<std::size_t>(random() % std::max<std::size_t>(n, 1));
    };
    switch (random() % 4) {
    case 0:
        text.resize(below(text.size()));
        break;
    case 1:
        for (std::size_t i = 1 + below(8); i > 0; --i) {
            text[below(text.size())] = static_cast<char>(random());
        }
        break;
    case 2: {
        const std::size_t at = below(text.size());
        text.replace(at, std::min<std::size_t>(200, text.size() - at), 40, '\0');
        break;
    }
    default:
        text.erase(below(text.size()), 1 + below(200));
    }
    return text;
}

struct Damage {
    const char* file;    ///< that is damaged
    const char* command; ///< that reads it
    const char* codes;   ///< one of which it ends with
    int rounds;
};

} // namespace

TEST_F(faults, a_full_disk_is_told_for_every_file_of_a_run) {
    if (!can_mount()) {
        GTEST_SKIP() << "no right to mount a small disk";
    }
    const std::string run = "run block.toml " + std::string(tiny) + " --out disk";
    // A trajectory of 104 kB, then four files of a page each and the summary.
    std::set<std::string> full =
        expect_told(on_small_disks(run, "4 8 16 40 80 100 104 108 112 116 120 124 128 132 136 140 144 148 152 160"));
    full.merge(
        expect_told(on_small_disks("simulate block.toml " + std::string(tiny) + " --out disk", "60 108")));
    // One file at a time: the others have a disk of their own.
    const std::string frames = "mkdir -p out/block/frames; umount out/block/frames 2>/dev/null; "
                               "mount --bind disk out/block/frames";
    const std::string here = "run block.toml " + std::string(tiny);
    full.merge(expect_told(on_small_disks(here + " --body-ids", "4 8 12 16 20 24", frames)));
    const std::string parts = "cp -r whole/block disk/";
    ASSERT_EQ(tumble(run.substr(0, run.find("--out")) + "--out whole").code, 0);
    const std::string stills = "join whole/block --quiet --poster 0 --sheet 2 --webp --out disk";
    full.merge(expect_told(on_small_disks(stills, "4 8 12 16 20")));
    const std::string film = "render whole/block/trajectory.h5 --no-png --size 640x360 --quiet --out disk";
    full.merge(expect_told(on_small_disks(film, "4 8")));
    for (const char* name :
         {"trajectory.h5", "frame_000000.png", "summary.json", "block.mp4", "block_sheet.png"}) {
        EXPECT_TRUE(full.contains(name)) << name << " was never the file without room";
    }
    for (const auto& entry : fs::directory_iterator(folder)) {
        if (entry.path().filename().string().starts_with("kept_")) {
            expect_whole_pictures(entry.path().filename());
        }
    }
}

TEST_F(faults, a_full_disk_is_told_by_the_other_verbs) {
    if (!can_mount()) {
        GTEST_SKIP() << "no right to mount a small disk";
    }
    ASSERT_EQ(tumble("run block.toml " + std::string(tiny)).code, 0);
    const std::string fill = "head -c 100000 /dev/zero >disk/fill 2>/dev/null";
    const std::string pair = "out/block/frames/frame_000000.png out/block/frames/frame_000001.png";
    for (const std::string& command :
         {std::string("new disk/first.toml --quiet"),
          "compare " + pair + " --quiet --fail-on changed --junit disk/junit.xml",
          "compare " + pair + " --quiet --report disk",
          std::string("baseline update block.toml --size 16x9 --quiet --baselines disk"),
          std::string("render out/block/trajectory.h5 --quiet --no-png --out disk")}) {
        const std::vector<Attempt> attempts = on_small_disks(command, "4", fill);
        ASSERT_EQ(attempts.size(), 1u);
        EXPECT_EQ(attempts[0].code, 3) << command;
        EXPECT_EQ(expect_told(attempts).size(), 1u);
        EXPECT_EQ(attempts[0].files, (std::set<std::string>{"fill"})) << command;
    }
    const std::vector<Attempt> gallery =
        on_small_disks("gallery disk --quiet", "200", "cp -r out/block disk; " + fill);
    EXPECT_EQ(gallery.at(0).code, 3);
    expect_told(gallery);
}

TEST_F(faults, a_report_on_a_disk_that_fills_up_is_told) {
    if (!can_mount()) {
        GTEST_SKIP() << "no right to mount a small disk";
    }
    ASSERT_EQ(tumble("run block.toml " + std::string(tiny)).code, 0);
    ASSERT_EQ(tumble("run block.toml " + std::string(tiny) + " --set light.sun_intensity=1 --out other").code,
              0);
    for (const Attempt& attempt :
         on_small_disks("compare out/block other/block --quiet --report disk", "4 8 16 24 32 60 100 4000")) {
        EXPECT_TRUE(attempt.code == 3 || attempt.code == 1) << attempt.line;
        if (attempt.code == 3) {
            expect_one_line(attempt.line);
            EXPECT_NE(attempt.line.find("No space left on device"), std::string::npos) << attempt.line;
        }
    }
}

TEST_F(faults, a_disk_that_cannot_be_written_is_told) {
    if (!can_mount()) {
        GTEST_SKIP() << "no right to mount a disk";
    }
    const Outcome outcome =
        shell("mkdir disk; unshare -m bash -c 'mount -t tmpfs -o ro none disk; for verb in run simulate; do "
              "\"$0\" $verb block.toml --quiet --out disk; echo $?; done; "
              "\"$0\" new disk/first.toml; echo $?' \"$TUMBLE\" 2>&1");
    EXPECT_EQ(outcome.out, "tumble: cannot make the folder disk/block: Read-only file system\n3\n"
                           "tumble: cannot make the folder disk/block: Read-only file system\n3\n"
                           "tumble: cannot write disk/first.toml: Read-only file system\n3\n");
}

TEST_F(faults, a_folder_that_vanishes_is_told) {
    for (const char* arguments :
         {"run block.toml --duration 10000 --quiet", "simulate block.toml --duration 40 --quiet"}) {
        const Outcome outcome = shell("\"$TUMBLE\" " + std::string(arguments) +
                                      " & process=$!\n"
                                      "until [ -e out/block/trajectory.h5.part ]; do sleep 0.01; done\n"
                                      "sleep 0.1\n" // HDF5 tells less of one that goes while it is being made
                                      "while [ -e out ]; do rm -rf out 2>/dev/null; done; wait $process");
        EXPECT_EQ(outcome.code, 3) << arguments;
        expect_one_line(outcome.err);
        EXPECT_NE(outcome.err.find("No such file or directory"), std::string::npos) << outcome.err;
    }
}

TEST_F(faults, no_second_writer_of_any_kind_comes_into_a_folder) {
    const Outcome outcome = shell(
        "\"$TUMBLE\" simulate block.toml --duration 0.1 --quiet --out first\n"
        "mkdir -p out/block; cp first/block/trajectory.h5 out/block/old.h5\n"
        "\"$TUMBLE\" run block.toml --duration 10000 --quiet & process=$!\n"
        "until [ -e out/block/frames/frame_000001.png ]; do sleep 0.02; done\n"
        "for arguments in 'run block.toml --resume' 'run block.toml --frames 0:1' 'simulate block.toml' "
        "'render out/block/old.h5' 'join out/block'; do\n"
        "\"$TUMBLE\" $arguments >line 2>&1; echo \"$? $(cat line)\"; done\n"
        "kill $process; wait $process");
    std::istringstream lines(outcome.out);
    int count = 0;
    for (std::string line; std::getline(lines, line); ++count) {
        // A film of frames that are still being made lacks some, whoever holds the folder.
        EXPECT_TRUE(line == "3 tumble: another run is writing into out/block" ||
                    line.starts_with("4 tumble: frame "))
            << line;
    }
    EXPECT_EQ(count, 5);
}

// Each file that is read, damaged at random: it still reads, or one line says what is wrong with it.
TEST_F(faults, damaged_files_are_told) {
    const Outcome prepared =
        shell("set -e; \"$TUMBLE\" run block.toml --size 64x36 --duration 0.1 --quiet; cp -r out whole\n"
              "cp out/block/frames/frame_000000.png a.png; cp a.png b.png\n"
              "printf 'v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nv 0 0 1\\nv 1 1 1\\n' >rock.obj\n"
              "printf '[[body]]\\nname=\"rock\"\\nshape={kind=\"hull\", "
              "file=\"rock.obj\"}\\ndensity=1000\\n' >hull.toml\n"
              "\"$TUMBLE\" compare a.png out/block/frames/frame_000001.png --calibrate >limits.json\n"
              "\"$TUMBLE\" baseline update block.toml --size 64x36 --quiet");
    ASSERT_EQ(prepared.code, 0) << prepared.err;
    const Damage damages[] = {
        {"out/block/trajectory.h5",
         "render out/block/trajectory.h5 --no-video --frames 0:1 --out drawn --quiet", "023", 12},
        {"block.toml", "check block.toml --quiet", "02", 12},
        {"rock.obj", "check hull.toml --quiet", "02", 8},
        {"b.png", "compare a.png b.png --quiet", "0134", 12},
        {"out/block/frames/frame_000001.png", "join out/block --out joined --quiet", "034", 8},
        {"out/block/frames/run.json", "join out/block --out joined --quiet", "0234", 6},
        {"out/block/summary.json", "gallery out --quiet", "03", 6},
        {"out/block/block.mp4", "compare whole/block/block.mp4 out/block/block.mp4 --quiet", "01234", 8},
        {"baselines/block/common/baseline.json", "baseline check block.toml --quiet", "01234", 6},
        {"limits.json", "compare a.png b.png --limits limits.json --quiet", "012", 6},
    };
    std::mt19937 random(5);
    for (const Damage& damage : damages) {
        const std::string whole = bytes(damage.file);
        for (int i = 0; i < (test::has_sanitizer ? damage.rounds / 2 : damage.rounds); ++i) {
            sim::write_file(folder / damage.file, damaged(whole, random));
            const Outcome outcome = tumble(damage.command);
            SCOPED_TRACE(std::string(damage.command) + ", damage " + std::to_string(i) + "\n" + outcome.err);
            EXPECT_NE(std::string(damage.codes).find(std::to_string(outcome.code)), std::string::npos)
                << outcome.code;
            EXPECT_EQ(outcome.out, "");
            if (outcome.code >= 2) {
                expect_one_line(outcome.err);
            } else {
                EXPECT_EQ(outcome.err, "");
            }
        }
        sim::write_file(folder / damage.file, whole);
    }
}

TEST_F(faults, little_memory_ends_with_one_line) {
    if (test::has_sanitizer) {
        GTEST_SKIP();
    }
    for (const int megabytes : {60, 100, 140, 180, 220, 260, 300, 400, 600}) {
        const Outcome outcome = shell("ulimit -v " + std::to_string(megabytes * 1000) +
                                      "; \"$TUMBLE\" run block.toml --duration 0.1 --quiet");
        SCOPED_TRACE(std::to_string(megabytes) + " MB: " + outcome.err);
        if (outcome.code != 0) {
            EXPECT_TRUE(outcome.code == 5 || outcome.code == 3 || outcome.code == 127) << outcome.code;
            expect_one_line(outcome.err);
        }
        for (const std::string& file : files_in("out/block")) {
            EXPECT_FALSE(file.ends_with(".part")) << file;
        }
    }
}

// At random instants of a run: whole frames stay, and what goes on from them ends as one run does.
TEST_F(faults, a_signal_at_any_instant_loses_nothing_whole) {
    ASSERT_EQ(tumble("run block.toml --out whole --quiet").code, 0);
    const char* rounds = std::getenv("TUMBLE_SIGNALS");
    const int count = rounds != nullptr ? std::atoi(rounds) : 8;
    std::mt19937 random(3);
    for (int i = 0; i < count; ++i) {
        fs::remove_all(folder / "out");
        const char* signal = i % 3 == 0 ? "TERM" : i % 3 == 1 ? "INT" : "KILL";
        const double after = 1.2 * (random() / 4294967296.0);
        const Outcome outcome =
            shell("\"$TUMBLE\" run block.toml --quiet & process=$!\nsleep " + std::to_string(after) +
                  "; kill -" + signal + " $process; wait $process");
        SCOPED_TRACE(std::string(signal) + " after " + std::to_string(after) + " s: " + outcome.err);
        // Killed, or ended where it is: it took longer than the program's patience.
        const bool is_ended = outcome.code == 128 + 9 || outcome.err == "tumble: interrupted\n";
        // A signal before the program catches it ends it at once and silently, with nothing made.
        const bool is_early = outcome.err.empty() && files_in("out/block").empty();
        EXPECT_TRUE(outcome.code == 130 || outcome.code == 0 || is_ended || is_early) << outcome.code;
        if (outcome.code == 130 && !is_early) {
            expect_one_line(outcome.err);
        }
        for (const std::string& file : files_in("out/block")) {
            EXPECT_TRUE(is_ended || !file.ends_with(".part")) << file;
        }
        expect_whole_pictures("out/block");
        ASSERT_EQ(tumble("run block.toml --resume --quiet").code, 0);
        EXPECT_EQ(files_in("out/block"), expected_files());
        for (const std::string& name : expected_files()) {
            if (name != "summary.json") { // which has wall times
                EXPECT_TRUE(bytes("whole/block/" + name) == bytes("out/block/" + name)) << name;
            }
        }
    }
}

TEST_F(faults, an_interrupt_ends_a_run_within_a_second) {
    const Outcome outcome = shell(
        "\"$TUMBLE\" run \"" TUMBLE_SCENE_DIR "/funnel.toml\" --quiet & process=$!\n"
        "until [ -e out/funnel/frames/frame_000001.png ]; do sleep 0.02; done\n"
        "kill -INT $process; for i in $(seq 300); do kill -0 $process 2>/dev/null || break; sleep 0.1; done\n"
        "echo $i; wait $process");
    EXPECT_EQ(outcome.code, 130);
    EXPECT_EQ(
        outcome.err,
        "tumble: interrupted; what is done is kept in out/funnel: the same command with --resume goes on\n");
    RecordProperty("tenths_of_a_second", outcome.out);
}
