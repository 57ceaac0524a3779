/// The page of a folder of results, in a real browser.
#include "render/compare/gallery_page.h"
#include "sim/base/file_io.h"
#include "tests/page/browser.h"
#include "tests/page/sample_report.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

namespace {

namespace fs = std::filesystem;

const fs::path gallery_dir = test::out_folder("page/gallery");

void write_sample_gallery() {
    fs::remove_all(gallery_dir);
    write_sample_report(gallery_dir / "check", diff::PagePictures::linked);
    diff::Gallery gallery;
    gallery.program = "tumble 0.1.0";
    gallery.reports = {{"check", "check/index.html", 6, 4}};
    for (const std::string name : {"funnel", "office toy"}) {
        diff::GalleryRun run;
        run.name = name;
        run.title = "A film & its figures";
        run.film = "check/film.mp4";
        run.poster = "check/pictures/edges/edges.reference.png";
        run.facts = {{"bodies", "1005"}, {"state hash", "34f784c5593953b8"}};
        run.files = {"check/film.mp4"};
        for (int i = 0; i <= 100; ++i) {
            const double t = 0.02 * i;
            run.energy.push_back({t, 500 * t * t, 3000 - 500 * t * t});
        }
        gallery.runs.push_back(run);
    }
    gallery.texts = {{"laws.md", "| law | error |\n| a < b | 1e-9 |\n"}};
    sim::write_file(gallery_dir / "index.html", diff::gallery_page(gallery));
}

/// A run with its glTF in gallery_dir / "solid", by the program.
void write_solid_gallery() {
    const std::string parent = gallery_dir.string();
    const auto tumble = [&](const std::string& words) {
        const std::string command = "cd '" + parent + "' && '" TUMBLE_PROGRAM "' " + words + " --quiet";
        ASSERT_EQ(std::system(command.c_str()), 0) << command;
    };
    tumble("run '" TUMBLE_SCENE_DIR "/inclined_blocks.toml' --out solid --size 160x90 --fps 10 --duration 0.5 "
           "--set output.speed=0.5");
    tumble("export solid/inclined_blocks --gltf solid/inclined_blocks/blocks.glb");
    tumble("gallery solid");
}

/// The film's slider is that of the model, which the mouse turns; nothing comes from a network.
void look_in_three_dimensions(Browser& browser) {
    write_solid_gallery();
    browser.open("file://" + fs::absolute(gallery_dir / "solid/index.html").string());
    browser.click("[data-model]");
    const std::string canvas = "document.querySelector('canvas')";
    EXPECT_TRUE(browser.wait_for(canvas + "?.dataset.time === '0'"));
    const Browser::Json start = browser.value(canvas + ".toDataURL()");
    browser.value("document.querySelector('video').currentTime = 0.4");
    EXPECT_TRUE(browser.wait_for("Math.abs(" + canvas + ".dataset.time - 0.2) < 0.01"));
    const Browser::Json later = browser.value(canvas + ".toDataURL()");
    EXPECT_NE(later, start);
    browser.screenshot(gallery_dir / "solid.png");
    browser.value(canvas + ".dispatchEvent(new PointerEvent('pointermove', {buttons: 1, movementX: 60, movementY: 9}))");
    EXPECT_TRUE(browser.wait_for(canvas + ".toDataURL() !== '" + later.get<std::string>() + "'"));
    browser.click("[data-model]");
    EXPECT_EQ(browser.value(canvas + ".hidden"), true);
    EXPECT_EQ(browser.errors(), "");
}

} // namespace

TEST(gallery_page, films_play_one_at_a_time_in_light_and_dark_on_desk_and_phone) {
    write_sample_gallery();
    Browser browser(gallery_dir / "browser");
    browser.resize(1280, 900);
    browser.prefer("light");
    browser.open("file://" + fs::absolute(gallery_dir / "index.html").string());
    EXPECT_EQ(browser.value("document.querySelectorAll('article').length"), 4);
    EXPECT_EQ(browser.value("document.querySelector('.verdict').innerText"), "✕ 4 failed");
    EXPECT_EQ(browser.value("document.querySelectorAll('.plot path').length"), 6);
    browser.screenshot(gallery_dir / "light.png");

    const std::string film = "document.querySelectorAll('video')";
    browser.value(film + "[0].play()");
    EXPECT_TRUE(browser.wait_for(film + "[0].currentTime > 0.1"));
    browser.value(film + "[1].play()");
    EXPECT_TRUE(browser.wait_for(film + "[0].paused && !" + film + "[1].paused"));

    const std::string background = "getComputedStyle(document.body).backgroundColor";
    const Browser::Json light = browser.value(background);
    browser.click("#theme");
    EXPECT_NE(browser.value(background), light);

    look_in_three_dimensions(browser);

    browser.prefer("dark");
    browser.resize(390, 844, true);
    browser.open("file://" + fs::absolute(gallery_dir / "index.html").string());
    EXPECT_NE(browser.value(background), light);
    EXPECT_EQ(browser.value("document.scrollingElement.scrollWidth"), 390);
    browser.screenshot(gallery_dir / "phone.png");
    browser.click("article a");
    EXPECT_TRUE(browser.wait_for("document.title === '4 failed – comparison'"));
    EXPECT_EQ(browser.errors(), "");
}
