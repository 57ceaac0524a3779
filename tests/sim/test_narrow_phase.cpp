#include "sim/collide/narrow_phase.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace sim;

namespace {

/// Rounding of some tens of operations on lengths of about 1 m [m].
constexpr double distance_rounding = 1e-14;

Pose at(double x, double y, double z) {
    return {Vec3(x, y, z), Quat::Identity()};
}

std::vector<FoundContact> contacts_of(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b,
                                 double margin = 0.5) {
    std::vector<FoundContact> contacts(3); // to be overwritten
    find_contacts({a, pose_a}, {b, pose_b}, margin, contacts);
    return contacts;
}

/// A ball of radius 0.25 m against the cube of side 1 m at the origin, in both orders.
void expect_ball_on_cube(const Vec3& centre, double gap, const Vec3& n, FeatureKind kind) {
    const Sphere ball{0.25};
    const Pose pose{centre, Numbers(9).orientation()}; // the ball's turning does not matter
    const auto contacts = contacts_of(ball, pose, Box{}, Pose{});
    ASSERT_EQ(contacts.size(), 1u);
    const ContactGeometry& g = contacts[0].at;
    EXPECT_EQ(contacts[0].feature.kind, kind);
    EXPECT_NEAR(g.gap, gap, distance_rounding);
    EXPECT_LE((g.n - n).norm(), distance_rounding);
    EXPECT_LE((g.a - (centre - 0.25 * n)).norm(), distance_rounding);
    EXPECT_NEAR(separation({ball, pose}, {Box{}, Pose{}}), gap, distance_rounding);

    const auto exchanged = contacts_of(Box{}, Pose{}, ball, pose);
    ASSERT_EQ(exchanged.size(), 1u);
    EXPECT_NEAR(exchanged[0].at.gap, gap, distance_rounding);
    EXPECT_LE((exchanged[0].at.n + n).norm(), distance_rounding);
    EXPECT_LE((exchanged[0].at.b() - g.a).norm(), distance_rounding);
}

/// Distance of a point from a box's surface, negative inside.
double distance_to_box(const Vec3& x, const Box& box, const Pose& pose) {
    const Vec3 q = (pose.orientation.conjugate() * (x - pose.position)).cwiseAbs() - box.half_extents;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
}

} // namespace

TEST(narrow_phase, ball_over_a_face_of_a_box) {
    expect_ball_on_cube(Vec3(0.1, 0.2, 0.8), 0.05, Vec3(0, 0, 1), FeatureKind::face_b);
    expect_ball_on_cube(Vec3(-0.7, 0.2, 0.1), -0.05, Vec3(-1, 0, 0), FeatureKind::face_b);
}

TEST(narrow_phase, ball_beside_an_edge_of_a_box) {
    expect_ball_on_cube(Vec3(0.1, 0.8, 0.9), 0.25, Vec3(0, 0.6, 0.8), FeatureKind::line_b); // 3-4-5
    expect_ball_on_cube(Vec3(-0.62, 0.1, 0.66), -0.05, Vec3(-0.6, 0, 0.8), FeatureKind::line_b);
}

TEST(narrow_phase, ball_at_a_corner_of_a_box) {
    expect_ball_on_cube(Vec3(0.6, -0.7, 0.7), 0.05, Vec3(1, -2, 2) / 3.0, FeatureKind::cores);
}

TEST(narrow_phase, ball_with_its_centre_inside_a_box_leaves_by_the_nearest_face) {
    expect_ball_on_cube(Vec3(0.1, -0.3, 0.2), -0.45, Vec3(0, -1, 0), FeatureKind::face_b);
    expect_ball_on_cube(Vec3(0.5, 0.0, 0.0), -0.25, Vec3(1, 0, 0), FeatureKind::face_b); // on the face
}

TEST(narrow_phase, separation_of_ball_and_box_is_the_distance_to_its_surface) {
    Numbers numbers(1);
    const Box box{Vec3(0.5, 0.3, 0.2)};
    for (int i = 0; i < 1000; ++i) {
        const Pose pose = numbers.pose(0.3);
        const Pose ball = numbers.pose(1.0);
        EXPECT_NEAR(separation({box, pose}, {Sphere{0.1}, ball}), distance_to_box(ball.position, box, pose) - 0.1,
                    distance_rounding);
    }
}

TEST(narrow_phase, ball_against_ball_along_their_centres) {
    const auto contacts = contacts_of(Sphere{0.5}, at(3, 4, 0), Sphere{4.25}, Pose{});
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].at.gap, 0.25, distance_rounding);
    EXPECT_LE((contacts[0].at.n - Vec3(0.6, 0.8, 0)).norm(), distance_rounding);
    EXPECT_TRUE(contacts_of(Sphere{0.5}, at(3, 4, 0), Sphere{4.25}, Pose{}, 0.2).empty());
    EXPECT_EQ(contacts_of(Sphere{0.5}, Pose{}, Sphere{0.25}, Pose{})[0].at.gap, -0.75); // equal centres
}

TEST(narrow_phase, ball_and_box_against_a_plane_in_both_orders) {
    const auto ball = contacts_of(Sphere{0.5}, at(1, 2, 0.4), Plane{}, Pose{});
    ASSERT_EQ(ball.size(), 1u);
    EXPECT_NEAR(ball[0].at.gap, -0.1, distance_rounding);
    EXPECT_EQ(ball[0].at.n, Vec3(0, 0, 1));

    const auto cube = contacts_of(Box{}, at(1, 2, 0.6), Plane{}, Pose{});
    ASSERT_EQ(cube.size(), 4u);
    const auto exchanged = contacts_of(Plane{}, Pose{}, Box{}, at(1, 2, 0.6));
    ASSERT_EQ(exchanged.size(), 4u);
    for (std::size_t i = 0; i < 4; ++i) {
        EXPECT_NEAR(cube[i].at.gap, 0.1, distance_rounding);
        EXPECT_EQ(cube[i].at.n, Vec3(0, 0, 1));
        EXPECT_EQ(exchanged[i].at.n, Vec3(0, 0, -1));
        EXPECT_EQ(exchanged[i].at.b(), cube[i].at.a);
        EXPECT_EQ(exchanged[i].feature.id, cube[i].feature.id);
        EXPECT_NEAR(cube[i].at.b().z(), 0.0, distance_rounding);
    }
}

TEST(narrow_phase, lowest_corner_of_a_tilted_box_decides_its_separation_from_a_plane) {
    Numbers numbers(2);
    const Box box{Vec3(0.5, 0.3, 0.2)};
    for (int i = 0; i < 100; ++i) {
        const Pose pose = numbers.pose(1.0);
        const double reach = (pose.orientation.conjugate() * Vec3::UnitZ()).cwiseAbs().dot(box.half_extents);
        EXPECT_NEAR(separation({box, pose}, {Plane{}, Pose{}}), pose.position.z() - reach, distance_rounding);
    }
}

TEST(narrow_phase, tilted_plane_has_its_own_normal) {
    const Quat tilt = turned(Quat::Identity(), Vec3(0.3, 0.1, 0.0));
    const Vec3 n = tilt * Vec3::UnitZ();
    const auto contacts =
        contacts_of(Sphere{0.5}, {0.6 * n, Quat::Identity()}, Plane{}, {Vec3::Zero(), tilt});
    ASSERT_EQ(contacts.size(), 1u);
    EXPECT_NEAR(contacts[0].at.gap, 0.1, distance_rounding);
    EXPECT_LE((contacts[0].at.n - n).norm(), distance_rounding);
}

TEST(narrow_phase, every_part_of_a_compound_touches_by_itself) {
    // A dumb-bell of two balls along x, and a box between them that does not reach the floor.
    const Compound dumbbell{
        {{Sphere{0.5}, at(-1, 0, 0)}, {Box{Vec3(1, 0.1, 0.1)}, Pose{}}, {Sphere{0.5}, at(1, 0, 0)}}};
    const auto contacts = contacts_of(dumbbell, at(0, 0, 0.51), Plane{}, Pose{}, 0.1);
    ASSERT_EQ(contacts.size(), 2u);
    EXPECT_NEAR(contacts[0].at.a.x(), -1.0, distance_rounding);
    EXPECT_NEAR(contacts[1].at.a.x(), 1.0, distance_rounding);
    EXPECT_NEAR(contacts[0].at.gap, 0.01, distance_rounding);
    EXPECT_LT(contacts[0].feature.id, contacts[1].feature.id);

    // Two of them, crossed: box upon box, the balls beside.
    const Pose above{Vec3(0, 0, 0.19), turned(Quat::Identity(), Vec3(0, 0, 2.0 * std::atan(1.0)))};
    const auto crossed = contacts_of(dumbbell, above, dumbbell, Pose{}, 0.05);
    ASSERT_EQ(crossed.size(), 4u);
    for (const FoundContact& contact : crossed) {
        EXPECT_NEAR(contact.at.gap, -0.01, distance_rounding);
        EXPECT_LE((contact.at.n - Vec3(0, 0, 1)).norm(), distance_rounding);
    }
    EXPECT_NEAR(separation({dumbbell, above}, {dumbbell, Pose{}}), -0.01, distance_rounding);
}

TEST(narrow_phase, a_compound_of_one_part_equals_the_shifted_part) {
    Numbers numbers(3);
    const Box box{Vec3(0.5, 0.3, 0.2)};
    for (int i = 0; i < 300; ++i) {
        const Pose part = numbers.pose(0.5);
        const Pose body = numbers.pose(0.5);
        const Pose other = numbers.pose(0.5);
        const auto expected = contacts_of(box, body * part, Box{}, other);
        const auto found = contacts_of(Compound{{{box, part}}}, body, Box{}, other);
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t k = 0; k < found.size(); ++k) {
            EXPECT_EQ(found[k].feature.id, expected[k].feature.id);
            EXPECT_NEAR(found[k].at.gap, expected[k].at.gap, 1e-12); // near-parallel edges magnify rounding
            EXPECT_LE((found[k].at.n - expected[k].at.n).norm(), 1e-12);
        }
    }
}

TEST(narrow_phase, separation_is_no_more_than_the_sampled_distance_of_boxes) {
    Numbers numbers(4);
    const Box box_a{Vec3(0.5, 0.3, 0.2)};
    const Box box_b{Vec3(0.2, 0.4, 0.6)};
    for (int i = 0; i < 200; ++i) {
        const Pose a = numbers.pose(1.0);
        const Pose b = numbers.pose(1.0);
        double sampled = 1e300;
        for (int k = 0; k < 500; ++k) {
            const Vec3 inside(numbers.between(-0.5, 0.5), numbers.between(-0.3, 0.3),
                              numbers.between(-0.2, 0.2));
            sampled = std::min(sampled, distance_to_box(a * inside, box_b, b));
        }
        const double s = separation({box_a, a}, {box_b, b});
        // Apart, the separation bounds the distance from below. Overlapping, moving out by the depth frees
        // every point of a, so none lies deeper inside b.
        EXPECT_LE(s, sampled + distance_rounding);
        EXPECT_NEAR(separation({box_b, b}, {box_a, a}), s, 1e-12);
        // Contacts within the margin exist exactly if the separation is.
        EXPECT_EQ(!contacts_of(box_a, a, box_b, b, 0.0).empty(), s <= 0.0);
    }
}

TEST(narrow_phase, contacts_are_ordered_by_id) {
    Numbers numbers(5);
    for (int i = 0; i < 300; ++i) {
        const auto contacts = contacts_of(Box{}, numbers.pose(0.6), Box{}, numbers.pose(0.6));
        EXPECT_TRUE(std::ranges::is_sorted(contacts, {}, [](const FoundContact& c) { return c.feature.id; }));
    }
}
