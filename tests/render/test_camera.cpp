#include "render/scene/camera.h"

#include "sample_scenes.h"
#include "sim/base/error.h"

#include <gtest/gtest.h>

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
    return render::camera_view(camera, snapshot);
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
