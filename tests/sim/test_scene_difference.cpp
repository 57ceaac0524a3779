#include "sim/scene/difference.h"

#include <gtest/gtest.h>

#include <vector>

using namespace sim;

namespace {

constexpr const char* before_text = R"(title = "a"
[simulation]
tolerance = 1e-4
warm_start = true
gravity = [0, 0, -9.81]
[[body]]
name = "cube"
density = 1000
)";

std::string difference(const std::string& now, const std::vector<std::string>& now_overrides = {},
                       const std::vector<std::string>& before_overrides = {}) {
    return scene_difference({now, now_overrides}, {before_text, before_overrides});
}

} // namespace

TEST(scene_difference, comments_spaces_order_and_spelling_do_not_count) {
    EXPECT_EQ(difference(before_text), "");
    EXPECT_EQ(difference(R"(# the same
title = 'a'
simulation = { warm_start = true, tolerance = 0.0001, gravity = [0.0, 0, -9.81] }
[[body]]
density = 1e3
name = "cube"
)"),
              "");
}

TEST(scene_difference, the_first_key_that_differs_is_named_with_both_values) {
    EXPECT_EQ(difference(before_text, {"output.fps=\"60/2\""}, {"output.fps=30"}), "");
    const std::vector<std::string> tolerance{"simulation.tolerance=1e-6"};
    EXPECT_EQ(difference(before_text, tolerance), "simulation.tolerance is 1e-06, was 0.0001");
    EXPECT_EQ(difference(before_text, {}, tolerance), "simulation.tolerance is 0.0001, was 1e-06");
    EXPECT_EQ(difference(before_text, tolerance, tolerance), "");
    EXPECT_EQ(difference(before_text, {"simulation.gravity=[0,0,-1]"}),
              "simulation.gravity[2] is -1, was -9.81");
    EXPECT_EQ(difference(before_text, {"body.cube.density=1"}), "body.cube.density is 1, was 1000");
    EXPECT_EQ(difference(before_text, {"simulation.warm_start=false"}),
              "simulation.warm_start is false, was true");
    EXPECT_EQ(difference(before_text, {"title=\"b\""}), "title is \"b\", was \"a\"");
}

TEST(scene_difference, keys_that_came_or_went_are_named) {
    EXPECT_EQ(difference(before_text, {"output.fps=30"}), "output.fps is 30, was not set");
    EXPECT_EQ(difference(before_text, {}, {"output.fps=30"}), "output.fps is not set, was 30");
    EXPECT_EQ(difference(before_text, {}, {"simulation.iteration_limit=5"}),
              "simulation.iteration_limit is not set, was 5");
    EXPECT_EQ(difference(before_text + std::string("[[body]]\nname = \"b\"\n")),
              "body.b is new");
    EXPECT_EQ(difference("title = \"a\"\nsimulation = { tolerance = 1e-4, warm_start = true, gravity = [0, 0, -9.81] }\nbody = []\n"),
              "body.cube is gone");
    EXPECT_EQ(difference(before_text, {"overlay.show=[\"title\", \"plots\"]"}, {"overlay.show=[\"title\", \"time\", \"plots\"]"}),
              "overlay.show is [\"title\", \"plots\"], was [\"title\", \"time\", \"plots\"]");
}
