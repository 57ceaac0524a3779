/// What a user keeps in the program's folders stays, names cannot lead out of them, and what lies together in the
/// folder of a run belongs together, whatever verbs have run in whatever order.
#include "sim/base/random.h"
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

#include <fstream>
#include <vector>

namespace fs = std::filesystem;
using test::Outcome;

namespace {

class kept : public test::Program {
protected:
    /// Another's file.
    void put(const std::string& name) {
        fs::create_directories((folder / name).parent_path());
        std::ofstream(folder / name) << "of " << name;
        strangers_.push_back(name);
    }
    void expect_strangers(const std::string& after) const {
        for (const std::string& name : strangers_) {
            ASSERT_TRUE(fs::exists(folder / name)) << name << " is gone after " << after;
            ASSERT_EQ(bytes(name), "of " + name) << "after " << after;
        }
    }

    /// Every file that a list names is as it says. key: "files" of summary.json and manifest.json.
    void expect_true_hashes(const std::string& list, const std::string& after) const {
        if (!fs::exists(folder / list)) {
            return;
        }
        const nlohmann::json report = nlohmann::json::parse(bytes(list));
        for (const nlohmann::json& file : report["files"]) {
            const fs::path name = fs::path(list).parent_path() / std::string(file["name"]);
            ASSERT_TRUE(fs::exists(folder / name)) << list << " names " << name << " after " << after;
            ASSERT_EQ(sim::sha256_of_file(folder / name), file["sha256"]) << name << " after " << after;
        }
    }

    /// Frames and film, where both are whole, show the same: joined anew they give the same bytes.
    void expect_one_set(const std::string& run, const std::string& after) const {
        const bool has_frames = fs::exists(folder / run / render::frame_file_name(0)) &&
                                fs::exists(folder / run / render::frame_file_name(test::frame_count - 1));
        if (has_frames && fs::exists(folder / run / "block.mp4")) {
            const Outcome joined = tumble("join " + run + " --out joined --quiet");
            ASSERT_EQ(joined.code, 0) << joined.err << after;
            ASSERT_TRUE(bytes("joined/block/block.mp4") == bytes(run + "/block.mp4")) << "after " << after;
        }
        fs::remove_all(folder / "joined");
    }

private:
    std::vector<std::string> strangers_;
};

} // namespace

TEST_F(kept, names_that_lead_elsewhere_or_hold_control_characters_are_refused_by_every_verb) {
    fs::create_directories(folder / "work");
    fs::copy(folder / "block.toml", folder / "work" / "...toml");
    fs::copy(folder / "block.toml", folder / "work" / "two\nlines.toml");
    const std::set<std::string> before = files_in("work");
    for (const std::string name : {"...toml", "$'two\\nlines.toml'"}) {
        for (const std::string verb :
             {"run", "simulate", "check", "study", "baseline check --report .", "baseline update --baselines ."}) {
            const Outcome outcome = shell("cd work && \"$TUMBLE\" " + verb + " " + name);
            EXPECT_EQ(outcome.code, 2) << verb << " " << name;
            EXPECT_NE(outcome.err.find("cannot be the name of a scene's folder"), std::string::npos) << outcome.err;
            test::expect_one_line(outcome.err);
            ASSERT_EQ(files_in("work"), before) << verb << " " << name;
        }
    }
}

TEST_F(kept, names_too_long_for_files_of_a_run_or_no_text_are_refused) {
    // With what the program appends, _poster.png.part, a name may have the 255 bytes of a file system's.
    const std::string longest(200, 'n');
    for (const std::string& name : {std::string(201, 'n'), std::string("\xff\xfe"), std::string("\xc0\xaf"),
                                    std::string("\xed\xa0\x80"), std::string("\xe2\x82")}) {
        fs::copy(folder / "block.toml", folder / (name + ".toml"));
        const Outcome outcome = tumble("run '" + name + ".toml' --size 32x18 --duration 0.1 --poster 0 --quiet");
        EXPECT_EQ(outcome.code, 2) << name;
        EXPECT_NE(outcome.err.find("cannot be the name of a scene's folder"), std::string::npos) << outcome.err;
        test::expect_one_line(outcome.err);
    }
    EXPECT_FALSE(fs::exists(folder / "out"));
    for (const std::string& name : {longest, std::string("b\xc3\xbc" "cher \xf0\x9f\x8e\xb2")}) {
        fs::copy(folder / "block.toml", folder / (name + ".toml"));
        EXPECT_EQ(tumble("run '" + name + ".toml' --size 32x18 --duration 0.1 --poster 0 --sheet 2 --webp --quiet").err, "");
    }
    ASSERT_EQ(tumble("gallery out --quiet").err, "");
    expect_true_hashes("out/manifest.json", "gallery");
}

TEST_F(kept, what_is_exported_takes_the_place_of_no_file_of_a_run) {
    const std::string small = " --size 32x18 --duration 0.1 --quiet";
    ASSERT_EQ(tumble("run block.toml" + small).code, 0);
    ASSERT_EQ(tumble("run block.toml --out b" + small).code, 0);
    const std::string scene = bytes("block.toml");
    const auto refused = [this](const std::string& command, const std::string& part) {
        const Outcome outcome = tumble(command);
        EXPECT_EQ(outcome.code, 2) << command;
        test::expect_one_line(outcome.err);
        EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
        expect_true_hashes("out/block/summary.json", command);
    };
    refused("side-by-side out/block b/block -o out/block/block.mp4", "is a file of the run in out/block");
    refused("side-by-side out/block b/block -o out/block/../block/block.mp4", "is a file of the run in out/block");
    refused("export out/block --csv out/block/trajectory.h5", "expected a name that ends in .csv, or -");
    refused("export out/block --csv block.toml", "expected a name that ends in .csv, or -");
    EXPECT_EQ(bytes("block.toml"), scene);
    EXPECT_EQ(tumble("export out/block --csv out/block/block.csv --quiet").err, "");
    EXPECT_EQ(tumble("side-by-side out/block b/block -o out/block/two.mp4 --quiet").err, "");
    expect_true_hashes("out/block/summary.json", "export");
}

TEST_F(kept, a_strangers_file_in_every_folder_survives_every_verb) {
    const std::string small = " --size 32x18 --duration 0.1 --quiet";
    // Every folder that a verb writes into, with names that look like its own.
    for (const char* place : {"out", "out/block", "out/block/frames", "s/block", "s/block/points", "s/block/film",
                              "s/block/film/tumble-base-as_given-1", "s/block/film/tumble-base-as_given-1/frames",
                              "report", "report/candidates", "report/candidates/block", "report/block",
                              "report/candidates/block/common", "report/candidates/block/common/frames",
                              "baselines", "baselines/block", "baselines/block/common", "baselines/block/common/masks",
                              "baselines/block/common.part"}) {
        for (const char* name : {"notes.txt", "mine.part", "other.mp4.part", "frame_x.png", "frame_1.png.bak"}) {
            put(std::string(place) + "/" + name);
        }
    }
    for (const std::string& verb : std::vector<std::string>{
             "run block.toml --poster 0.05" + small, "run block.toml --no-png" + small,
             "run block.toml --frames 0:2" + small, "run block.toml --resume" + small, "simulate block.toml" + small,
             "render out/block/trajectory.h5 --size 16x9 --quiet", "render out/block/trajectory.h5 --no-png --quiet",
             "run block.toml" + small, "join out/block --quiet", "gallery out --quiet",
             "baseline update block.toml --frames 0,1 --quiet", "baseline update block.toml --frames 0 --quiet",
             "baseline update block.toml --mask 0,0,8,8 --quiet",
             "baseline check block.toml --report report --quiet", "baseline check block.toml --report report --quiet",
             "compare out/block/block.mp4 out/block/block.mp4 --report report --quiet",
             "study block.toml --out s --duration 0.4 --knobs 'iteration limit' --quiet",
             "study block.toml --out s --duration 0.4 --knobs 'iteration limit' --quiet"}) {
        const Outcome outcome = tumble(verb);
        EXPECT_EQ(outcome.code, 0) << verb << outcome.err;
        expect_strangers(verb);
    }
}

TEST_F(kept, a_report_removes_no_picture_that_was_replaced_and_no_run_that_a_gallery_lists) {
    const std::string small = " --size 32x18 --duration 0.1 --quiet";
    ASSERT_EQ(tumble("run block.toml" + small).code, 0);
    ASSERT_EQ(tumble("run block.toml --set light.sun_intensity=0 --out dark" + small).code, 0);
    ASSERT_EQ(tumble("gallery out --quiet").code, 0);
    // The gallery's manifest lists the run's film: a report in the same folder must not take it for its own.
    ASSERT_EQ(tumble("compare out/block dark/block --report out --quiet").code, 1);
    EXPECT_TRUE(fs::exists(folder / "out/block/block.mp4"));
    const nlohmann::json manifest = nlohmann::json::parse(bytes("out/manifest.json"));
    std::string picture;
    for (const nlohmann::json& file : manifest["files"]) {
        const std::string name = file["name"];
        picture = name.ends_with(".difference.png") ? name : picture;
    }
    ASSERT_NE(picture, "");
    sim::write_file(folder / "out" / picture, std::string("mine now"));
    ASSERT_EQ(tumble("compare out/block out/block --report out --quiet").code, 0);
    EXPECT_EQ(bytes("out/" + picture), "mine now");
    // In the folder of a run the film of a report would take the place of the run's.
    const Outcome refused = tumble("compare dark/block out/block --report out/block --quiet");
    EXPECT_EQ(refused.code, 2);
    EXPECT_NE(refused.err.find("is the folder of a run"), std::string::npos) << refused.err;
}

TEST_F(kept, pictures_of_another_simulation_are_not_put_beside_a_run) {
    const std::string small = " --size 32x18 --duration 0.1 --quiet";
    ASSERT_EQ(tumble("run block.toml" + small).code, 0);
    ASSERT_EQ(tumble("run block.toml --out b --set simulation.gravity=[0,0,-1]" + small).code, 0);
    const std::set<std::string> before = files_in("out/block");
    const std::string film = bytes("out/block/block.mp4");
    const Outcome render = tumble("render b/block/trajectory.h5 --out out --quiet");
    EXPECT_EQ(render.code, 2);
    EXPECT_NE(render.err.find("holds another simulation"), std::string::npos) << render.err;
    const Outcome join = tumble("join b/block --out out --quiet");
    EXPECT_EQ(join.code, 2);
    EXPECT_NE(join.err.find("holds another run"), std::string::npos) << join.err;
    EXPECT_EQ(files_in("out/block"), before);
    EXPECT_TRUE(bytes("out/block/block.mp4") == film);
}

TEST_F(kept, verbs_and_options_in_random_order_leave_true_hashes_and_one_set) {
    const std::string small = " --size 32x18 --quiet";
    const std::vector<std::string> commands{"run block.toml" + small,
                                            "run block.toml --no-video" + small,
                                            "run block.toml --no-png" + small,
                                            "run block.toml --poster 0.2 --sheet 4 --body-ids" + small,
                                            "run block.toml --frames 2:5" + small,
                                            "run block.toml --resume" + small,
                                            "simulate block.toml" + small,
                                            "render out/block/trajectory.h5" + small,
                                            "render out/block/trajectory.h5 --color-by body --size 48x26 --quiet",
                                            "render out/block/trajectory.h5 --no-png --color-by body" + small,
                                            "render out/block/trajectory.h5 --no-video --color-by speed" + small,
                                            "render out/block/trajectory.h5 --frames 0:3" + small,
                                            "render out/block/trajectory.h5 --resume --webp" + small,
                                            "join out/block --poster 0.1 --quiet",
                                            "gallery out --quiet"};
    sim::Random random(19);
    std::string done;
    int good = 0;
    for (int i = 0; i < 30; ++i) {
        const std::size_t chosen = static_cast<std::size_t>(random.uniform() * static_cast<double>(commands.size()));
        const std::string& command = commands[chosen];
        const Outcome outcome = tumble(command);
        // What does not fit what is there is refused: other settings, no trajectory, missing frames.
        ASSERT_TRUE(outcome.code == 0 || outcome.code == 2 || outcome.code == 3 || outcome.code == 4)
            << command << outcome.err;
        good += outcome.code == 0;
        done += command + "\n";
        expect_true_hashes("out/block/summary.json", done);
        expect_true_hashes("out/manifest.json", done);
        expect_one_set("out/block", done);
        ASSERT_FALSE(HasFatalFailure());
    }
    EXPECT_GT(good, 15);
}

TEST_F(kept, a_gallery_is_not_made_of_a_run_that_another_verb_changes) {
    ASSERT_EQ(tumble("run block.toml --size 32x18 --quiet").code, 0);
    const Outcome outcome = shell("\"$TUMBLE\" render out/block --size 320x180 --quiet & process=$!\n"
                                  "while [ -e out/block/block.mp4 ] && kill -0 $process; do sleep 0.005; done\n"
                                  "kill -STOP $process; \"$TUMBLE\" gallery out --quiet; code=$?\n"
                                  "kill -CONT $process; wait $process && exit $code");
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.err, "tumble: another run is writing into out/block\n");
    EXPECT_FALSE(fs::exists(folder / "out/manifest.json"));
    ASSERT_EQ(tumble("gallery out --quiet").err, "");
    expect_true_hashes("out/manifest.json", "gallery");
}

TEST_F(kept, two_updates_of_a_baseline_at_once_leave_one_whole_baseline) {
    const Outcome outcome = shell("for size in 32x18 48x26 64x36; do\n"
                                  "\"$TUMBLE\" baseline update block.toml --size $size --frames 0,1,2 --quiet &\n"
                                  "done; wait\n\"$TUMBLE\" baseline check block.toml --fail-on noise --quiet");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
}

TEST_F(kept, a_disk_that_is_full_ends_a_study_with_its_reason) {
    // No file may be larger than 4 kB: a trajectory of the reference is.
    const Outcome outcome = shell("ulimit -f 4; \"$TUMBLE\" study block.toml --out s --no-film --quiet "
                                  "--knobs 'iteration limit' 2>&1");
    EXPECT_EQ(outcome.code, 3) << outcome.out;
    EXPECT_NE(outcome.out.find("cannot write s/block/points/"), std::string::npos) << outcome.out;
    test::expect_one_line(outcome.out);
}

TEST_F(kept, check_refuses_what_study_refuses) {
    std::ofstream(folder / "block.toml", std::ios::app) << "[study]\nlaw = \"rolling_ball\"\n";
    const Outcome check = tumble("check block.toml");
    const Outcome study = tumble("study block.toml --no-film --quiet");
    EXPECT_EQ(check.code, 2);
    EXPECT_EQ(check.err, study.err);
    EXPECT_EQ(tumble("run block.toml --preset preview --quiet").code, 2);
    EXPECT_FALSE(fs::exists(folder / "out/block"));
    sim::write_file(folder / "block.toml", test::scene_text + std::string("[study]\nseed_key = \"no.such\"\n"));
    EXPECT_EQ(tumble("check block.toml").code, 2);
}

TEST_F(kept, run_waits_while_another_program_installs_packages_and_says_so) {
    // Programs of these names stand for the system's; apt-get finds its lock taken twice.
    const Outcome outcome = shell(
        "mkdir bin && export PATH=$PWD/bin:$PATH\n"
        "printf '#!/bin/sh\\nexit 1\\n' >bin/dpkg-query\n"
        "printf '#!/bin/sh\\nexit 0\\n' >bin/cmake\n"
        "printf '#!/bin/sh\\nexec \"$@\"\\n' >bin/sudo\n"
        "printf '#!/bin/sh\\necho x >>'$PWD'/calls.txt\\n[ $(wc -l <'$PWD'/calls.txt) -gt 2 ] || "
        "{ echo E: Could not get lock /var/lib/apt/lists/lock; exit 100; }\\n' >bin/apt-get\n"
        "chmod +x bin/* && '" TUMBLE_SOURCE_DIR "/run' build");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("waiting: another program installs packages (E: Could not get lock"), std::string::npos)
        << outcome.out;
    EXPECT_EQ(bytes("calls.txt"), "x\nx\nx\nx\n"); // update three times, install
    EXPECT_EQ(shell("printf '#!/bin/sh\\necho E: no such package >&2; exit 100\\n' >bin/apt-get\n"
                    "PATH=$PWD/bin:$PATH '" TUMBLE_SOURCE_DIR "/run' build")
                  .code,
              1);
}
