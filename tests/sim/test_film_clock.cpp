#include "sim/model/film_clock.h"
#include "sim/model/interpolate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sim {
namespace {

SceneDef scene_at(double speed) {
    SceneDef scene;
    scene.output.speed = speed;
    scene.output.fps = {50, 1};
    scene.output.duration = {2, 1};
    scene.step.time_step = {1, 100};
    return scene;
}

TEST(film_clock, without_a_speed_frames_show_the_nearest_step) {
    const SceneDef scene = scene_at(1.0);
    EXPECT_TRUE(is_real_time(scene.output));
    EXPECT_EQ(frame_instant(scene, 7).step, step_of_frame(7, {50, 1}, {1, 100}));
    EXPECT_EQ(frame_instant(scene, 7).share, 0.0);
    EXPECT_EQ(step_count_of(scene), 200);
}

TEST(film_clock, slow_motion_shows_instants_between_steps) {
    const SceneDef scene = scene_at(0.2); // a frame is 0.4 steps
    EXPECT_EQ(frame_instant(scene, 2).step, 0);
    EXPECT_NEAR(frame_instant(scene, 2).share, 0.8, 1e-12);
    EXPECT_EQ(frame_instant(scene, 5).step, 2);
    EXPECT_EQ(frame_instant(scene, 5).share, 0.0);
    EXPECT_EQ(step_count_of(scene), 40);
    EXPECT_NEAR(simulated_duration(scene.output), 0.4, 1e-15);
}

/// From full speed at 0.5 s down to 0.2 at 1 s, and so on: 0.5 + 0.6 / 2 + 0.2.
TEST(film_clock, ramps_are_integrated_exactly) {
    SceneDef scene = scene_at(1.0);
    scene.output.speed_keys = {{0.5, 1.0}, {1.0, 0.2}};
    EXPECT_DOUBLE_EQ(speed_at(scene.output, 0.75), 0.6);
    EXPECT_DOUBLE_EQ(simulated_time(scene.output, 0.25), 0.25);
    EXPECT_DOUBLE_EQ(simulated_time(scene.output, 0.75), 0.5 + 0.25 * 0.8);
    EXPECT_DOUBLE_EQ(simulated_duration(scene.output), 0.5 + 0.5 * 0.6 + 0.2);
    EXPECT_EQ(step_count_of(scene), 100);
}

/// A body that is thrown while its spin grows evenly about one axis.
Snapshot thrown(double t) {
    Snapshot state;
    state.time = t;
    BodySnapshot body;
    body.position = Vec3(1.0, 2.0, 3.0) * t - Vec3(0, 0, 4.905) * t * t;
    body.velocity = Vec3(1.0, 2.0, 3.0) - Vec3(0, 0, 9.81) * t;
    body.angular_velocity = Vec3(0, 0, 50.0 + 20.0 * t);
    body.orientation = Quat(Eigen::AngleAxisd(50.0 * t + 10.0 * t * t, Vec3::UnitZ()));
    state.bodies = {body};
    return state;
}

SceneDef one_body() {
    SceneDef scene;
    scene.bodies.resize(1);
    return scene;
}

double turn_between(const Quat& a, const Quat& b) {
    return 2.0 * std::acos(std::min(1.0, std::abs(a.dot(b))));
}

TEST(interpolation, even_acceleration_is_exact_through_several_turns) {
    const Snapshot a = thrown(0.1), b = thrown(0.3); // more than one turn apart
    for (const double share : {0.0, 0.3, 0.5, 0.9, 1.0}) {
        const Snapshot truth = thrown(0.1 + 0.2 * share);
        const Snapshot found = interpolated(one_body(), a, b, share);
        EXPECT_NEAR(found.time, truth.time, 1e-15);
        EXPECT_LT((found.bodies[0].position - truth.bodies[0].position).norm(), 1e-14);
        EXPECT_LT((found.bodies[0].velocity - truth.bodies[0].velocity).norm(), 1e-13);
        EXPECT_LT(turn_between(found.bodies[0].orientation, truth.bodies[0].orientation), 1e-7); // sqrt(eps): acos
    }
}

TEST(interpolation, a_body_released_in_between_stands_until_then) {
    SceneDef scene = one_body();
    scene.bodies[0].release = 0.15;
    Snapshot a = thrown(0.0); // as it will begin
    a.time = 0.1;
    Snapshot b = thrown(0.15);
    b.time = 0.3;
    for (const double share : {0.0, 0.2, 0.25, 0.6, 1.0}) {
        const Snapshot found = interpolated(scene, a, b, share);
        const Snapshot truth = thrown(std::max(0.0, found.time - 0.15));
        EXPECT_LT((found.bodies[0].position - truth.bodies[0].position).norm(), 1e-14) << share;
        EXPECT_LT((found.bodies[0].velocity - truth.bodies[0].velocity).norm(), 1e-13) << share;
    }
}

TEST(interpolation, error_of_an_impact_is_found_and_that_of_free_motion_is_none) {
    const std::vector<Snapshot> states{thrown(0.0), thrown(0.1), thrown(0.2), thrown(0.3)};
    const RecordWindow window{&states[0], &states[1], &states[2], &states[3]};
    EXPECT_LT(interpolation_errors(window, {0.5})[0], 1e-12);
    // A ball that is thrown back at 4 m/s in the middle of 0.1 s: the true path has a corner 0.2 m above its ends.
    Snapshot down = states[0], touch = states[0], up = states[0], above = states[0];
    down.time = 0.0, touch.time = 0.1, up.time = 0.2, above.time = 0.3;
    for (Snapshot* state : {&down, &touch, &up, &above}) {
        state->bodies[0].angular_velocity = Vec3::Zero();
        state->bodies[0].velocity = Vec3(0, 0, state->time > 0.15 ? 4.0 : -4.0);
        state->bodies[0].position = Vec3(0, 0, 4.0 * std::abs(state->time - 0.15));
    }
    const double error = interpolation_errors({&down, &touch, &up, &above}, {0.5})[0];
    const double truth = interpolated(one_body(), touch, up, 0.5).bodies[0].position.z(); // should be 0
    EXPECT_NEAR(std::abs(truth), 0.1, 1e-12);
    EXPECT_NEAR(error, 8.0 * 0.1 / 8.0, 1e-12);
}

} // namespace
} // namespace sim
