#include "sim/collide/narrow_phase.h"
#include "sim/solve/contact_solver.h"
#include "sim/solve/time_of_impact.h"
#include "tests/sim/sample_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

using namespace sim;

namespace {

/// The search ends at rounding of the interval of 1 s; a gap of some metres is exact to 1e-15 m, and the
/// impacts here are faster than 1 m/s.
constexpr double time_rounding = 1e-12;

struct Approach {
    Bodies bodies;
    std::vector<PairContacts> pairs;
    StepSettings settings{.gravity = Vec3(0, 0, -10), .impacts = ImpactHandling::stop};

    void pair(int a, int b) {
        PairContacts& found = pairs.emplace_back();
        found.manifold.body_a = a;
        found.manifold.body_b = b;
        const auto ia = static_cast<std::size_t>(a);
        const auto ib = static_cast<std::size_t>(b);
        std::vector<FoundContact> contacts;
        find_contacts({bodies.props[ia].shape, bodies.pose[ia]}, {bodies.props[ib].shape, bodies.pose[ib]}, 100.0, contacts);
        replace_contacts(found, contacts);
    }
    std::optional<Impact> impact(double h) const {
        return time_of_impact(bodies, bodies.velocity, pairs, settings, h);
    }
};

/// A ball of radius 0.5 m whose lowest point is `height` above a plane.
Approach falling_ball(double height, double speed) {
    Approach scene;
    add_body(scene.bodies, make_props(Sphere{0.5}, 1000.0), {Vec3(1, 2, height + 0.5), Quat::Identity()},
             {Vec3(3, 0, -speed), Vec3(1, 2, 3)});
    add_body(scene.bodies, make_props(Plane{}, 0.0), Pose{});
    scene.pair(0, 1);
    return scene;
}

} // namespace

TEST(time_of_impact, falling_ball_touches_at_the_root_of_its_parabola) {
    for (const double height : {1.0, 1e-3, 1e-6}) {
        const Approach scene = falling_ball(height, 1.0);
        const std::optional<Impact> impact = scene.impact(1.0);
        ASSERT_TRUE(impact);
        // height = t + 5 t^2, written without cancellation.
        EXPECT_NEAR(impact->time, 2.0 * height / (1.0 + std::sqrt(1.0 + 20.0 * height)), time_rounding);
        EXPECT_EQ(impact->pair, 0u);
        EXPECT_EQ(impact->contact, 0u);
    }
}

TEST(time_of_impact, an_impact_after_the_interval_is_none) {
    const Approach scene = falling_ball(1.0, 1.0); // touches at 0.358 s
    EXPECT_FALSE(scene.impact(0.35));
    EXPECT_TRUE(scene.impact(0.36));
}

TEST(time_of_impact, touching_or_leaving_contacts_are_no_impacts) {
    EXPECT_FALSE(falling_ball(0.0, 1.0).impact(1.0));
    EXPECT_FALSE(falling_ball(1e-3, -20.0).impact(1.0));
}

TEST(time_of_impact, an_approach_below_the_resting_threshold_rests) {
    const Approach still = falling_ball(1e-5, 0.0);
    const double threshold = resting_threshold(still.settings); // sqrt(2 * 10 * 1e-4)
    EXPECT_NEAR(threshold, std::sqrt(2e-3), 1e-15);
    // The speed at the touch counts: the approach, and what the fall over the gap adds.
    const double gap = 1e-5;
    const auto approach = [&](double at_touch) { return std::sqrt(at_touch * at_touch - 2.0 * 10.0 * gap); };
    EXPECT_FALSE(falling_ball(gap, approach(0.99 * threshold)).impact(1.0));
    EXPECT_TRUE(falling_ball(gap, approach(1.01 * threshold)).impact(1.0));
}

TEST(time_of_impact, without_gravity_the_threshold_has_a_floor) {
    StepSettings settings;
    settings.gravity = Vec3::Zero();
    EXPECT_EQ(resting_threshold(settings), settings.resting_speed_floor);
}

/// A cube of side 1 m spins about its centre, which falls: a lower edge, at angle 45 deg + w t, touches.
TEST(time_of_impact, spinning_cube_touches_with_an_edge) {
    Approach scene;
    scene.settings.gravity = Vec3::Zero();
    const double w = 2.0;
    add_body(scene.bodies, make_props(Box{}, 1000.0), {Vec3(0, 0, 1.0), Quat::Identity()},
             {Vec3(0, 0, -1.0), Vec3(0, w, 0)});
    add_body(scene.bodies, make_props(Plane{}, 0.0), Pose{});
    scene.pair(0, 1);
    const std::optional<Impact> impact = scene.impact(1.0);
    ASSERT_TRUE(impact);
    // Height of the lower edge: 1 - t - sqrt(1/2) sin(45 deg + w t) = 0 there.
    const double t = impact->time;
    EXPECT_NEAR(1.0 - t - std::sqrt(0.5) * std::sin(std::numbers::pi / 4.0 + w * t), 0.0, time_rounding);
    EXPECT_LT(t, 0.5); // before the face would have
}

TEST(time_of_impact, the_earliest_of_several_pairs_is_found) {
    Approach scene;
    scene.settings.gravity = Vec3::Zero();
    const BodyProps ball = make_props(Sphere{0.5}, 1000.0);
    // Bodies 0 and 1 meet after 0.5 s, 2 and 3 after 0.25 s, 4 and 5 after 0.75 s.
    for (int k = 0; k < 3; ++k) {
        const double distance = std::array{1.0, 0.5, 1.5}[static_cast<std::size_t>(k)];
        const Vec3 lane(0, 10.0 * k, 0);
        const int a = add_body(scene.bodies, ball, {lane, Quat::Identity()}, {Vec3(1, 0, 0), Vec3::Zero()});
        const int b = add_body(scene.bodies, ball, {lane + Vec3(1.0 + distance, 0, 0), Quat::Identity()},
                               {Vec3(-1, 0, 0), Vec3::Zero()});
        scene.pair(a, b);
    }
    const std::optional<Impact> impact = scene.impact(1.0);
    ASSERT_TRUE(impact);
    EXPECT_EQ(impact->pair, 1u);
    EXPECT_NEAR(impact->time, 0.25, time_rounding);
}

/// A cylinder whose near rim stands on a plane falls flat: the rim's lowest point is closed from the start, so its far side
/// is followed by the material point that comes down.
TEST(time_of_impact, far_side_of_a_rim_that_touches_is_followed_by_its_points) {
    const double tilt = 1e-3;
    const Cylinder cylinder{0.5, 0.25};
    const auto pose_at = [&](double angle) {
        const Quat turn(Eigen::AngleAxisd(angle, Vec3::UnitY()));
        // Turns about the rim's point at x = 0.5 on the floor.
        return Pose{Vec3(0.5, 0, 0) + turn * Vec3(-0.5, 0, 0.25), turn};
    };
    const Pose floor;
    const Pose standing = pose_at(tilt);
    const Pose past_flat = pose_at(-tilt);
    std::vector<FoundContact> contacts;
    find_contacts({cylinder, past_flat}, {Plane{}, floor}, 0.0, contacts);
    const auto rim = std::ranges::find_if(contacts, [](const FoundContact& c) { return is_rim(c.feature.kind); });
    ASSERT_NE(rim, contacts.end());
    // As repair() hands it over: the points found at the end, where they were at the start.
    FoundContact far = *rim;
    const auto at_start = [&](const Vec3& p) {
        return Vec3(standing.position + standing.orientation * (past_flat.orientation.conjugate() * (p - past_flat.position)));
    };
    far.at.a = at_start(rim->at.a);
    far.at.gap = far.at.n.dot(far.at.a - rim->at.b());
    ASSERT_GT(far.at.gap, 0.5 * tilt);
    ASSERT_LE(contact_geometry(far.feature, standing, floor).gap, 1e-12);
    const auto gap_at = [&](const Pose& pose) { return impact_gap(far, {standing, floor}, {pose, floor}, 1e-10); };
    EXPECT_NEAR(gap_at(standing), far.at.gap, 1e-12);
    EXPECT_NEAR(gap_at(pose_at(0.0)), 0.0, 1e-6);
    EXPECT_LT(gap_at(past_flat), -0.5 * tilt);
}
