#include "sim/block/contact_graph.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

using namespace sim;

namespace {

ContactBlock between(int a, int b) {
    ContactBlock block;
    block.a = a;
    block.b = b;
    return block;
}

/// `dynamic` bodies, then one static body.
std::vector<BodyProps> bodies_on_a_floor(std::size_t dynamic) {
    std::vector<BodyProps> props(dynamic, make_props(Box{}, 1000.0));
    props.push_back(make_props(Plane{}, 0.0));
    return props;
}

} // namespace

TEST(contact_graph, levels_of_a_stack_count_from_the_floor) {
    // Body 2 stands on the floor (3), 0 on it, 1 on top; blocks in another order and direction.
    const std::vector blocks{between(0, 1), between(2, 3), between(0, 2)};
    EXPECT_EQ(contact_levels(blocks, bodies_on_a_floor(3)), (std::vector<int>{2, 3, 1, 0}));
}

TEST(contact_graph, a_body_takes_the_shortest_way_to_the_floor) {
    // 0 - 1 - 2 - floor, and 0 leans on the floor itself; two blocks of one pair count once.
    const std::vector blocks{between(0, 1), between(1, 2), between(2, 3), between(0, 3), between(0, 3)};
    EXPECT_EQ(contact_levels(blocks, bodies_on_a_floor(3)), (std::vector<int>{1, 2, 1, 0}));
}

TEST(contact_graph, bodies_without_a_way_to_the_floor_have_no_level) {
    const std::vector blocks{between(0, 1)};
    EXPECT_EQ(contact_levels(blocks, bodies_on_a_floor(3)), (std::vector<int>{-1, -1, -1, -1}));
}

TEST(contact_graph, empty_scene_has_no_levels) {
    EXPECT_TRUE(contact_levels({}, {}).empty());
}
