// Reports of several cases at once: folders of runs, single pictures, the file that grows from run to run.
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

namespace {

namespace fs = std::filesystem;

class reports : public test::Program {
protected:
    nlohmann::json result(const std::string& report) const {
        return nlohmann::json::parse(bytes(report + "/result.json"));
    }
};

} // namespace

TEST_F(reports, two_folders_of_runs_and_pictures_are_compared_in_one_call) {
    ASSERT_EQ(shell("\"$TUMBLE\" run block.toml --size 160x90 --no-video --quiet --out a && cp -r a b && "
                    "cp -r b/block b/second && cp a/block/frames/frame_000000.png a/title.png && "
                    "cp b/block/frames/frame_000007.png b/title.png && cp a/title.png a/end.png && cp a/title.png b/end.png && "
                    "cp b/title.png b/block/frames/frame_000003.png").code, 0);
    const test::Outcome outcome = tumble("compare a b --report report --pictures 1 --history history.jsonl");
    EXPECT_EQ(outcome.code, 4) << outcome.err;
    const nlohmann::json cases = result("report")["cases"];
    ASSERT_EQ(cases.size(), 4u) << outcome.out;
    EXPECT_EQ(cases[0]["name"], "end.png");
    EXPECT_EQ(cases[0]["tier"], "identical");
    EXPECT_EQ(cases[1]["name"], "title.png");
    EXPECT_EQ(cases[1]["tier"], "changed");
    EXPECT_EQ(cases[2]["name"], "block");
    EXPECT_EQ(cases[2]["first_bad_frame"], 3);
    EXPECT_NE(outcome.out.find("first bad frame 3 (frame_000003.png)"), std::string::npos) << outcome.out;
    EXPECT_EQ(cases[3]["status"], "reference_missing");
    // One picture a case, of each side and of the difference; of a missing side none.
    EXPECT_EQ(files_in("report/pictures").size(), 3u + 3u + 1u);
    const std::string history = bytes("history.jsonl");
    EXPECT_EQ(std::count(history.begin(), history.end(), '\n'), 4);
    EXPECT_EQ(cases[1]["history"].size(), 1u);
    const auto cases_of = [this](const std::string& threads) {
        return nlohmann::json::parse(tumble("compare a b --json --threads " + threads).out)["cases"].dump();
    };
    EXPECT_TRUE(cases_of("3") == cases_of("1"));
}

TEST_F(reports, of_baselines_keep_each_picture_once_and_say_how_to_accept) {
    ASSERT_EQ(tumble("baseline update block.toml --frames 0,4 --size 160x90 --quiet").code, 0);
    ASSERT_EQ(shell("sed -i 's/0, 0, 0.9/0, 0, 1.0/' block.toml && \"$TUMBLE\" baseline check --history history.jsonl --quiet").code, 1);
    const nlohmann::json report = result("out/baselines");
    EXPECT_EQ(report["accept"], "tumble baseline accept out/baselines");
    EXPECT_EQ(report["cases"][0]["history"].size(), 1u);
    for (const nlohmann::json& frame : report["cases"][0]["frames"]) {
        const std::string picture = frame["candidate_picture"];
        EXPECT_EQ(picture.substr(0, 11), "candidates/") << picture;
        EXPECT_TRUE(fs::exists(folder / "out/baselines" / picture)) << picture;
    }
    EXPECT_EQ(files_in("out/baselines/pictures").size(), 4u); // reference and difference of two frames
    EXPECT_EQ(tumble("baseline check --quiet").code, 1);
    EXPECT_EQ(tumble("baseline accept out/baselines --quiet").code, 0);
    EXPECT_EQ(tumble("baseline check --quiet").code, 0);
}
