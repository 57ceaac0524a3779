#include "render/overlay/closed_form.h"
#include "render/overlay/notes.h"
#include "render/overlay/plot.h"
#include "tests/render/sample_scenes.h"

#include <gtest/gtest.h>

#include <numbers>

using namespace render;

namespace {

/// A ball of 1 kg at (0, 0, 1), and a floor.
sim::SceneDef ball_scene() {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.bodies.push_back(sample::body(sim::Sphere{1.0}, {sim::Vec3(0, 0, 1), sim::Quat::Identity()},
                                        sim::Vec3(0.5, 0.5, 0.5)));
    scene.bodies.back().mass.mass = 1.0;
    scene.bodies.back().mass.inertia = sim::Mat3::Identity();
    sample::set_camera(scene, {0, -10, 1}, {0, 0, 1}, 40.0);
    scene.overlay.bodies = {1};
    return scene;
}

/// The ball rolls along x: its centre at t, turned by t, touched from below.
sim::Snapshot rolled(const sim::SceneDef& scene, std::int64_t step, double t) {
    sim::Snapshot snapshot = sample::start(scene, t);
    snapshot.step = step;
    snapshot.bodies[1].position = sim::Vec3(t, 0, 1);
    snapshot.bodies[1].orientation = sample::turn(t, sim::Vec3::UnitY());
    snapshot.contacts.push_back({{0, 1},
                                 Eigen::Vector3f(static_cast<float>(t), 0, 0),
                                 -Eigen::Vector3f::UnitZ(),
                                 Eigen::Vector3f(0, 0, -1),
                                 true});
    return snapshot;
}

double length(const Path& path) {
    double sum = 0.0;
    for (std::size_t i = 0; i + 1 < path.size(); ++i) {
        sum += (path[i + 1].at - path[i].at).norm();
    }
    return sum;
}

} // namespace

TEST(notes, nothing_asked_for_is_nothing_remembered) {
    const sim::SceneDef scene = ball_scene();
    EXPECT_FALSE(NoteTaker(scene).is_needed());
}

TEST(notes, a_rolling_ball_is_touched_along_its_equator_as_far_as_it_goes) {
    sim::SceneDef scene = ball_scene();
    sample::show(scene, sim::Shown::contact_paths);
    NoteTaker taker(scene);
    for (int i = 0; i <= 1000; ++i) {
        taker.observe(rolled(scene, i, 0.003 * i));
    }
    const std::shared_ptr<const Notes> notes = taker.notes();
    ASSERT_EQ(notes->contact_paths.size(), 1u);
    const ContactPath& path = notes->contact_paths[0];
    ASSERT_EQ(path.on_body.size(), 1u);
    EXPECT_NEAR(length(path.on_body[0]), 3.0, 1e-3);
    EXPECT_NEAR(length(path.in_world[0]), 3.0, 1e-6);
    for (const PathPoint& point : path.on_body[0]) {
        EXPECT_NEAR(point.at.norm(), 1.0, 1e-6);
        EXPECT_NEAR(point.at.y(), 0.0, 1e-12);
    }
    // 1000 states, but points no closer than a hundredth of the radius.
    EXPECT_LE(path.on_body[0].size(), 302u);
}

TEST(notes, a_body_that_leaves_the_ground_begins_a_new_piece) {
    sim::SceneDef scene = ball_scene();
    sample::show(scene, sim::Shown::contact_paths);
    NoteTaker taker(scene);
    taker.observe(rolled(scene, 0, 0.0));
    taker.observe(rolled(scene, 1, 0.1));
    sim::Snapshot flying = rolled(scene, 2, 0.2);
    flying.contacts.clear();
    taker.observe(flying);
    taker.observe(rolled(scene, 3, 0.3));
    taker.observe(rolled(scene, 4, 1.3)); // another point of the ball: no line across it
    const std::shared_ptr<const Notes> notes = taker.notes();
    ASSERT_EQ(notes->contact_paths[0].on_body.size(), 3u);
    EXPECT_EQ(notes->contact_paths[0].on_body[0].size(), 2u);
    EXPECT_EQ(notes->contact_paths[0].on_body[1].size(), 1u);
}

TEST(notes, trails_forget_what_is_older_than_asked) {
    sim::SceneDef scene = ball_scene();
    sample::show(scene, sim::Shown::trails);
    scene.overlay.trail_time = 0.5;
    NoteTaker taker(scene);
    for (int i = 0; i <= 100; ++i) {
        taker.observe(rolled(scene, i, 0.02 * i));
    }
    const Path trail = taker.notes()->trails.at(0);
    EXPECT_NEAR(trail.front().time, 1.5, 0.03);
    EXPECT_EQ(trail.back().at, sim::Vec3(2, 0, 1));
}

TEST(notes, states_seen_before_are_passed_over) {
    sim::SceneDef scene = ball_scene();
    sample::show(scene, sim::Shown::plots);
    scene.plots.push_back({.title = "", .quantity = sim::PlotQuantity::distance, .bodies = {1}, .range = {}});
    NoteTaker taker(scene);
    taker.observe(rolled(scene, 0, 0.0));
    taker.observe(rolled(scene, 7, 0.7));
    taker.observe(rolled(scene, 7, 0.7));
    const Curve curve = taker.notes()->plots.at(0).at(0);
    ASSERT_EQ(curve.size(), 2u);
    EXPECT_DOUBLE_EQ(curve[1].value, 0.7);
}

TEST(notes, plots_show_known_values) {
    sim::SceneDef scene = ball_scene();
    scene.overlay.zero_height = 0.25;
    sim::Snapshot snapshot = rolled(scene, 1, 0.0);
    snapshot.bodies[1].velocity = sim::Vec3(3, 4, 0);
    snapshot.bodies[1].orientation = sample::turn(0.75, {3, 4, 0});
    snapshot.contact_count = 5;
    using enum sim::PlotQuantity;
    const auto values = [&](sim::PlotQuantity quantity) {
        return plot_values(scene, {.title = "", .quantity = quantity, .bodies = {1}, .range = {}}, snapshot);
    };
    EXPECT_NEAR(values(energy)[0], 12.5, 1e-12);
    EXPECT_NEAR(values(energy)[1], 9.81 * 0.75, 1e-12);
    EXPECT_NEAR(values(energy)[2], 12.5 + 9.81 * 0.75, 1e-12);
    EXPECT_NEAR(values(inclination)[0], 0.75 * 180.0 / std::numbers::pi, 1e-9);
    EXPECT_EQ(values(contacts)[0], 5.0);
    EXPECT_EQ(values(distance)[0], 0.0);
}

// s = v t + (g sin - mu g cos) t^2 / 2 until it stops, on an incline of 30 degrees with mu = 0.8.
TEST(closed_form, a_block_slides_as_coulomb_says_and_stops) {
    sim::SceneDef scene;
    const double angle = std::numbers::pi / 6.0;
    const sim::Quat slope = sample::turn(angle, sim::Vec3::UnitY());
    const sim::Vec3 downhill = slope * sim::Vec3::UnitX();
    scene.bodies.push_back(sample::body(sim::Box{{5, 2, 0.1}}, {sim::Vec3(1, 2, 3), slope}, {}));
    scene.bodies.push_back(
        sample::body(sim::Box{{0.1, 0.1, 0.1}},
                     {sim::Vec3(1, 2, 3) - 4.0 * downhill + slope * sim::Vec3(0, 0, 0.2), slope}, {}));
    scene.bodies[1].velocity = 2.0 * downhill;
    scene.bodies[1].material = {{}, 0.8, 0.8};
    const SlidingBlock stops = sliding_block(scene, 1, 0);
    const double a = 9.81 * (std::sin(angle) - 0.8 * std::cos(angle));
    EXPECT_NEAR(stops.distance(0.3), 0.6 + 0.045 * a, 1e-12);
    EXPECT_NEAR(stops.distance(9.0), -2.0 / a, 1e-12); // v^2 / (2 |a|)
    EXPECT_NEAR(stops.end, 9.0, 1e-12);
    // Half the friction: it goes on. A pair of two coefficients has their geometric mean.
    scene.bodies[0].material = {{}, 0.2, 0.2};
    const SlidingBlock slides = sliding_block(scene, 1, 0);
    EXPECT_NEAR(slides.distance(2.0), 4.0 + 2.0 * 9.81 * (std::sin(angle) - 0.4 * std::cos(angle)), 1e-12);
    // At rest below the friction angle it stays.
    scene.bodies[0].material = {};
    scene.bodies[1].velocity = sim::Vec3::Zero();
    EXPECT_EQ(sliding_block(scene, 1, 0).distance(5.0), 0.0);
}

TEST(plot, ticks_are_round_and_ranges_hold_their_values) {
    EXPECT_DOUBLE_EQ(tick_spacing({0.0, 1.0}, 4), 0.5);
    EXPECT_DOUBLE_EQ(tick_spacing({0.0, 6.0}, 6), 1.0);
    EXPECT_DOUBLE_EQ(tick_spacing({-3e6, 5e6}, 4), 2e6);
    EXPECT_EQ(nice_range(0.0, 0.93), (std::array{0.0, 1.0}));
    EXPECT_EQ(nice_range(0.0, 1.0), (std::array{0.0, 1.0}));
    const std::array<double, 2> flat = nice_range(2.5, 2.5);
    EXPECT_LT(flat[0], 2.5);
    EXPECT_GT(flat[1], 2.5);
    EXPECT_EQ(tick_text(0.5, 0.5), "0.5");
    EXPECT_EQ(tick_text(-20.0, 5.0), "\u221220");
    EXPECT_EQ(tick_text(1e-17, 0.2), "0.0");
    EXPECT_EQ(tick_text(2e6, 1e6), "2e+06");
    EXPECT_EQ(tick_text(150000.0, 50000.0), "150000"); // as 50000 beside it
}

TEST(notes, a_hop_is_short_and_stays_on_the_body) {
    const Path from{{1.0, {0, 0, -1}}};
    EXPECT_TRUE(is_hop(from, {{1.02, {1.05, 0, 0}}}));
    EXPECT_FALSE(is_hop(from, {{1.2, {1.05, 0, 0}}})) << "too long";
    EXPECT_FALSE(is_hop(from, {{1.02, {1.5, 0, 0}}})) << "from a top's ball to its stem";
    EXPECT_FALSE(is_hop(from, {}));
}

TEST(notes, a_hop_across_the_circle_of_a_contact_is_none_in_the_world) {
    render::ContactPath path{0, {{{1.0, {0, 0, -1}}}, {{1.02, {1.05, 0, 0}}}}, {{{1.0, {0, 0, 0}}}, {{1.02, {0.2, 0, 0}}}}};
    EXPECT_TRUE(is_hop_in_world(path, 1));
    path.in_world[1][0].at.x() = 1.0;
    EXPECT_FALSE(is_hop_in_world(path, 1));
}

TEST(notes, of_several_contacts_the_strongest_is_followed) {
    sim::SceneDef scene = ball_scene();
    sample::show(scene, sim::Shown::contact_paths);
    NoteTaker taker(scene);
    for (int i = 0; i <= 10; ++i) {
        sim::Snapshot snapshot = rolled(scene, i, 0.0);
        // The load moves from the lowest point to one at the side: two pieces, no line through the ball.
        snapshot.contacts[0].impulse.z() = -0.1f * static_cast<float>(10 - i);
        snapshot.contacts.push_back(
            {{0, 1}, {1, 0, 1}, -Eigen::Vector3f::UnitX(), {-0.1f * static_cast<float>(i), 0, 0}, true});
        taker.observe(snapshot);
    }
    const ContactPath path = taker.notes()->contact_paths.at(0);
    ASSERT_EQ(path.on_body.size(), 2u);
    EXPECT_EQ(path.on_body[0].back().at, sim::Vec3(0, 0, -1));
    EXPECT_EQ(path.on_body[1].back().at, sim::Vec3(1, 0, 0));
}
