#include "render/scene/camera.h"

#include "sample_scenes.h"
#include "sim/base/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace {

sim::CameraDef moving_camera() {
    sim::CameraDef camera;
    camera.keys = {
        {0.0, {0, -10, 5}, {0, 0, 0}}, {1.0, {4, -10, 5}, {1, 0, 0}}, {3.0, {8, -6, 9}, {2, 0, 1}}};
    return camera;
}

render::View view_at(const sim::CameraDef& camera, double time) {
    sim::Snapshot snapshot;
    snapshot.time = time;
    snapshot.bodies.resize(2);
    snapshot.bodies[1].position = sim::Vec3(1, 2, 3);
    return render::camera_view(camera, snapshot, 16.0 / 9.0);
}

} // namespace

TEST(camera, keys_are_passed_at_their_times_and_held_outside) {
    const sim::CameraDef camera = moving_camera();
    for (const sim::CameraKey& key : camera.keys) {
        EXPECT_LT((view_at(camera, key.time).eye - key.eye).norm(), 1e-12);
        EXPECT_LT((view_at(camera, key.time).target - key.target).norm(), 1e-12);
    }
    EXPECT_EQ(view_at(camera, -1.0).eye, camera.keys.front().eye);
    EXPECT_EQ(view_at(camera, 9.0).eye, camera.keys.back().eye);
}

TEST(camera, velocity_between_keys_is_continuous_and_zero_at_both_ends) {
    const sim::CameraDef camera = moving_camera();
    constexpr double step = 1e-5;
    const auto velocity = [&](double time) {
        return sim::Vec3((view_at(camera, time + step).eye - view_at(camera, time).eye) / step);
    };
    // The curve's acceleration is below 100 m/s^2, so over two steps its velocity changes by 2e-3 m/s at
    // most.
    EXPECT_LT((velocity(1.0 - step) - velocity(1.0)).norm(), 2e-3);
    EXPECT_GT(velocity(1.0).norm(), 1.0);
    EXPECT_LT(velocity(0.0).norm(), 2e-3);
    EXPECT_LT(velocity(3.0 - step).norm(), 2e-3);
}

TEST(camera, orbit_returns_after_its_period) {
    sim::CameraDef camera;
    camera.kind = sim::CameraKind::orbit;
    camera.keys = {{0.0, {3, 0, 2}, {1, 0, 1}}};
    camera.period = 8.0;
    EXPECT_LT((view_at(camera, 2.0).eye - sim::Vec3(1, 2, 2)).norm(), 1e-12);
    EXPECT_LT((view_at(camera, 8.0).eye - sim::Vec3(3, 0, 2)).norm(), 1e-12);
    EXPECT_EQ(view_at(camera, 2.0).target, sim::Vec3(1, 0, 1));
}

TEST(camera, follow_moves_with_its_body) {
    sim::CameraDef camera;
    camera.kind = sim::CameraKind::follow;
    camera.keys = {{0.0, {0, -5, 2}, {0, 0, 1}}};
    camera.body = 1;
    EXPECT_EQ(view_at(camera, 0.0).eye, sim::Vec3(1, -3, 5));
    EXPECT_EQ(view_at(camera, 0.0).target, sim::Vec3(1, 2, 4));
}

TEST(camera, opening_between_keys_follows_the_curve_and_a_cut_holds) {
    sim::CameraDef camera = moving_camera();
    camera.fov_degrees = 30.0;
    camera.keys[1].fov_degrees = 60.0;
    camera.keys[0].easing = sim::Easing::linear;
    camera.keys[1].easing = sim::Easing::cut;
    EXPECT_DOUBLE_EQ(view_at(camera, 0.0).fov_degrees, 30.0);
    EXPECT_NEAR(view_at(camera, 0.5).fov_degrees, 45.0, 1e-9);
    EXPECT_LT((view_at(camera, 0.25).eye - sim::Vec3(1, -10, 5)).norm(), 1e-12);
    EXPECT_DOUBLE_EQ(view_at(camera, 2.999).fov_degrees, 60.0);
    EXPECT_EQ(view_at(camera, 2.999).eye, camera.keys[1].eye);
    EXPECT_EQ(view_at(camera, 3.0).eye, camera.keys[2].eye);
}

TEST(camera, stops_at_both_keys_of_a_piece_that_eases) {
    sim::CameraDef camera = moving_camera();
    camera.keys[0].easing = sim::Easing::stop;
    constexpr double step = 1e-5;
    const auto speed = [&](double time) {
        return (view_at(camera, time + step).eye - view_at(camera, time).eye).norm() / step;
    };
    EXPECT_LT(speed(1.0 - step), 2e-3); // below the curve's acceleration, 100 m/s^2, times two steps
    EXPECT_LT(speed(1.0), 2e-3);
    EXPECT_GT(speed(0.5), 1.0);
}

TEST(camera, track_turns_after_its_body_and_orbit_goes_around_it) {
    sim::CameraDef camera;
    camera.keys = {{0.0, {0, -5, 2}, {0, 0, 0}}};
    camera.body = 1;
    camera.kind = sim::CameraKind::track;
    EXPECT_EQ(view_at(camera, 0.0).eye, sim::Vec3(0, -5, 2));
    EXPECT_EQ(view_at(camera, 0.0).target, sim::Vec3(1, 2, 3));
    camera.kind = sim::CameraKind::orbit;
    camera.period = 4.0;
    EXPECT_LT((view_at(camera, 1.0).eye - sim::Vec3(6, 2, 5)).norm(), 1e-12);
    EXPECT_EQ(view_at(camera, 1.0).target, sim::Vec3(1, 2, 3));
}

TEST(camera, narrow_picture_shows_the_width_of_a_wide_one) {
    EXPECT_EQ(render::opening_degrees(40.0, 2.0), 40.0);
    const double tall = render::opening_degrees(40.0, 9.0 / 16.0);
    const double half_width = std::tan(tall / 2.0 * std::numbers::pi / 180.0) * 9.0 / 16.0;
    EXPECT_NEAR(half_width, std::tan(20.0 * std::numbers::pi / 180.0) * 16.0 / 9.0, 1e-12);
}

/// Of all balls, in half pictures from the middle, the farthest right, left, up and down.
TEST(camera, frame_holds_all_bodies_in_every_format_and_none_could_be_nearer) {
    sim::CameraDef camera;
    camera.kind = sim::CameraKind::frame;
    camera.keys = {{0.0, {4, -10, 6}, {0, 0, 0}}};
    camera.framed = {{0, 0.5}, {1, 0.2}, {2, 1.0}};
    sim::Snapshot snapshot;
    snapshot.bodies.resize(3);
    snapshot.bodies[1].position = sim::Vec3(3, 1, 0);
    snapshot.bodies[2].position = sim::Vec3(-2, 4, 5);
    for (const double aspect : {16.0 / 9.0, 1.0, 9.0 / 16.0}) {
        const render::View view = render::camera_view(camera, snapshot, aspect);
        const sim::Vec3 forward = (view.target - view.eye).normalized();
        EXPECT_LT((forward - sim::Vec3(-4, 10, -6).normalized()).norm(), 1e-12);
        const sim::Vec3 right = forward.cross(sim::Vec3::UnitZ()).normalized();
        const sim::Vec3 up = right.cross(forward);
        double most = 0.0; // of the halves of the picture, where a ball's edge is seen
        for (const sim::FramedBody& framed : camera.framed) {
            const sim::Vec3 at = snapshot.bodies[static_cast<std::size_t>(framed.body)].position - view.eye;
            const double tan_v = std::tan(20.0 * std::numbers::pi / 180.0);
            for (const auto& [axis, half] : {std::pair(right, tan_v * aspect), std::pair(up, tan_v)}) {
                const double across = std::abs(at.dot(axis)), ahead = at.dot(forward);
                const double edge = std::atan2(across, ahead) + std::asin(framed.radius / std::hypot(across, ahead));
                most = std::max(most, std::tan(edge) / half);
            }
        }
        EXPECT_NEAR(most, 0.92, 1e-9) << aspect; // the share that frame_view leaves them
    }
}

TEST(camera, moved_snapshot_turns_and_drifts) {
    sim::Snapshot snapshot;
    snapshot.time = 1.0;
    snapshot.bodies.resize(1);
    snapshot.bodies[0].velocity = sim::Vec3(1, 2, 3);
    snapshot.bodies[0].angular_velocity = sim::Vec3(0, 0, std::numbers::pi);
    const sim::Snapshot later = render::moved(snapshot, 0.5);
    EXPECT_EQ(later.time, 1.5);
    EXPECT_EQ(later.bodies[0].position, sim::Vec3(0.5, 1.0, 1.5));
    EXPECT_LT((later.bodies[0].orientation * sim::Vec3::UnitX() - sim::Vec3::UnitY()).norm(), 1e-12);
    EXPECT_LT(
        (render::moved(later, -0.5).bodies[0].orientation * sim::Vec3::UnitX() - sim::Vec3::UnitX()).norm(),
        1e-12);
}

TEST(camera, is_found_by_name_and_the_first_without_one) {
    sim::SceneDef scene;
    scene.cameras = {moving_camera(), moving_camera()};
    scene.cameras[1].name = "top";
    EXPECT_EQ(&render::find_camera(scene, ""), &scene.cameras[0]);
    EXPECT_EQ(&render::find_camera(scene, "top"), &scene.cameras[1]);
    EXPECT_THROW(render::find_camera(scene, "side"), sim::Error);
}
