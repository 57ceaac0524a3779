/// tumble study, as a user calls it.
#include "render/picture/image.h"
#include "tests/program/program_fixture.h"

namespace {

using test::Outcome;
namespace fs = std::filesystem;

class Study : public test::Program {
protected:
    Outcome study(const std::string& more) const {
        return tumble("study block.toml --out results --knobs 'iteration limit' " + more);
    }
};

TEST_F(Study, writes_table_diagram_film_and_page) {
    const Outcome outcome = study("--set simulation.iteration_limit=20");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("on the front; in results/block"), std::string::npos) << outcome.out;
    const std::string csv = bytes("results/block/study.csv");
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4) << csv; // titles, the scene's own, 3 and 10 sweeps
    const std::string page = bytes("results/block/index.html");
    EXPECT_NE(page.find("data:video/mp4;base64,AAAA"), std::string::npos);
    EXPECT_NE(page.find("10 sweeps"), std::string::npos);
    EXPECT_NE(page.find("<td>standard</td><td>overlap [m]</td>"), std::string::npos) << page;
    EXPECT_EQ(page.find("{{"), std::string::npos);
    EXPECT_NE(page.find("<svg"), std::string::npos);
    EXPECT_NE(bytes("results/block/diagram.svg").find(">tumble: iteration limit</text>"), std::string::npos);
    const render::Image diagram = render::read_image(folder / "results/block/diagram.png");
    EXPECT_EQ(diagram.width, 1000);
    EXPECT_GT(std::count_if(diagram.rgb.begin(), diagram.rgb.end(), [](std::uint8_t c) { return c < 128; }), 3000);
}

TEST_F(Study, keeps_what_is_done_and_computes_anew_what_has_changed) {
    ASSERT_EQ(study("--no-film --quiet").code, 0);
    const fs::path point = folder / "results/block/points/tumble-iteration_limit-3_sweeps-1.json";
    const fs::file_time_type before = fs::last_write_time(point);
    ASSERT_EQ(study("--no-film --quiet").code, 0);
    EXPECT_EQ(fs::last_write_time(point), before);
    ASSERT_EQ(study("--no-film --quiet --set simulation.tolerance=1e-5").code, 0);
    EXPECT_NE(fs::last_write_time(point), before);
}

TEST_F(Study, several_scenes_have_their_fronts_side_by_side) {
    fs::create_directory(folder / "scenes");
    fs::copy_file(folder / "block.toml", folder / "scenes/other.toml");
    ASSERT_EQ(tumble("study block.toml other --out results --knobs 'iteration limit' --no-film --quiet").code, 0);
    EXPECT_EQ(render::read_image(folder / "results/fronts.png").width, 1240);
    const std::string svg = bytes("results/fronts.svg");
    EXPECT_NE(svg.find(">tumble</text>"), std::string::npos) << svg;
}

TEST_F(Study, an_interrupted_one_goes_on) {
    const Outcome stopped = shell("timeout -s INT --preserve-status 0.7 \"$TUMBLE\" study block.toml --out results --no-film --set "
                                  "simulation.time_step=1/20000 --jobs 1");
    ASSERT_EQ(stopped.code, 130) << stopped.err;
    EXPECT_NE(stopped.err.find("interrupted; points that are done are kept"), std::string::npos) << stopped.err;
}

TEST_F(Study, a_point_beyond_the_limit_is_left_out) {
    const Outcome outcome =
        study("--no-film --limit 1 --set simulation.time_step=1/4000000");
    EXPECT_EQ(outcome.code, 5) << outcome.out;
    EXPECT_NE(outcome.err.find("not done after 1 s of processor time"), std::string::npos) << outcome.err;
}

TEST_F(Study, a_preset_changes_the_scene_below_what_is_set_and_says_what_it_reached) {
    const Outcome preview = tumble("simulate block.toml --out results --preset preview");
    ASSERT_EQ(preview.code, 0) << preview.err;
    EXPECT_NE(preview.out.find("block: preset preview: error - (promised -)"), std::string::npos) << preview.out;
    const std::string summary = bytes("results/block/summary.json");
    EXPECT_NE(summary.find("\"time_step\": \"1/250\""), std::string::npos) << summary;
    EXPECT_NE(summary.find("\"name\": \"preview\""), std::string::npos) << summary;
    ASSERT_EQ(tumble("simulate block.toml --out results --preset preview,draft --time-step 1/500 --quiet").code, 0);
    EXPECT_NE(bytes("results/block/summary.json").find("\"time_step\": \"1/500\""), std::string::npos);
    const std::string law = "simulate '" TUMBLE_SCENE_DIR "/laws/sliding_block.toml' --out results --preset ";
    for (const char* preset : {"preview", "standard", "accurate"}) {
        const Outcome outcome = tumble(law + preset);
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.out.find("error -"), std::string::npos) << outcome.out;
    }
}

TEST_F(Study, what_is_wrong_is_one_line) {
    for (const auto& [arguments, word] :
         {std::pair("study none.toml", "none.toml"), std::pair("study block.toml --knobs colour", "'colour'"),
          std::pair("study block.toml --set study.law=tower", "study.law"),
          std::pair("study block.toml --jobs 0", "--jobs"),
          std::pair("simulate block.toml --preset preview,accurate", "preview,accurate"),
          std::pair("simulate block.toml --preset quick", "quick")}) {
        const Outcome outcome = tumble(arguments);
        EXPECT_NE(outcome.code, 0) << arguments;
        test::expect_one_line(outcome.err);
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    }
}

} // namespace
