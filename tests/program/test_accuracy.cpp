/// tumble run and simulate with --accuracy and --budget; check --estimate.
#include "tests/program/program_fixture.h"

namespace {

using test::Outcome;

class Accuracy : public test::Program {};

TEST_F(Accuracy, is_found_and_the_film_is_that_of_the_settings_found) {
    const Outcome found = tumble("run block.toml --accuracy 1mm --poster 0.1");
    ASSERT_EQ(found.code, 0) << found.err;
    EXPECT_NE(found.out.find("block: accuracy 0.001 m: about "), std::string::npos) << found.out;
    const std::string summary = bytes("out/block/summary.json");
    EXPECT_NE(summary.find("\"outcome\": \"reached\""), std::string::npos) << summary;
    EXPECT_NE(summary.find("\"asked_m\": 0.001"), std::string::npos) << summary;
    // The same settings by hand.
    const std::size_t begin = summary.find("\"overrides\": [");
    std::string settings = summary.substr(begin, summary.find(']', begin) - begin);
    std::string by_hand = "run block.toml --out hand --quiet --poster 0.1";
    for (std::size_t at = settings.find("\"simulation."); at != std::string::npos; at = settings.find("\"simulation.", at + 1)) {
        std::string line = settings.substr(at + 1, settings.find('\n', at) - at - 1);
        line = line.substr(0, line.rfind('"'));
        for (std::size_t slash = line.find('\\'); slash != std::string::npos; slash = line.find('\\')) {
            line.erase(slash, 1);
        }
        by_hand += " --set '" + line + "'";
    }
    ASSERT_EQ(tumble(by_hand).code, 0) << by_hand;
    for (const char* file : {"trajectory.h5", "block.mp4", "frames/frame_000007.png", "block_poster.png"}) {
        EXPECT_EQ(bytes(std::string("out/block/") + file), bytes(std::string("hand/block/") + file)) << file;
    }
}

TEST_F(Accuracy, goes_with_nothing_that_it_finds_itself) {
    for (const auto& [options, word] :
         {std::pair("--tolerance 1e-5", "--tolerance"), std::pair("--time-step 1/100", "--time-step"),
          std::pair("--preset accurate", "a preset"), std::pair("--set simulation.impacts=stop", "simulation.impacts"),
          std::pair("--frames 0:2", "--frames"), std::pair("--resume", "--resume")}) {
        const Outcome refused = tumble(std::string("run block.toml --accuracy 1mm ") + options);
        EXPECT_EQ(refused.code, 2) << refused.err;
        EXPECT_NE(refused.err.find(word), std::string::npos) << refused.err;
        EXPECT_TRUE(refused.err.starts_with("tumble: --accuracy ")) << refused.err;
    }
    for (const char* length : {"1ft", "0", "-1mm", "mm", "1e999", "nan"}) {
        const Outcome refused = tumble(std::string("simulate block.toml --accuracy ") + length);
        EXPECT_EQ(refused.code, 2) << length;
        EXPECT_NE(refused.err.find("expected a number > 0 with one of the units m, cm, mm, um"), std::string::npos)
            << refused.err;
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << "nothing was made";
}

TEST_F(Accuracy, a_budget_is_kept_by_settings_that_are_said) {
    const Outcome run = shell("mkdir scratch; TMPDIR=scratch \"$TUMBLE\" run block.toml --budget 1min");
    ASSERT_EQ(run.code, 0) << run.err;
    EXPECT_TRUE(run.out.starts_with("block: 60 s allow steps of 1/")) << run.out;
    EXPECT_NE(run.out.find(" and pictures of the preset "), std::string::npos) << run.out;
    EXPECT_NE(run.out.find(" s of 60 s\n"), std::string::npos) << run.out;
    const std::string summary = bytes("out/block/summary.json");
    EXPECT_NE(summary.find("\"asked_s\": 60"), std::string::npos) << summary;
    EXPECT_NE(summary.find("simulation.time_step="), std::string::npos) << "the same run again, by hand";
    EXPECT_TRUE(std::filesystem::is_empty(folder / "scratch"));

    const Outcome draft = tumble("run block.toml --budget 1min --preset draft --out draft");
    ASSERT_EQ(draft.code, 0) << draft.err;
    EXPECT_EQ(draft.out.find("pictures of the preset"), std::string::npos) << "chosen already: " << draft.out;
}

TEST_F(Accuracy, a_budget_that_is_too_little_says_what_it_would_take) {
    const Outcome outcome = tumble("run block.toml --budget 0.2s");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_TRUE(outcome.err.starts_with("tumble: block: --budget 0.2 s is too little: the coarsest settings and the "
                                        "cheapest pictures take about "))
        << outcome.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << "nothing was made";
    EXPECT_EQ(tumble("run block.toml --budget 1s --accuracy 1mm").code, 2);
    EXPECT_NE(tumble("run block.toml --budget 1s --resume").err.find("--budget "), std::string::npos);
    EXPECT_NE(tumble("run block.toml --budget soon").err.find("units s, min, h"), std::string::npos);
}

TEST_F(Accuracy, check_estimates_time_disk_and_memory) {
    const Outcome outcome = tumble("check block.toml --estimate");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("block: estimate, of a pilot that simulated 100 % of it: simulation "), std::string::npos)
        << outcome.out;
    EXPECT_NE(outcome.out.find(" MB of memory\n"), std::string::npos) << outcome.out;
    EXPECT_FALSE(std::filesystem::exists(folder / "out")) << "nothing was made";
    const std::string in_part = tumble("check block.toml --estimate --time-step 1e-7").out; // beyond a pilot's second
    EXPECT_NE(in_part.find(" if contacts become no more than the pilot's "), std::string::npos) << in_part;
}

} // namespace
