/// tumble gallery: the page of a folder of results, its posters and manifest.
#include "render/picture/image.h"
#include "sim/base/file_io.h"
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

using test::Outcome;

class gallery : public test::Program {};

TEST_F(gallery, shows_every_run_and_the_manifest_holds_every_file_it_links) {
    ASSERT_EQ(tumble("run block.toml --out results --quiet").code, 0);
    ASSERT_EQ(tumble("simulate block.toml --out results --set 'title=\"a < b\"' --quiet && "
                     "mv results/block 'results/no film' && cp -r 'results/no film' results/x && "
                     "\"$TUMBLE\" run block.toml --out results --quiet && mkdir results/bench && "
                     "echo '1 < 2' > results/bench/speed.txt")
                  .code,
              0);
    const Outcome outcome = tumble("gallery results");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "runs: 3, reports: 0; in results/index.html\n");
    const std::string page = bytes("results/index.html");
    for (const char* part :
         {"src=\"block/block.mp4\" poster=\"block/poster.png\"", "href=\"no%20film/summary.json\"",
          "a &lt; b", "1 &lt; 2", "class=\"kinetic\""}) {
        EXPECT_NE(page.find(part), std::string::npos) << part;
    }
    EXPECT_EQ(render::read_image(folder / "results/block/poster.png").width, 320);

    const nlohmann::json manifest = nlohmann::json::parse(bytes("results/manifest.json"));
    std::set<std::string> names;
    for (const nlohmann::json& file : manifest.at("files")) {
        const std::string name = file.at("name");
        names.insert(name);
        EXPECT_EQ(file.at("sha256"), sim::sha256_of_file(folder / "results" / name)) << name;
        EXPECT_EQ(file.at("bytes"), std::filesystem::file_size(folder / "results" / name)) << name;
    }
    EXPECT_EQ(names,
              (std::set<std::string>{"index.html", "bench/speed.txt", "block/block.mp4", "block/poster.png",
                                     "block/summary.json", "block/trajectory.h5", "no film/summary.json",
                                     "no film/trajectory.h5", "x/summary.json", "x/trajectory.h5"}));
    EXPECT_EQ(tumble("gallery results --quiet").out, "");
    EXPECT_EQ(bytes("results/index.html"), page);
}

TEST_F(gallery, shows_studies_animations_and_exports) {
    ASSERT_EQ(tumble("run block.toml --out results --webp --no-video --quiet && \"$TUMBLE\" export results/block "
                     "--gltf results/block/block.glb --csv results/block/block.csv --quiet && "
                     "mkdir -p results/study/one && "
                     "echo page > results/study/one/index.html && echo a > results/study/one/study.csv && "
                     "echo '<svg/>' > results/study/one/diagram.svg")
                  .code,
              0);
    EXPECT_EQ(tumble("gallery results --quiet").err, "");
    const std::string page = bytes("results/index.html");
    for (const char* part :
         {"src=\"block/block.webp\"", "href=\"block/block.glb\"", "href=\"block/block.csv\"",
          "<a href=\"study/one/index.html\"><img src=\"study/one/diagram.svg\""}) {
        EXPECT_NE(page.find(part), std::string::npos) << part;
    }
    // What a page on a disk loads: a call with the file's bytes.
    EXPECT_TRUE(bytes("results/block/block.glb.js").starts_with("solid.arrived(\"block/block.glb\", \"Z2xURgIAAA"));
    EXPECT_NE(bytes("results/manifest.json").find("block/block.glb.js"), std::string::npos);
    // The glTF of an earlier simulation is no film's.
    EXPECT_EQ(shell("touch results/block/trajectory.h5; \"$TUMBLE\" gallery results --quiet").err, "");
    EXPECT_EQ(bytes("results/manifest.json").find("block/block.glb.js"), std::string::npos);
}

TEST_F(gallery, what_is_no_result_is_one_line_and_no_page) {
    EXPECT_EQ(tumble("gallery nowhere").err, "tumble: cannot read nowhere: No such file or directory\n");
    EXPECT_EQ(
        shell("mkdir empty; \"$TUMBLE\" gallery empty").err,
        "tumble: empty has no run, no report and no study: no folder in it has a summary.json, a result.json or a "
        "study.csv\n");
    EXPECT_EQ(shell("mkdir -p bad/run; echo '{' > bad/run/summary.json; \"$TUMBLE\" gallery bad").err,
              "tumble: cannot read bad/run/summary.json: it is damaged\n");
    EXPECT_EQ(shell("echo '{}' > bad/run/summary.json; \"$TUMBLE\" gallery bad").err,
              "tumble: cannot read bad/run/summary.json: it is no summary of a run\n");
    EXPECT_EQ(tumble("gallery bad").code, 3);
    EXPECT_EQ(files_in("bad"), (std::set<std::string>{"run/summary.json"}));
}
