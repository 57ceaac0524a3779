/// What a person does on the page of a comparison, done in a real browser.
#include "render/compare/report_page.h"
#include "sim/base/file_io.h"
#include "tests/page/browser.h"
#include "tests/page/sample_report.h"
#include "tests/support/out_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>

namespace {

namespace fs = std::filesystem;

const fs::path out_dir = test::out_folder("page");

std::string url_of(const fs::path& page) {
    return "file://" + fs::absolute(page).string();
}

/// One browser for all tests; each opens the page anew.
class report_page : public testing::Test {
protected:
    static void SetUpTestSuite() {
        write_sample_report(out_dir / "report", diff::PagePictures::inside);
        browser_ = std::make_unique<Browser>(out_dir / "browser");
    }
    static void TearDownTestSuite() { browser_.reset(); }

    void SetUp() override {
        browser_->resize(1280, 900);
        browser_->prefer("light");
        browser_->errors();
        open("");
    }
    void TearDown() override {
        EXPECT_EQ(browser_->errors(), "");
        EXPECT_EQ(browser_->value("performance.getEntriesByType('resource').filter("
                                  "e => !/^(data|file|blob):/.test(e.name)).map(e => e.name)"),
                  Browser::Json::array());
    }

    static Browser& browser() { return *browser_; }
    static void open(const std::string& place) {
        browser_->open(url_of(out_dir / "report" / "index.html") + place);
    }
    static std::string text(const std::string& selector) {
        return browser_->value(
            fmt::format("document.querySelector({}).innerText", Browser::Json(selector).dump()));
    }
    static std::string texts(const std::string& selector) {
        return browser_->value(
            fmt::format("Array.from(document.querySelectorAll({}), e => e.innerText).join('|')",
                        Browser::Json(selector).dump()));
    }
    static int count(const std::string& selector) {
        return browser_->value(
            fmt::format("document.querySelectorAll({}).length", Browser::Json(selector).dump()));
    }
    static bool is_visible(const std::string& selector) {
        return browser_->value(fmt::format("document.querySelector({})?.checkVisibility() ?? false",
                                           Browser::Json(selector).dump()));
    }
    /// The transformations of all pictures, without repetition.
    static Browser::Json transforms() {
        return browser_->value(
            "[...new Set(Array.from(document.querySelectorAll('.layer'), e => e.style.transform))]");
    }
    static double scale() {
        return browser_->value("new DOMMatrix(document.querySelector('.layer').style.transform).a");
    }

private:
    static std::unique_ptr<Browser> browser_;
};

std::unique_ptr<Browser> report_page::browser_;

} // namespace

TEST_F(report_page, summary_and_list_put_the_worst_first) {
    EXPECT_EQ(text("#verdict"), "✕ Failed: 4 of 6 cases");
    EXPECT_EQ(texts("li:not([hidden]) .case_name"),
              std::string("gone|moved cube|film|") + hostile_name + "|edges|same");
    EXPECT_EQ(text("#name"), "gone");
    EXPECT_EQ(text("#badge"), "! candidate missing");
    EXPECT_EQ(texts(".pane .empty"), "no candidate picture|no difference picture");
    EXPECT_EQ(browser().value("document.title"), "4 failed – comparison");
    browser().screenshot(out_dir / "missing.png");
}

TEST_F(report_page, filter_by_tier_and_name) {
    browser().click("[data-tier=changed]");
    EXPECT_EQ(texts("li:not([hidden]) .case_name"), std::string("moved cube|film|") + hostile_name);
    browser().type("#search", "FIL");
    EXPECT_EQ(texts("li:not([hidden]) .case_name"), "film");
    browser().type("#search", "nothing");
    EXPECT_TRUE(is_visible("#none"));
    browser().type("#search", "e");
    browser().click("[data-tier=noise]");
    EXPECT_EQ(texts("li:not([hidden]) .case_name"), "edges");
    browser().click("[data-tier=all]");
    EXPECT_EQ(text("[data-tier=all]"), "all 6");
}

TEST_F(report_page, a_case_shows_pictures_gates_clusters_and_bodies) {
    browser().click("[data-case='0']");
    EXPECT_EQ(text("#name"), "moved cube");
    EXPECT_EQ(text("#message"), "cube_3 moved 3 px, 7.2 mm");
    EXPECT_EQ(texts("figcaption .caption"), "reference|candidate|difference");
    EXPECT_TRUE(
        browser().wait_for("[...document.querySelectorAll('.layer')].every(e => e.naturalWidth === 320)"));
    EXPECT_EQ(texts(".gates tbody tr:nth-child(2) .number"), "3 px|≤ 0.5 px");
    EXPECT_EQ(texts(".gates .tier"), "✕ faint|✕ displacement|✓ drift");
    EXPECT_EQ(texts(".bodies tbody td"), "cube_3|moved|+3 px right, ±0 px down|7.2 mm|43×40 at 230, 100");
    EXPECT_EQ(count(".outline"), 3);
    browser().screenshot(out_dir / "light.png");
    browser().click("#outlines");
    EXPECT_EQ(count(".outline"), 0);
}

TEST_F(report_page, swipe_moves_the_divider_between_reference_and_candidate) {
    browser().click("[data-case='0']");
    browser().click("[data-mode=swipe]");
    const double width = browser().value("document.querySelector('.pane').clientWidth");
    browser().drag(".pane", width / 2, 100, width / 4, 100);
    EXPECT_NEAR(browser().value("document.querySelector('.clip').clientWidth").get<double>(), width / 4, 2);
    browser().value("document.querySelector('.divider').focus()");
    browser().press(key::right);
    EXPECT_NEAR(browser().value("document.querySelector('.clip').clientWidth").get<double>(), width * 0.27,
                2);
    browser().screenshot(out_dir / "swipe.png");
}

TEST_F(report_page, blink_shows_one_then_the_other_until_held) {
    browser().click("[data-case='0']");
    browser().press("b");
    const std::string visible =
        "[...document.querySelectorAll('.layer')].find(e => e.style.visibility === 'visible').alt";
    const std::string first = browser().value(visible);
    EXPECT_TRUE(browser().wait_for(visible + " !== '" + first + "'"));
    EXPECT_TRUE(browser().wait_for(visible + " === '" + first + "'"));
    browser().press(" ");
    EXPECT_NE(text(".caption").find("(held)"), std::string::npos);
    const std::string held = browser().value(visible);
    browser().press(" ");
    EXPECT_NE(browser().value(visible), held);
}

TEST_F(report_page, zoom_and_pan_move_all_pictures_in_step) {
    browser().click("[data-case='0']");
    const double fit = scale();
    browser().click("[data-zoom=in]");
    EXPECT_NEAR(scale(), 1.5 * fit, 1e-6);
    EXPECT_EQ(transforms().size(), 1u);
    browser().click("[data-zoom=one]");
    EXPECT_EQ(text("#zoom_label"), "100 %");
    const auto before = transforms();
    browser().drag(".pane", 100, 60, 140, 80);
    EXPECT_NE(transforms(), before);
    EXPECT_EQ(transforms().size(), 1u);
    // A click into the pictures, then the wheel zooms; the pixel under the pointer stays.
    browser().click_at(".pane:nth-child(2)", 50, 50);
    browser().scroll(".pane:nth-child(2)", 50, 50, -240);
    EXPECT_TRUE(browser().wait_for("document.querySelector('#zoom_label').innerText === '182 %'"))
        << text("#zoom_label");
    EXPECT_EQ(transforms().size(), 1u);
    browser().click("[data-zoom=fit]");
    EXPECT_NEAR(scale(), fit, 1e-9);
    browser().click(".clusters .link");
    EXPECT_GT(scale(), 1.5 * fit);
    browser().screenshot(out_dir / "zoomed.png");
}

TEST_F(report_page, the_values_of_the_pixel_under_the_pointer_are_shown) {
    browser().click("[data-case='0']");
    browser().press("1");
    browser().press("r");
    browser().press("0");
    const double s = scale();
    const double left = browser().value("new DOMMatrix(document.querySelector('.layer').style.transform).e");
    const double x = left + 231.5 * s;
    browser().click_at(".pane", x, 120.5 * s);
    EXPECT_TRUE(browser().wait_for("document.querySelector('#readout').innerText.includes('change')"));
    EXPECT_EQ(text("#readout"),
              "x 231, y 120\nreference 240 228 66\ncandidate 155 151 143\nchange −85 −77 +77");
    EXPECT_EQ(count(".mark"), 1);
    browser().move_to(".pane", x, 60.5 * s);
    EXPECT_EQ(text("#readout").substr(0, 12), "x 231, y 120"); // the marked one
    browser().click_at(".pane", x, 120.5 * s);
    EXPECT_EQ(count(".mark"), 0);
    browser().move_to(".pane", x, 60.5 * s);
    EXPECT_EQ(text("#readout").substr(0, 11), "x 231, y 60");
    browser().click_at(".pane", x, 120.5 * s);
    browser().press(key::down, true);
    EXPECT_EQ(text("#readout").substr(0, 12), "x 231, y 121");
    browser().press(key::right, true);
    browser().press(key::right, true);
    EXPECT_EQ(text("#readout"), "x 233, y 121\nreference 240 228 66\ncandidate 240 228 66\nchange none");
}

TEST_F(report_page, frames_of_a_sequence_are_stepped_and_jumped_to) {
    browser().click("[data-case='3']");
    EXPECT_EQ(text("#frame_label"), "✕ frame 6 7 of 12"); // the worst one
    EXPECT_EQ(text("#cause"), "The simulation changed: same scene and shaders, another state hash.");
    EXPECT_EQ(count("#strip button"), 3);
    EXPECT_EQ(texts("tr.differs td:first-child"), "State hash");
    browser().screenshot(out_dir / "sequence.png");
    browser().press(key::right);
    EXPECT_EQ(text("#frame_label"), "✕ frame 7 8 of 12");
    browser().press(key::right);
    EXPECT_TRUE(is_visible("#no_picture"));
    EXPECT_FALSE(is_visible("#viewer"));
    browser().press("f");
    EXPECT_EQ(text("#frame_label"), "✕ frame 5 6 of 12");
    browser().press("w");
    browser().press(key::left);
    browser().press(key::left);
    EXPECT_EQ(text("#frame_label"), "✓ frame 4 5 of 12");
    browser().click("#strip button:nth-child(3)");
    EXPECT_EQ(text("#frame_label"), "✕ frame 7 8 of 12");
    const double width = browser().value("document.querySelector('#curve').clientWidth");
    browser().click_at("#curve", width - 20, 50);
    EXPECT_EQ(text("#frame_label"), "✓ frame 11 12 of 12");
    EXPECT_EQ(browser().value("location.hash"), "#case=3&frame=11");
}

TEST_F(report_page, the_film_plays_and_follows_the_frame) {
    browser().click("[data-case='3']");
    EXPECT_TRUE(browser().wait_for("document.querySelector('#video').readyState >= 2 && "
                                   "document.querySelector('#film_time').innerText === 'frame 6'"));
    EXPECT_EQ(browser().value("document.querySelector('#video').videoWidth"), 3 * sample_width);
    browser().click("#frame_after");
    EXPECT_TRUE(browser().wait_for("document.querySelector('#film_time').innerText === 'frame 7'"));
    browser().click("[data-case='0']");
    EXPECT_FALSE(is_visible("#film"));
}

TEST_F(report_page, keys_lead_through_the_cases) {
    browser().press("j");
    EXPECT_EQ(text("#name"), "moved cube");
    browser().press("j");
    browser().press("k");
    EXPECT_EQ(text("#name"), "moved cube");
    browser().press("d");
    EXPECT_EQ(texts("figcaption .caption"), "difference");
    browser().press("?");
    EXPECT_TRUE(is_visible("#help"));
    browser().press(key::escape);
    EXPECT_FALSE(is_visible("#help"));
    browser().press("/");
    EXPECT_EQ(browser().value("document.activeElement.id"), "search");
    browser().press("x");
    EXPECT_EQ(browser().value("document.querySelector('#search').value"), "x");
}

// The sample's hostile name is quoted for the shell.
TEST_F(report_page, the_command_that_accepts_names_what_is_ticked) {
    open("");
    EXPECT_EQ(text("#accept code"), "tumble baseline accept out/report");
    EXPECT_EQ(browser().value("document.querySelectorAll('#cases input').length"), 5) << "all but what is the same";
    browser().click("[aria-label='accept moved cube']");
    EXPECT_EQ(text("#accept code"), "tumble baseline accept out/report 'moved cube'");
    browser().click("[aria-label='accept edges']");
    EXPECT_EQ(text("#accept code"), "tumble baseline accept out/report 'moved cube' edges");
    browser().click("[aria-label='accept moved cube']");
    EXPECT_EQ(text("#accept code"), "tumble baseline accept out/report edges");
}

TEST_F(report_page, captions_are_above_the_pictures_and_the_header_is_one_line) {
    browser().click("[data-case='0']");
    EXPECT_EQ(browser().value("[...document.querySelectorAll('.caption')].every(e => e.getBoundingClientRect().bottom <= "
                              "e.closest('figure').querySelector('.pane').getBoundingClientRect().top)"), true);
    EXPECT_LT(browser().value("document.querySelector('#top').offsetHeight"), 80);
}

TEST_F(report_page, the_last_runs_of_a_case_are_shown_and_the_flaky_marked) {
    browser().click("[data-case='1']");
    EXPECT_EQ(browser().value("document.querySelectorAll('#history .runs span').length"), 5);
    EXPECT_EQ(text("#history p"), "2 of the last 5 failed; flaky: the verdict changes to and fro");
    EXPECT_NE(text("[data-case='1'] .why").find("flaky"), std::string::npos);
    browser().click("[data-case='0']");
    EXPECT_EQ(browser().value("document.querySelectorAll('#history').length"), 0);
}

TEST_F(report_page, names_are_text_and_nothing_else) {
    open("#case=5");
    EXPECT_EQ(text("#name"), hostile_name);
    EXPECT_EQ(browser().value("document.title"), "4 failed – comparison");
}

TEST_F(report_page, light_and_dark) {
    const auto background = [] { return browser().value("getComputedStyle(document.body).backgroundColor"); };
    const Browser::Json light = background();
    browser().prefer("dark");
    browser().click("[data-case='0']");
    EXPECT_TRUE(browser().wait_for("document.documentElement.dataset.theme === 'dark'"));
    EXPECT_NE(background(), light);
    browser().screenshot(out_dir / "dark.png");
    browser().press("t");
    EXPECT_EQ(background(), light);
}

TEST_F(report_page, on_a_phone_list_and_case_take_turns) {
    browser().resize(390, 844, true);
    open("");
    EXPECT_TRUE(is_visible("#list"));
    EXPECT_FALSE(is_visible("#case"));
    browser().screenshot(out_dir / "phone_list.png");
    for (const std::string place : {"0", "3"}) {
        browser().click("[data-case='" + place + "']");
        EXPECT_FALSE(is_visible("#list"));
        EXPECT_EQ(browser().value("document.scrollingElement.scrollWidth"), 390);
        browser().screenshot(out_dir / ("phone_case_" + place + ".png"));
        const double fit = scale();
        browser().pinch(".pane", 180, 100, 60, 120);
        EXPECT_NEAR(scale() / fit, 2, 0.1);
        browser().click("#back");
        EXPECT_TRUE(is_visible("#list"));
    }
    EXPECT_EQ(browser().value("document.scrollingElement.scrollWidth"), 390);
}

TEST_F(report_page, pictures_beside_the_page_are_shown) {
    write_sample_report(out_dir / "report_linked", diff::PagePictures::linked);
    const std::string page = sim::read_text_file(out_dir / "report_linked" / "index.html");
    EXPECT_EQ(page.find("class=\"picture\""), std::string::npos);
    browser().open(url_of(out_dir / "report_linked" / "index.html") + "#case=1");
    EXPECT_TRUE(
        browser().wait_for("[...document.querySelectorAll('.layer')].every(e => e.naturalWidth === 320)"));
    EXPECT_EQ(browser().value("document.querySelector('.layer').getAttribute('src')"),
              "pictures/edges/edges.reference.png");
    browser().move_to(".pane", 60, 60);
    EXPECT_TRUE(browser().wait_for("document.querySelector('#readout').innerText.includes('over http')"));
}
