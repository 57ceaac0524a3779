#include "sim/world/contact_view.h"

#include "sim/scene/file.h"
#include "sim/world/world.h"

#include <gtest/gtest.h>

using namespace sim;

namespace {

/// A block of 2 kg on the floor with friction 0.5, pulled sideways by gravity times `slope`.
SceneDef block_on_floor(double slope) {
    return parse_scene("[simulation]\ngravity = [" + std::to_string(9.81 * slope) + R"(, 0, -9.81]
tolerance = 1e-9
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[body]]
name = "block"
shape = { kind = "box", size = [1, 1, 0.2] }
mass = 2
position = [0, 0, 0.1]
friction = 0.5
)",
                       "block.toml");
}

Snapshot after(const SceneDef& scene, int steps, ContactDetail detail) {
    World world(scene);
    for (int i = 0; i < steps; ++i) {
        world.step();
    }
    return world.take_snapshot(detail);
}

} // namespace

TEST(contact_view, impulses_of_a_resting_block_carry_its_weight_and_stick) {
    const SceneDef scene = block_on_floor(0.2);
    const Snapshot snapshot = after(scene, 20, ContactDetail::all);
    ASSERT_EQ(snapshot.contacts.size(), 4u);
    EXPECT_EQ(snapshot.contact_count, 4);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const ContactSnapshot& contact : snapshot.contacts) {
        EXPECT_TRUE(contact.is_sticking);
        EXPECT_EQ(contact.bodies[0], 0);
        EXPECT_EQ(contact.bodies[1], 1);
        EXPECT_NEAR(contact.normal.z(), -1.0f, 1e-6f); // from the block to the floor
        EXPECT_NEAR(contact.point.z(), 0.0f, 1e-6f);
        sum += contact.impulse;
    }
    // On the floor: the weight, and the pull sideways, of one step of 1 ms.
    EXPECT_NEAR(sum.z(), -2.0f * 9.81f * 1e-3f, 1e-6f);
    EXPECT_NEAR(sum.x(), 2.0f * 0.2f * 9.81f * 1e-3f, 1e-6f);
}

TEST(contact_view, a_block_pulled_harder_than_friction_slides) {
    const Snapshot snapshot = after(block_on_floor(0.8), 20, ContactDetail::all);
    ASSERT_FALSE(snapshot.contacts.empty());
    for (const ContactSnapshot& contact : snapshot.contacts) {
        EXPECT_FALSE(contact.is_sticking);
        const float tangential = std::hypot(contact.impulse.x(), contact.impulse.y());
        EXPECT_NEAR(tangential, 0.5f * std::abs(contact.impulse.z()), 1e-6f);
    }
}

TEST(contact_view, what_is_not_asked_for_is_not_there_and_changes_no_hash) {
    const SceneDef scene = block_on_floor(0.2);
    const Snapshot none = after(scene, 5, ContactDetail::none);
    const Snapshot count = after(scene, 5, ContactDetail::count);
    const Snapshot all = after(scene, 5, ContactDetail::all);
    EXPECT_EQ(none.contact_count, 0);
    EXPECT_TRUE(none.contacts.empty());
    EXPECT_EQ(count.contact_count, 4);
    EXPECT_TRUE(count.contacts.empty());
    EXPECT_EQ(state_hash(none), state_hash(all));
}

// A ball of 2 kg arrives at v = sqrt(2 g height), and leaves at e v: the impulse is (1 + e) m v, whether the step is stopped
// at the impact or the contact is held ahead of it, wherever in a step it arrives; but for what gravity does in one step.
TEST(contact_view, impulses_of_an_impact_are_what_the_body_gains) {
    for (const std::string impacts : {"stop", "ahead"}) {
        for (const double height : {0.2, 0.2005, 0.201, 0.2015}) { // a step is 2 mm
            const SceneDef scene = parse_scene("[simulation]\nimpacts = \"" + impacts + R"("
tolerance = 1e-9
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[body]]
name = "ball"
shape = { kind = "sphere", radius = 0.1 }
mass = 2
restitution = 0.5
position = [0, 0, )" + std::to_string(0.1 + height) + "]\n",
                                               "ball.toml");
            World world(scene);
            world.record_impacts();
            Eigen::Vector3f sum = Eigen::Vector3f::Zero();
            for (int i = 0; i < 250; ++i) { // it arrives after 202 ms
                world.step();
                for (const ContactSnapshot& impact : world.take_impacts()) {
                    EXPECT_EQ(impact.bodies[1], 1);
                    EXPECT_NEAR(impact.point.z(), 0.0f, 1e-3f);
                    sum += impact.impulse; // on the floor
                }
            }
            const double speed = std::sqrt(2.0 * 9.81 * height);
            EXPECT_NEAR(sum.z(), -1.5 * 2.0 * speed, 0.01 * 3.0 * speed) << impacts << " " << height;
            EXPECT_NEAR(sum.x(), 0.0f, 1e-6f);
            EXPECT_TRUE(world.take_impacts().empty());
        }
    }
}
