// Folders, statuses, shifted frames, masks, bodies, limits, and what is reported of them.
#include "render/compare/bodies.h"
#include "render/compare/limits_file.h"
#include "render/compare/report.h"
#include "render/compare/sequence.h"
#include "render/compare/side_by_side.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "tests/compare/painter.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <stb_image_write.h>

#include <filesystem>
#include <memory>
#include <vector>

namespace {

namespace fs = std::filesystem;
using diff::Status;
using diff::Tier;

class sequence : public testing::Test {
protected:
    fs::path folder;
    diff::Settings settings;

    void SetUp() override {
        folder = test::out_folder("compare") /
                 testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        fs::create_directories(folder / "a");
        fs::create_directories(folder / "b");
        settings.threads = 2;
    }

    /// Frame t: a disc that has moved by 7 t pixels.
    static test::Scene scene(int t) {
        test::Scene s;
        s.width = 96;
        s.height = 64;
        s.shapes.push_back({test::Shape::Kind::disc, 15.0 + 7 * t, 55, 8, 0, {200, 30, 30}});
        return s;
    }
    void write(const std::string& name, const test::Scene& s, const test::Pattern& pattern = test::grid_pattern(2)) const {
        sim::write_file(folder / name, diff::encode_png(test::paint(s, pattern)));
    }
    void write_jpeg(const std::string& name, const diff::Picture& picture, int quality) const {
        diff::Bytes file;
        stbi_write_jpg_to_func(
            [](void* to, void* data, int size) {
                const auto* bytes = static_cast<std::uint8_t*>(data);
                static_cast<diff::Bytes*>(to)->insert(static_cast<diff::Bytes*>(to)->end(), bytes, bytes + size);
            },
            &file, picture.width, picture.height, 3, picture.rgb.data(), quality);
        sim::write_file(folder / name, file);
    }
    void write_frames(const std::string& side, int first, int last) const {
        for (int t = first; t < last; ++t) {
            write(side + "/f" + std::to_string(t - first + 10) + ".png", scene(t));
        }
    }
    diff::Case compared(const std::string& a = "a", const std::string& b = "b") const {
        return diff::compare_sources("case", {diff::find_source(folder / a), diff::find_source(folder / b)}, settings, nullptr, {});
    }
    static int code_of(const diff::Case& c) {
        diff::Comparison comparison;
        comparison.cases.push_back(c);
        diff::sum_up(comparison);
        return comparison.exit_code;
    }
};

/// Keeps what is shown; a film that is not finished has shown nothing.
class KeptFilm : public diff::FilmWriter {
public:
    explicit KeptFilm(std::vector<diff::Picture>& shown) : shown_(shown) {}
    void add(const diff::Picture& picture) override { pictures_.push_back(picture); }
    void finish() override { shown_ = pictures_; }

private:
    std::vector<diff::Picture>& shown_;
    std::vector<diff::Picture> pictures_;
};

} // namespace

TEST_F(sequence, equal_folders_are_identical) {
    write_frames("a", 0, 5);
    write_frames("b", 0, 5);
    const diff::Case c = compared();
    EXPECT_EQ(c.tier, Tier::identical);
    EXPECT_EQ(c.frames.size(), 5u);
    EXPECT_EQ(c.frames[0].width, 96);
    EXPECT_FALSE(c.is_failed);
    EXPECT_FALSE(c.first_bad_frame.has_value());
    EXPECT_EQ(code_of(c), 0);
}

TEST_F(sequence, bad_frames_are_found_counted_and_ranked) {
    write_frames("a", 0, 10);
    write_frames("b", 0, 10);
    write("b/f12.png", scene(2), test::rotated_pattern); // noise
    test::Scene changed = scene(4);
    changed.shapes[0].color[2] = 150;
    write("b/f14.png", changed);
    changed = scene(5);
    changed.shapes.clear();
    write("b/f15.png", changed);
    write("b/f18.png", changed);
    const diff::Case c = compared();
    EXPECT_EQ(c.tier, Tier::changed);
    EXPECT_EQ(c.frames[2].tier, Tier::noise);
    // The numbers are those of the files.
    EXPECT_EQ(c.first_bad_frame, 14);
    const double worst = c.frames.at(static_cast<std::size_t>(c.worst_frame.value_or(0) - 10)).curve;
    for (const diff::Frame& frame : c.frames) {
        EXPECT_LE(frame.curve, worst);
    }
    EXPECT_GT(worst, 1.0);
    EXPECT_NE(c.message.find("first bad frame 14 (f14.png): "), std::string::npos) << c.message;
    ASSERT_EQ(c.bad_runs.size(), 2u);
    EXPECT_EQ(c.bad_runs[0].begin, 14);
    EXPECT_EQ(c.bad_runs[0].end, 16);
    EXPECT_EQ(c.bad_runs[1].begin, 18);
    EXPECT_FALSE(c.shift.has_value());
    EXPECT_EQ(code_of(c), 1);

    settings.fail_on = Tier::noise;
    EXPECT_EQ(compared().first_bad_frame, 12);
}

TEST_F(sequence, one_and_three_threads_find_the_same) {
    write_frames("a", 0, 7);
    write_frames("b", 1, 8);
    diff::Comparison comparison;
    settings.threads = 1;
    comparison.cases.push_back(compared());
    const std::string one = diff::to_json(comparison);
    settings.threads = 3;
    comparison.cases.front() = compared();
    EXPECT_EQ(one, diff::to_json(comparison));
}

TEST_F(sequence, frames_out_of_step_are_told) {
    write_frames("a", 0, 9);
    write_frames("b", 2, 11);
    EXPECT_EQ(compared().shift, -2); // candidate frame i - 2 is reference frame i
    EXPECT_EQ(compared("b", "a").shift, 2);
}

TEST_F(sequence, missing_extra_unreadable_and_resized_frames_each_have_their_status) {
    write_frames("a", 0, 5);
    write_frames("b", 0, 5);
    fs::remove(folder / "a/f10.png");
    fs::remove(folder / "b/f11.png");
    sim::write_file(folder / "b/f12.png", std::string("no picture"));
    test::Scene larger = scene(3);
    larger.width = 97;
    write("b/f13.png", larger);
    const diff::Case c = compared();
    ASSERT_EQ(c.frames.size(), 5u);
    EXPECT_EQ(c.frames[0].status, Status::reference_missing);
    EXPECT_EQ(c.frames[1].status, Status::candidate_missing);
    EXPECT_EQ(c.frames[2].status, Status::unreadable);
    EXPECT_EQ(c.frames[3].status, Status::size_differs);
    EXPECT_EQ(c.frames[4].tier, Tier::identical);
    EXPECT_EQ(c.extra_frames, std::vector<std::int64_t>{10});
    EXPECT_EQ(c.missing_frames, std::vector<std::int64_t>{11});
    EXPECT_TRUE(c.is_failed);
    EXPECT_EQ(code_of(c), 4);

    // Something to look at in each case.
    diff::Case reviewed = c;
    diff::write_review({diff::find_source(folder / "a"), diff::find_source(folder / "b")}, settings,
                       {.folder = folder}, nullptr, reviewed);
    EXPECT_TRUE(fs::exists(folder / reviewed.frames[0].candidate_picture));
    EXPECT_TRUE(fs::exists(folder / reviewed.frames[1].reference_picture));
    EXPECT_TRUE(fs::exists(folder / reviewed.frames[2].reference_picture));
    EXPECT_EQ(reviewed.frames[2].candidate_picture, "");
    EXPECT_TRUE(fs::exists(folder / reviewed.frames[3].difference_picture));
    EXPECT_TRUE(reviewed.frames[4].reference_picture.empty());
}

TEST_F(sequence, equal_garbage_is_no_pass) {
    sim::write_file(folder / "a.png", std::string("garbage"));
    sim::write_file(folder / "b.png", std::string("garbage"));
    const diff::Case c = compared("a.png", "b.png");
    EXPECT_EQ(c.status, Status::unreadable);
    EXPECT_EQ(code_of(c), 3);
}

TEST_F(sequence, missing_sides_and_mixed_kinds) {
    write_frames("a", 0, 2);
    write("one.png", scene(0));
    EXPECT_EQ(compared("a", "nowhere").status, Status::candidate_missing);
    EXPECT_EQ(compared("nowhere", "a").status, Status::reference_missing);
    EXPECT_EQ(code_of(compared("nowhere", "one.png")), 4);
    EXPECT_THROW(compared("nowhere", "nowhere"), sim::Error);
    EXPECT_THROW(compared("a", "one.png"), sim::Error);
    EXPECT_THROW(compared("a", "b"), sim::Error); // b is empty
}

TEST_F(sequence, masks_leave_out_rectangles_and_bright_pixels) {
    test::Scene changed = scene(1);
    changed.shapes[0].color[2] = 150;
    write("a.png", scene(1));
    write("b.png", changed);
    EXPECT_EQ(compared("a.png", "b.png").tier, Tier::changed);
    diff::add_to_mask("10,40,30,24", {}, settings.pair.mask);
    EXPECT_EQ(compared("a.png", "b.png").tier, Tier::identical);

    settings.pair.mask = {};
    diff::Picture mask = test::paint(scene(1), test::grid_pattern(1));
    for (std::size_t i = 0; i < mask.rgb.size(); i += 3) {
        const bool is_disc = mask.rgb[i] > 150 && mask.rgb[i + 1] < 100;
        mask.rgb[i] = mask.rgb[i + 1] = mask.rgb[i + 2] = is_disc ? 255 : 0;
    }
    sim::write_file(folder / "mask.png", diff::encode_png(mask));
    diff::add_to_mask((folder / "mask.png").string(), {}, settings.pair.mask);
    EXPECT_NE(compared("a.png", "b.png").tier, Tier::changed);
    EXPECT_THROW(diff::add_to_mask("1,2,3", {}, settings.pair.mask), sim::Error);
}

// JPEG keeps colours at half the size and rings at edges.
TEST_F(sequence, a_jpeg_file_differs_from_its_picture_by_noise_and_from_a_changed_one_by_more) {
    for (const std::uint32_t seed : {112u, 113u, 114u}) {
        test::Scene before = test::make_scene(seed, 30, 0);
        before.shapes.push_back({test::Shape::Kind::box, 150, 100, 12, 0.4, {200, 60, 50}});
        test::Scene after = before;
        after.shapes.back().x += 4;
        write("a.png", before);
        for (const auto& [scene, tier] : {std::pair{before, Tier::noise}, {after, Tier::changed}}) {
            const diff::Picture picture = test::paint(scene, test::grid_pattern(2));
            write_jpeg("b.jpg", picture, 90);
            for (const diff::Case& c : {compared("a.png", "b.jpg"), compared("b.jpg", "a.png")}) {
                EXPECT_EQ(c.tier, tier) << "scene " << seed << ": " << c.message;
            }
        }
    }
}

// Between the steps of the file all of a title card lies to the same side.
TEST_F(sequence, a_plain_colour_of_a_jpeg_file_is_a_little_off) {
    diff::Picture card = test::paint(scene(0), test::grid_pattern(1));
    for (int green = 20; green < 40; ++green) {
        for (std::size_t i = 0; i < card.rgb.size(); i += 3) {
            card.rgb[i] = 17;
            card.rgb[i + 1] = static_cast<std::uint8_t>(green);
            card.rgb[i + 2] = 48;
        }
        sim::write_file(folder / "a.png", diff::encode_png(card));
        write_jpeg("b.jpg", card, 85);
        EXPECT_LE(compared("a.png", "b.jpg").tier, Tier::noise) << green;
    }
}

// Other samples touch all edges, by which the gates know them as noise; masks must not hide that.
TEST_F(sequence, noise_stays_noise_however_much_is_masked) {
    const test::Scene cubes = test::make_scene(110, 120, 2);
    write("a.png", cubes, test::grid_pattern(2));
    write("b.png", cubes, test::grid_pattern(1));
    ASSERT_EQ(compared("a.png", "b.png").tier, Tier::noise);
    for (const int width : {80, 160, 240, 300}) {
        settings.pair.mask = {};
        diff::add_to_mask("0,0," + std::to_string(width) + ",180", {}, settings.pair.mask);
        const diff::Case c = compared("a.png", "b.png");
        EXPECT_NE(c.tier, Tier::changed) << width << ": " << c.message;
    }
}

TEST_F(sequence, masks_that_leave_no_pixel_are_an_error) {
    write("a.png", scene(1));
    write("b.png", scene(2));
    diff::add_to_mask("0,0,50,64", {}, settings.pair.mask);
    EXPECT_NO_THROW(compared("a.png", "b.png"));
    diff::add_to_mask("50,0,50,64", {}, settings.pair.mask);
    EXPECT_THROW(compared("a.png", "b.png"), sim::Error);
    EXPECT_THROW(compared("a.png", "a.png"), sim::Error);
}

TEST_F(sequence, bodies_are_named_and_can_be_ignored) {
    test::Scene before = scene(1);
    before.shapes.push_back({test::Shape::Kind::box, 70, 50, 9, 0, {40, 60, 200}});
    before.shapes.push_back({test::Shape::Kind::box, 48, 58, 4, 0, {40, 160, 20}});
    test::Scene after = before;
    after.shapes[0].y -= 2;
    after.shapes.pop_back();
    const auto write_side = [&](const std::string& side, const test::Scene& s, double height) {
        write(side + "/f.png", s);
        // The same shapes in the colours of their numbers.
        test::Scene numbers = s;
        numbers.shade = 0;
        numbers.floor = numbers.sky = {0, 0, 0};
        for (std::size_t i = 0; i < s.shapes.size(); ++i) {
            numbers.shapes[i].color = {double(i + 1), 0, 0};
        }
        sim::write_file(folder / side / "f.bodies.png", diff::encode_png(test::paint(numbers, test::grid_pattern(1))));
        const nlohmann::json names = {{"names", {"ball", "crate", "chip"}},
                                      {"positions", {{0, 0, height}, {1, 0, 0}, {2, 0, 0}}}};
        sim::write_file(folder / side / "f.bodies.json", names.dump());
    };
    write_side("a", before, 0.0);
    write_side("b", after, 0.004);
    const diff::Case c = compared();
    ASSERT_EQ(c.frames.size(), 1u) << "the images of bodies are no frames";
    ASSERT_GE(c.frames[0].bodies.size(), 2u);
    for (const diff::BodyChange& change : c.frames[0].bodies) {
        if (change.name == "ball") {
            EXPECT_EQ(change.kind, diff::BodyChange::Kind::moved);
            EXPECT_NEAR(change.displacement.y, -2.0, 0.3);
            EXPECT_NEAR(change.distance.value_or(0), 0.004, 1e-12);
        } else {
            EXPECT_EQ(change.name, "chip");
            EXPECT_EQ(change.kind, diff::BodyChange::Kind::missing);
        }
    }
    EXPECT_NE(c.message.find("ball moved by"), std::string::npos) << c.message;
    EXPECT_NE(c.message.find("chip is missing"), std::string::npos) << c.message;

    settings.pair.ignored_bodies = {"ball", "chip"};
    EXPECT_NE(compared().tier, Tier::changed);
    settings.pair.ignored_bodies = {"bell"};
    EXPECT_THROW(compared(), sim::Error);
}

TEST_F(sequence, the_cause_is_told_by_the_files_of_runs) {
    const auto write_run = [&](const std::string& side, const char* hash, const char* shaders, const char* renderer) {
        fs::create_directories(folder / side / "frames");
        write(side + "/frames/f0.png", scene(side == "a" ? 0 : 1));
        sim::write_file(folder / side / "frames/run.json",
                        std::string(R"({"program":"tumble","scene_name":"s","scene_text":"x","overrides":[]})"));
        sim::write_file(folder / side / "summary.json", nlohmann::json{{"state_hash", hash}, {"shaders_hash", shaders}, {"renderer", renderer}}.dump());
    };
    write_run("a", "1", "2", "3");
    write_run("b", "9", "9", "9");
    EXPECT_EQ(compared().cause, diff::Cause::simulation);
    write_run("b", "1", "9", "9");
    EXPECT_EQ(compared().cause, diff::Cause::drawing);
    write_run("b", "1", "2", "9");
    EXPECT_EQ(compared().cause, diff::Cause::machine);
    write_run("b", "1", "2", "3");
    EXPECT_EQ(compared().cause, diff::Cause::unknown);
    sim::write_file(folder / "b/frames/run.json", std::string(R"({"scene_text":"y","overrides":[]})"));
    EXPECT_EQ(compared().cause, diff::Cause::scene);
}

// Each of the gates alone lets its pair fail: a colour, a pixel of salt, the focus, a level.
TEST_F(sequence, calibrated_limits_pass_what_they_were_made_from) {
    const test::Scene before = test::make_scene(111, 30, 1);
    test::Scene recoloured = before;
    recoloured.shapes[0].color[2] = 150;
    const diff::Picture plain = test::paint(before, test::grid_pattern(2));
    diff::Picture salted = plain;
    for (std::size_t i = 0; i < salted.rgb.size() - 3; i += 3001) {
        salted.rgb[i] = 255;
    }
    const diff::Picture others[] = {test::paint(recoloured, test::grid_pattern(2)), salted,
                                    test::paint(before, test::grid_pattern(8), 2.0, 1.0),
                                    test::each_channel(plain, [](double v) { return v + 1; })};
    sim::write_file(folder / "a.png", diff::encode_png(plain));
    for (const diff::Picture& other : others) {
        sim::write_file(folder / "b.png", diff::encode_png(other));
        settings.pair.limits = {};
        ASSERT_TRUE(compared("a.png", "b.png").is_failed);
        settings.pair.limits.of.fill({1e9, "calibration"});
        diff::Comparison comparison;
        comparison.cases.push_back(compared("a.png", "b.png"));
        sim::write_file(folder / "limits.json", diff::proposed_limits(comparison, {}));
        settings.pair.limits = diff::read_limits(folder / "limits.json");
        const diff::Case again = compared("a.png", "b.png");
        EXPECT_EQ(again.tier, Tier::noise) << again.message;
        EXPECT_EQ(again.frames[0].gates[0].source, (folder / "limits.json").string());
    }
    sim::write_file(folder / "limits.json", std::string(R"({"windw": 3})"));
    EXPECT_THROW(diff::read_limits(folder / "limits.json"), sim::Error);
}

TEST_F(sequence, reports_hold_the_numbers_and_list_every_file) {
    write_frames("a", 0, 3);
    write_frames("b", 0, 2);
    diff::Comparison comparison;
    comparison.cases.push_back(compared());
    comparison.cases[0].reference = "<a> & \"b\"";
    diff::write_review({diff::find_source(folder / "a"), diff::find_source(folder / "b")}, settings, {.folder = folder},
                       nullptr, comparison.cases[0]);
    diff::sum_up(comparison);
    diff::write_report(folder, comparison, diff::PagePictures::linked);
    const auto json = nlohmann::json::parse(sim::read_text_file(folder / "result.json"));
    EXPECT_EQ(json["version"], 1);
    EXPECT_EQ(json["exit_code"], 4);
    EXPECT_EQ(json["counts"]["not_compared"], 1);
    EXPECT_EQ(json["cases"][0]["frames"][2]["status"], "candidate_missing");
    const std::string junit = sim::read_text_file(folder / "junit.xml");
    EXPECT_NE(junit.find("failures=\"1\" errors=\"0\" skipped=\"0\" time=\"0.000\""), std::string::npos);
    EXPECT_NE(junit.find("&lt;a&gt; &amp; &quot;b&quot;"), std::string::npos);
    EXPECT_NE(junit.find("3 frames: 2 identical"), std::string::npos);
    EXPECT_NE(sim::read_text_file(folder / "summary.md").find("| case | **candidate missing** |"), std::string::npos);
    const auto manifest = nlohmann::json::parse(sim::read_text_file(folder / "manifest.json"));
    for (const auto& file : manifest["files"]) {
        EXPECT_EQ(file["sha256"], sim::sha256_of_file(folder / file["name"].get<std::string>()));
    }
    EXPECT_EQ(manifest["files"].size(), 5u);

    // Pictures are kept once: in the page, or in files beside it.
    ASSERT_TRUE(fs::exists(folder / comparison.cases[0].frames[2].reference_picture));
    EXPECT_EQ(sim::read_text_file(folder / "index.html").find("class=\"picture\""), std::string::npos);
    diff::write_report(folder, comparison, diff::PagePictures::inside);
    EXPECT_FALSE(fs::exists(folder / "pictures"));
    EXPECT_NE(sim::read_text_file(folder / "index.html").find("class=\"picture\""), std::string::npos);
    EXPECT_EQ(nlohmann::json::parse(sim::read_text_file(folder / "result.json"))["cases"][0]["frames"][2]["reference_picture"], "");

    diff::remove_report(folder);
    EXPECT_FALSE(fs::exists(folder / "result.json"));
    EXPECT_TRUE(fs::exists(folder / "a"));
}

TEST_F(sequence, the_film_of_a_comparison_shows_all_frames_in_order) {
    write_frames("a", 0, 9);
    write_frames("b", 0, 7);
    write("b/f14.png", scene(8));
    write("b/f15.png", scene(5), test::rotated_pattern);
    settings.threads = 3;
    std::vector<diff::Picture> shown;
    diff::FilmTools tools;
    tools.create = [&shown](const fs::path&, int, int, double) { return std::make_unique<KeptFilm>(shown); };
    for (const bool is_same : {true, false}) {
        const diff::Source a = diff::find_source(folder / "a"), b = diff::find_source(folder / (is_same ? "a" : "b"));
        const diff::Sides sides{a, b};
        diff::SideBySide film(sides, tools, folder, "case");
        diff::Case c = diff::compare_sources("case", sides, settings, nullptr,
                                             [&film](std::size_t i, const diff::PairMemory& memory, const diff::Frame& frame) {
                                                 film.add(i, memory, frame);
                                             });
        film.finish(c);
        EXPECT_EQ(c.film, is_same ? "" : "case.mp4");
        EXPECT_EQ(shown.size(), is_same ? 0u : 9u);
    }
    for (std::size_t i = 0; i < shown.size(); ++i) {
        const diff::Picture& picture = shown[i];
        ASSERT_EQ(picture.width, 3 * 96);
        // The red disc of each side, and nothing where a side has no frame.
        const auto color = [&](int panel, int t) {
            return &picture.rgb[static_cast<std::size_t>((55 * picture.width + 96 * panel + 15 + 7 * t) * 3)];
        };
        const int t = static_cast<int>(i);
        EXPECT_EQ(color(0, t)[0], 200) << i;
        EXPECT_EQ(color(1, i == 4 ? 8 : t)[0], i < 7 ? 200 : 0) << i;
        EXPECT_EQ(color(2, t)[0] == 0, i >= 7) << i;
    }
}
