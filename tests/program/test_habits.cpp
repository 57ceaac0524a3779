/// What a person types first: the program alone, its scenes, a scene of one's own, the manual, completion.
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

#include <sstream>

using test::Outcome;

class habits : public test::Program {};

TEST_F(habits, the_program_alone_prints_three_examples) {
    const Outcome outcome = tumble("");
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.out, "");
    std::size_t examples = 0;
    for (std::size_t at = outcome.err.find("\n  tumble "); at != std::string::npos;
         at = outcome.err.find("\n  tumble ", at + 1)) {
        ++examples;
    }
    EXPECT_EQ(examples, 3u) << outcome.err;
}

TEST_F(habits, scenes_are_listed_with_a_line_each) {
    EXPECT_EQ(tumble("scenes .").out, "./block.toml  A block falls\n");
    EXPECT_EQ(shell("mkdir scenes && cp block.toml scenes && \"$TUMBLE\" scenes").out,
              "scenes/block.toml  A block falls\n");
    EXPECT_EQ(tumble("scenes nowhere").err, "tumble: cannot read nowhere: No such file or directory\n");
    EXPECT_EQ(shell("mkdir empty; \"$TUMBLE\" scenes empty").err,
              "tumble: empty has no scene, no file that ends in .toml\n");
}

TEST_F(habits, a_new_scene_runs_and_is_never_written_over) {
    EXPECT_EQ(tumble("new first.toml").out, "first.toml written; tumble run first.toml makes its film\n");
    EXPECT_EQ(tumble("run first.toml --size 64x36 --duration 0.1 --quiet").err, "");
    EXPECT_TRUE(std::filesystem::exists(folder / "out/first/first.mp4"));
    const std::string text = bytes("first.toml");
    EXPECT_EQ(tumble("new first.toml").code, 2);
    EXPECT_EQ(bytes("first.toml"), text);
    EXPECT_EQ(tumble("new first").err, "tumble: 'first': expected a name that ends in .toml\n");
    EXPECT_EQ(tumble("new nowhere/first.toml").code, 3);
}

TEST_F(habits, a_scene_is_found_by_its_name_and_read_from_standard_input) {
    const std::string by_path = tumble("check block.toml").out;
    EXPECT_EQ(shell("mkdir scenes && cp block.toml scenes/heap.toml && \"$TUMBLE\" check heap").out.substr(5),
              by_path.substr(6)); // but for the name, with which it begins
    EXPECT_EQ(shell("\"$TUMBLE\" check - < block.toml").out.substr(6), by_path.substr(6));
    EXPECT_EQ(tumble("check hepa").err,
              "tumble: cannot read hepa: No such file or directory; did you mean 'heap'?\n");
    EXPECT_EQ(tumble("check mill").err, "tumble: cannot read mill: No such file or directory\n");
    EXPECT_EQ(tumble("check heap --camera x").err, "tumble: --camera x: output: there is no camera 'x'; expected one of: main\n");
    EXPECT_NE(shell("echo 'titel = 1' | \"$TUMBLE\" check -").err.find("stdin.toml:1:1: top of the file: unknown key "
                                                                       "'titel'; did you mean 'title'?"),
              std::string::npos);
}

TEST_F(habits, progress_for_machines_is_an_object_a_line) {
    const std::string lines = tumble("run block.toml --size 64x36 --progress json").err;
    ASSERT_NE(lines, "");
    std::istringstream stream(lines);
    nlohmann::json last;
    for (std::string line; std::getline(stream, line);) {
        last = nlohmann::json::parse(line);
        EXPECT_EQ(last["scene"], "block");
        EXPECT_EQ(last["unit"], "frames");
        EXPECT_LE(last["done"], last["total"]);
    }
}

TEST_F(habits, render_takes_the_folder_of_a_run) {
    EXPECT_EQ(tumble("simulate block.toml --duration 0.1 --quiet").code, 0);
    EXPECT_EQ(tumble("render out/block --size 64x36 --no-png --quiet").err, "");
    EXPECT_TRUE(std::filesystem::exists(folder / "out/block/block.mp4"));
}

TEST_F(habits, help_is_of_the_verb_alone) {
    const std::string join = tumble("help join").out;
    EXPECT_NE(join.find("tumble join out/funnel other/funnel"), std::string::npos) << join;
    EXPECT_EQ(join.find("tumble run"), std::string::npos) << join;
    EXPECT_EQ(join, tumble("join --help").out);
    EXPECT_NE(tumble("help baseline update").out.find("--for-this-renderer"), std::string::npos);
    EXPECT_NE(tumble("help").out.find("Exit status:"), std::string::npos);
    EXPECT_EQ(tumble("help jion").err, "tumble: help: unknown verb 'jion'; did you mean 'join'?\n");
}

TEST_F(habits, the_manual_has_every_verb_and_option_of_the_help) {
    const std::string manual = tumble("man").out;
    for (const char* part :
         {".SS tumble run\n", ".B \\-\\-size WxH\n", ".SS tumble compare\n", ".B SCENE\n", ".SH EXAMPLES",
          ".SS tumble baseline update\n", ".B \\-\\-for\\-this\\-renderer", ".SH EXIT STATUS\n.nf\n  0    good\n"}) {
        EXPECT_NE(manual.find(part), std::string::npos) << part;
    }
}

TEST_F(habits, bash_completes_verbs_and_the_options_of_each) {
    const auto completed = [this](const std::string& words, int word) {
        return shell("eval \"$(\"$TUMBLE\" completion)\"; COMP_WORDS=(" + words +
                     "); COMP_CWORD=" + std::to_string(word) + "; _tumble; echo \"${COMPREPLY[@]}\"")
            .out;
    };
    EXPECT_EQ(completed("tumble ren", 1), "render\n");
    EXPECT_EQ(completed("tumble run --res", 2), "--resume\n");
    EXPECT_EQ(completed("tumble join --res", 2), "\n");
    EXPECT_EQ(completed("tumble baseline up", 2), "update\n");
    EXPECT_EQ(completed("tumble run x.toml --color-by im", 4), "impulse\n");
    EXPECT_EQ(completed("tumble help jo", 2), "join\n");
    EXPECT_EQ(completed("tumble run fun", 2), "\n"); // bash then offers names of files
}
