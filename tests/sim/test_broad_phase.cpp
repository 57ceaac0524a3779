#include "sim/collide/broad_phase.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace sim;

namespace {

struct Crowd {
    std::vector<BodyProps> props;
    std::vector<Bounds> boxes;

    void add(const Shape& shape, const Vec3& position, bool is_static = false) {
        props.push_back(make_props(shape, is_static ? 0.0 : 1000.0));
        boxes.push_back(bounds(shape, {position, Quat::Identity()}));
    }
    std::vector<BodyPair> pairs() const {
        std::vector<BodyPair> found{{7, 9}}; // to be overwritten
        BroadPhase(props).find_pairs(boxes, found);
        return found;
    }
    /// Every pair tested.
    std::vector<BodyPair> expected() const {
        std::vector<BodyPair> all;
        for (std::size_t i = 0; i < boxes.size(); ++i) {
            for (std::size_t j = i + 1; j < boxes.size(); ++j) {
                const bool are_there = boxes[i].lower.x() <= boxes[i].upper.x() && boxes[j].lower.x() <= boxes[j].upper.x();
                const bool overlap = are_there && (boxes[i].lower.array() <= boxes[j].upper.array()).all() &&
                                     (boxes[j].lower.array() <= boxes[i].upper.array()).all();
                if (overlap && !(props[i].is_static() && props[j].is_static())) {
                    all.push_back({static_cast<int>(i), static_cast<int>(j)});
                }
            }
        }
        return all;
    }
};

/// 300 boxes and balls, sizes from 1 cm to 1 m, one in ten static, on two crossing floors.
Crowd mixed_crowd(std::uint64_t seed, double spread, const Vec3& centre) {
    Numbers numbers(seed);
    Crowd crowd;
    crowd.add(Plane{}, Vec3::Zero(), true);
    for (int i = 0; i < 300; ++i) {
        const double size = 0.01 * std::pow(100.0, numbers.between(0.0, 1.0));
        const Vec3 position = centre + numbers.vector(spread);
        if (i % 3 == 0) {
            crowd.add(Sphere{size}, position, i % 10 == 0);
        } else {
            crowd.add(Box{Vec3(size, 0.5 * size, 0.2 * size)}, position, i % 10 == 0);
        }
    }
    crowd.add(Plane{}, Vec3::Zero(), true);
    return crowd;
}

} // namespace

TEST(broad_phase, pairs_are_those_of_testing_all_against_all) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
        for (const double spread : {0.5, 3.0, 30.0}) {
            const Crowd crowd = mixed_crowd(seed, spread, Vec3::Zero());
            EXPECT_EQ(crowd.pairs(), crowd.expected()) << seed << ' ' << spread;
        }
    }
}

TEST(broad_phase, equal_bodies_in_a_lattice_touch_their_neighbours) {
    Crowd crowd;
    for (int i = 0; i < 343; ++i) {
        crowd.add(Box{}, Vec3(i % 7 - 3, i / 7 % 7 - 3, i / 49 - 3)); // boxes share faces, edges, corners
    }
    const std::vector<BodyPair> pairs = crowd.pairs();
    EXPECT_EQ(pairs, crowd.expected());
    // Cells 7^3; along each axis 19 ordered neighbour pairs |dx| <= 1: (19^3 - 7^3) / 2.
    EXPECT_EQ(pairs.size(), (19u * 19u * 19u - 343u) / 2u);
}

TEST(broad_phase, a_plane_meets_every_dynamic_body_and_no_static_one) {
    Crowd crowd;
    crowd.add(Sphere{0.5}, Vec3(0, 0, 1e6));
    crowd.add(Plane{}, Vec3::Zero(), true);
    crowd.add(Box{}, Vec3(0, 0, -1e6));
    crowd.add(Box{}, Vec3::Zero(), true);
    EXPECT_EQ(crowd.pairs(), (std::vector<BodyPair>{{0, 1}, {1, 2}}));
}

TEST(broad_phase, far_coordinates_lose_no_pair) {
    // 1e7 m is beyond the range in which cell keys are unique; 1e15 m beyond all cells.
    for (const double distance : {1e5, 1e7, 1e15}) {
        Crowd crowd = mixed_crowd(7, 2.0, Vec3(distance, -distance, distance));
        const Crowd near = mixed_crowd(8, 2.0, Vec3::Zero());
        crowd.props.insert(crowd.props.end(), near.props.begin(), near.props.end());
        crowd.boxes.insert(crowd.boxes.end(), near.boxes.begin(), near.boxes.end());
        EXPECT_EQ(crowd.pairs(), crowd.expected()) << distance;
    }
}

TEST(broad_phase, bodies_on_both_sides_of_a_wrapped_key_are_no_pair) {
    Crowd crowd; // cells of 1 m: keys of x = 0 and x = 2^20 m are the same
    crowd.add(Box{}, Vec3(0.5, 0.5, 0.5));
    crowd.add(Box{}, Vec3(0.5 + 0x1p20, 0.5, 0.5));
    EXPECT_TRUE(crowd.pairs().empty());
}

TEST(broad_phase, empty_single_and_all_static_scenes_have_no_pairs) {
    Crowd crowd;
    EXPECT_TRUE(crowd.pairs().empty());
    crowd.add(Sphere{0.5}, Vec3::Zero());
    EXPECT_TRUE(crowd.pairs().empty());
    Crowd still;
    still.add(Plane{}, Vec3::Zero(), true);
    still.add(Box{}, Vec3::Zero(), true);
    EXPECT_TRUE(still.pairs().empty());
}

TEST(broad_phase, pairs_of_boxes_that_changed_are_found_among_the_others) {
    Numbers numbers(11);
    Crowd crowd = mixed_crowd(9, 2.0, Vec3::Zero());
    for (std::size_t i = 0; i < crowd.boxes.size(); i += 3) {
        crowd.boxes[i] = no_bounds; // they come later
    }
    BroadPhase broad_phase(crowd.props);
    std::vector<BodyPair> pairs;
    broad_phase.find_pairs(crowd.boxes, pairs);
    EXPECT_EQ(pairs, crowd.expected());
    for (int round = 0; round < 20; ++round) {
        std::vector<int> changed;
        for (int i = round; i < static_cast<int>(crowd.boxes.size()); i += 1 + round % 7 * 10) {
            const auto k = static_cast<std::size_t>(i);
            const double growth = std::pow(100.0, numbers.between(-1.0, 1.0)); // to other levels of size
            crowd.boxes[k] = bounds(Box{0.1 * growth * Vec3::Ones()}, {numbers.vector(2.0), Quat::Identity()});
            changed.push_back(i);
        }
        std::vector<BodyPair> expected;
        for (const BodyPair& pair : crowd.expected()) {
            if (std::ranges::count(changed, pair.a) + std::ranges::count(changed, pair.b) > 0) {
                expected.push_back(pair);
            }
        }
        broad_phase.find_pairs_of(changed, crowd.boxes, pairs);
        EXPECT_EQ(pairs, expected) << round;
    }
}

TEST(broad_phase, pairs_that_may_not_touch_are_none) {
    const Crowd crowd = mixed_crowd(3, 0.5, Vec3::Zero());
    std::vector<BodyPair> expected = crowd.expected();
    const auto is_odd = [](const BodyPair& pair) { return (pair.a + pair.b) % 2 == 1; };
    std::erase_if(expected, [&](const BodyPair& pair) { return !is_odd(pair); });
    std::vector<BodyPair> pairs;
    BroadPhase(crowd.props, is_odd).find_pairs(crowd.boxes, pairs);
    EXPECT_EQ(pairs, expected);
}

TEST(broad_phase, each_call_starts_anew) {
    Crowd crowd;
    crowd.add(Box{}, Vec3::Zero());
    crowd.add(Box{}, Vec3(0.9, 0, 0));
    BroadPhase broad_phase(crowd.props);
    std::vector<BodyPair> pairs;
    broad_phase.find_pairs(crowd.boxes, pairs);
    EXPECT_EQ(pairs.size(), 1u);
    crowd.boxes[1] = bounds(Box{}, {Vec3(1.1, 0, 0), Quat::Identity()});
    broad_phase.find_pairs(crowd.boxes, pairs);
    EXPECT_TRUE(pairs.empty());
}
