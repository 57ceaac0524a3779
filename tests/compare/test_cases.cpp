// What of folders is compared, names, what earlier runs found, and what the bodies of a picture say together.
#include "render/compare/bodies.h"
#include "render/compare/cases.h"
#include "render/compare/history.h"
#include "render/compare/report.h"
#include "render/compare/sequence.h"
#include "render/compare/utf8.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "tests/compare/painter.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace {

namespace fs = std::filesystem;

class cases : public testing::Test {
protected:
    fs::path folder;

    void SetUp() override {
        folder = test::out_folder("compare") / testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
    }
    void add(const std::string& name) const {
        fs::create_directories((folder / name).parent_path());
        sim::write_file(folder / name, std::string("x"));
    }
    std::string found() const {
        std::string names;
        for (const diff::CasePaths& paths : diff::find_cases(folder / "a", folder / "b")) {
            names += (paths.name.empty() ? "." : paths.name) + " ";
        }
        return names;
    }
};

/// Eight discs on the floor; their numbers, as bodies' images have them.
test::Scene discs() {
    test::Scene scene;
    for (int i = 0; i < 8; ++i) {
        scene.shapes.push_back({test::Shape::Kind::disc, 30.0 + 36 * i, 110, 12, 0, {150, 60, 50}});
    }
    return scene;
}

diff::BodyImage bodies_of(const test::Scene& scene) {
    test::Scene numbers = scene;
    numbers.shade = 0;
    numbers.floor = numbers.sky = {0, 0, 0};
    diff::BodyImage image;
    image.width = scene.width;
    image.height = scene.height;
    for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
        numbers.shapes[i].color = {static_cast<double>(i + 1), 0, 0};
        image.names.push_back("disc " + std::to_string(i));
        image.positions.push_back({static_cast<double>(i), 0, 0});
        image.orientations.push_back({1, 0, 0, 0});
    }
    const diff::Picture picture = test::paint(numbers, test::grid_pattern(1));
    for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
        image.ids.push_back(picture.rgb[i]);
    }
    return image;
}

diff::Frame named(const test::Scene& a, const test::Scene& b, const diff::BodyImage& bodies_b) {
    diff::DifferenceMap map;
    diff::measure(test::paint(a, test::grid_pattern(2)), test::paint(b, test::grid_pattern(2)), map);
    diff::Frame frame;
    diff::name_bodies(bodies_of(a), bodies_b, map, frame);
    return frame;
}

} // namespace

TEST_F(cases, one_sequence_or_run_is_one_case) {
    add("a/f_0010.png");
    add("b/f_0009.png");
    add("b/f_0010.png");
    EXPECT_EQ(found(), ". ");
    add("a/frames/x.png");
    EXPECT_EQ(found(), ". ");
}

TEST_F(cases, pictures_of_no_sequence_are_a_case_each) {
    add("a/title.png");
    add("a/end.png");
    add("b/title.png");
    EXPECT_EQ(found(), "end.png title.png ");
}

TEST_F(cases, folders_of_runs_are_a_case_each_and_reports_none) {
    add("a/funnel/frames/frame_000000.png");
    add("b/coin/frames/frame_000000.png");
    add("b/old/marbles/frame_1.png");
    add("b/report/pictures/x.png");
    add("b/report/result.json");
    add("b/report/manifest.json");
    add("b/notes/readme.txt");
    EXPECT_EQ(found(), "coin funnel old/marbles ");
}

TEST(frame_numbers, are_those_at_the_end_of_names_that_differ_in_nothing_else) {
    EXPECT_EQ(diff::frame_numbers({"f_010.png", "f_2.png"}), (std::vector<std::int64_t>{10, 2}));
    EXPECT_TRUE(diff::frame_numbers({"f_010.png", "g_2.png"}).empty());
    EXPECT_TRUE(diff::frame_numbers({"f_01.png", "f_1.png"}).empty());
    EXPECT_TRUE(diff::frame_numbers({"f.png"}).empty());
    EXPECT_TRUE(diff::frame_numbers({"f99999999999999999999.png"}).empty());
    std::vector<std::string> names{"f10.png", "f2.png", "f9.png"};
    diff::sort_frames(names);
    EXPECT_EQ(names, (std::vector<std::string>{"f2.png", "f9.png", "f10.png"}));
}

TEST(utf8, bytes_that_are_no_character_are_written_in_hexadecimal) {
    EXPECT_EQ(diff::as_utf8("caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80"), "caf\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80");
    EXPECT_EQ(diff::as_utf8("caf\xe9"), "caf~E9");
    EXPECT_EQ(diff::as_utf8("\xc0\xaf\xed\xa0\x80\xc3"), "~C0~AF~ED~A0~80~C3");
}

TEST_F(cases, junit_counts_what_could_not_be_compared_as_errors_and_holds_any_name) {
    diff::Comparison comparison;
    comparison.cases.resize(3);
    comparison.cases[0].name = "caf\xe9";
    comparison.cases[0].seconds = 1.25;
    comparison.cases[1].is_failed = true;
    comparison.cases[1].status = diff::Status::unreadable;
    comparison.cases[2].is_failed = true;
    comparison.cases[2].tier = diff::Tier::changed;
    diff::sum_up(comparison);
    const std::string junit = diff::to_junit(comparison);
    EXPECT_NE(junit.find("tests=\"3\" failures=\"1\" errors=\"1\" skipped=\"0\" time=\"1.250\""), std::string::npos) << junit;
    EXPECT_NE(junit.find("name=\"caf~E9\" time=\"1.250\""), std::string::npos) << junit;
    EXPECT_NE(junit.find("<error type=\"unreadable\""), std::string::npos) << junit;
    EXPECT_NE(junit.find("</error>"), std::string::npos) << junit;
    EXPECT_NE(diff::to_json(comparison).find("\"name\": \"caf~E9\""), std::string::npos);
}

// Broken and mended is two turns of the verdict, to and fro is more.
TEST_F(cases, history_grows_by_a_line_a_case_and_tells_the_flaky) {
    fs::create_directories(folder);
    const fs::path file = folder / "history.jsonl";
    const auto run = [&](bool steady, bool shaky) {
        diff::Comparison comparison;
        comparison.program = "tumble";
        comparison.cases.resize(2);
        comparison.cases[0].name = "steady";
        comparison.cases[0].is_failed = steady;
        comparison.cases[1].name = "sh\xe4ky";
        comparison.cases[1].is_failed = shaky;
        comparison.cases[1].frames.resize(1);
        comparison.cases[1].frames[0].curve = shaky ? 2.5 : 0.5;
        diff::append_history(file, comparison, "2026-01-31T12:00:00Z");
        diff::read_history(file, comparison);
        return comparison;
    };
    for (const bool is_failed : {false, true, false}) {
        EXPECT_FALSE(diff::is_flaky(run(is_failed, is_failed).cases[1]));
    }
    const diff::Comparison last = run(false, true);
    EXPECT_FALSE(diff::is_flaky(last.cases[0]));
    EXPECT_TRUE(diff::is_flaky(last.cases[1]));
    ASSERT_EQ(last.cases[1].history.size(), 4u);
    EXPECT_EQ(last.cases[1].history[3].curve, 2.5);
    EXPECT_EQ(last.cases[1].history[2].curve, 0.5);
    EXPECT_NE(diff::to_text(last).find(": identical (flaky)"), std::string::npos) << diff::to_text(last);

    for (int i = 0; i < 30; ++i) {
        run(false, false);
    }
    EXPECT_EQ(run(false, false).cases[0].history.size(), 20u);
    sim::write_file(file, std::string("{}\n"));
    EXPECT_THROW(run(false, false), sim::Error);
}

TEST(bodies, a_turned_one_is_said_with_its_angle) {
    const test::Scene before = discs();
    test::Scene after = before;
    after.shapes[3].color = {50, 60, 150};
    diff::BodyImage turned = bodies_of(after);
    const double half = 5.0 * M_PI / 180.0;
    turned.orientations[3] = {-std::cos(half), 0.0, -std::sin(half), 0.0}; // a quaternion and its negative are one turn
    const diff::Frame frame = named(before, after, turned);
    ASSERT_EQ(frame.bodies.size(), 1u);
    EXPECT_EQ(frame.bodies[0].name, "disc 3");
    EXPECT_EQ(frame.bodies[0].kind, diff::BodyChange::Kind::turned);
    EXPECT_NEAR(frame.bodies[0].angle.value_or(0), 10.0, 1e-9);
    EXPECT_TRUE(frame.scene_change.empty()) << frame.scene_change;
}

TEST(bodies, a_moved_camera_and_another_light_are_said_once) {
    const test::Scene before = discs();
    test::Scene after = before;
    for (test::Shape& shape : after.shapes) {
        shape.x += 3;
        for (double& c : shape.color) {
            c *= 1.2;
        }
    }
    const auto shown = [](const test::Scene& scene) {
        diff::BodyImage image = bodies_of(scene);
        image.view = diff::ShownView{{0, -1, 0}, {0, 0, 0}, 40};
        image.light = diff::ShownLight{{0, 0, 1}, {3, 3, 3}, {1, 1, 1}, {0.1, 0.1, 0.1}};
        return image;
    };
    const auto told = [&](const diff::BodyImage& image) {
        diff::DifferenceMap map;
        diff::measure(test::paint(before, test::grid_pattern(2)), test::paint(after, test::grid_pattern(2)), map);
        diff::Frame frame;
        diff::name_bodies(shown(before), image, map, frame);
        EXPECT_EQ(frame.bodies.empty(), !frame.scene_change.empty()) << frame.scene_change;
        return frame.scene_change;
    };
    diff::BodyImage image = shown(after);
    EXPECT_EQ(told(image), "");
    image.view->eye = {0.01, -1, 0};
    EXPECT_EQ(told(image), "the camera moved by 10 mm, turned by 0.573 degrees");
    image.view->fov_degrees = 41;
    EXPECT_EQ(told(image), "the camera moved by 10 mm, turned by 0.573 degrees, opens by 41 degrees, not 40");
    image = shown(after);
    image.light->sun = {3.3, 3.3, 3.3};
    EXPECT_EQ(told(image), "the sun is 10 % brighter");
    image.light->sun = {3.1, 2.9, 3};
    image.light->to_sun = {std::sin(0.1), 0, std::cos(0.1)};
    image.light->zenith = {0.5, 0.5, 0.5};
    EXPECT_EQ(told(image), "the sun turned by 5.73 degrees; the sun has another colour; the sky is 45.5 % darker");
}

// Half of the disc is hidden in the candidate: the middle of what is left has moved, the disc has not.
TEST(bodies, hidden_parts_do_not_move_a_body) {
    test::Scene before = discs();
    before.shapes.resize(1);
    test::Scene after = before;
    after.shapes.push_back({test::Shape::Kind::box, 42, 110, 12, 0, {40, 60, 200}});
    diff::BodyImage bodies = bodies_of(after);
    bodies.positions[0][0] += 1.0; // towards the camera
    const diff::Frame frame = named(before, after, bodies);
    ASSERT_EQ(frame.bodies.size(), 2u);
    for (const diff::BodyChange& change : frame.bodies) {
        if (change.name == "disc 0") {
            EXPECT_EQ(change.kind, diff::BodyChange::Kind::moved);
            EXPECT_EQ(change.displacement.x, 0.0);
            EXPECT_EQ(change.distance, 1.0);
        }
    }
}
