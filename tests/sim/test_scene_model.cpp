#include "sim/scene/model.h"

#include "sim/scene/file.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace {

using namespace sim;

std::string reason_of(const std::string& text, const std::string& part) {
    const std::vector<ModelPart> parts = model_parts(parse_scene(text, "s.toml"));
    const auto found = std::ranges::find(parts, part, &ModelPart::name);
    return found == parts.end() ? "no such part" : found->is_on ? found->reason : "off";
}

const std::string ball_above = "[[body]]\nname = 'ball'\nposition = [0, 0, 5]\nshape = { kind = 'sphere', radius = 1 }\n";
const std::string floor_text = "[[body]]\nname = 'floor'\nshape = { kind = 'plane' }\nstatic = true\n";

TEST(scene_model, one_body_alone_touches_nothing) {
    for (const char* part : {"contacts", "friction", "warm start", "contacts ahead of impacts", "gyroscopic term"}) {
        EXPECT_EQ(reason_of(ball_above + "friction = 0.5\n", part), "off") << part;
    }
}

TEST(scene_model, each_part_has_its_reason) {
    const std::string scene = floor_text + ball_above;
    EXPECT_EQ(reason_of(scene, "contacts"), "1 moving bodies, 2 in all");
    EXPECT_EQ(reason_of(scene, "restitution"), "off");
    EXPECT_EQ(reason_of(scene + "restitution = 0\n", "restitution"), "off");
    EXPECT_EQ(reason_of(scene + "restitution = 0.9\n", "stop at impacts"),
              "elastic bodies (restitution 0.9 or more): 'ball'");
    EXPECT_EQ(reason_of(scene + "restitution = 0.8\n", "stop at impacts"), "off");
    EXPECT_EQ(reason_of(scene + "restitution = 0.3\n", "restitution"), "0.3");
    EXPECT_EQ(reason_of(scene + "mu_s = 0.3\nmu_d = 0\n", "friction"), "static 0.3, dynamic 0");
    const std::string can = "[[body]]\nname = 'can'\nposition = [9, 0, 5]\nshape = { kind = 'compound', parts = [{ kind = "
                            "'cylinder', radius = 0.1, length = 0.3 }, { kind = 'sphere', radius = 0.1 }] }\n";
    EXPECT_EQ(reason_of(scene + can, "support points (libccd)"), "'can'");
    EXPECT_EQ(reason_of(scene + can, "compounds"), "'can'");
    EXPECT_EQ(reason_of(scene + can, "gyroscopic term"), "'can'");
}

} // namespace
