#include "render/picture/renderer.h"

#include "sample_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

constexpr int frame_width = 320;
constexpr int frame_height = 180;
constexpr int shutter_states = 4;

/// A ball that moves to the right; the sun stands before and left of it.
sim::SceneDef moving_ball(const sim::Vec3& position) {
    sim::SceneDef scene;
    sample::add_floor(scene);
    scene.bodies.push_back(sample::body(sim::Sphere{0.3}, {position}, {0.9, 0.2, 0.1}));
    scene.bodies.back().look.pattern = sim::Pattern::stripes;
    scene.bodies.back().velocity = sim::Vec3(4, 0, 0);
    scene.bodies.back().angular_velocity = sim::Vec3(0, 13, 0);
    sample::set_camera(scene, {1, -8, 4}, {0.4, 0.4, 0.2}, 40);
    return scene;
}

/// It flies: its shadow runs over floor and wall.
sim::SceneDef flying_ball() {
    sim::SceneDef scene = moving_ball({0, 0, 1.5});
    scene.bodies.push_back(sample::body(sim::Box{{1.0, 0.05, 0.4}}, {{0.5, 1.4, 0.4}}, {0.7, 0.7, 0.7}));
    return scene;
}

/// Under a bright sky it takes light from a white floor.
sim::SceneDef shading_ball() {
    sim::SceneDef scene = moving_ball({0, 0, 0.3});
    scene.light.sun_intensity = 0.1;
    scene.bodies[0].look.color = sim::Vec3(0.9, 0.9, 0.9);
    return scene;
}

/// It rolls past a disc and a block.
sim::SceneDef rolling_ball() {
    sim::SceneDef scene = shading_ball();
    scene.bodies.push_back(sample::body(sim::Cylinder{0.2, 0.05}, {{-0.35, -0.4, 0.05}}, {0.9, 0.9, 0.9}));
    scene.bodies.push_back(sample::body(sim::Box{{0.2, 0.2, 0.1}}, {{0.2, -0.6, 0.1}}, {0.9, 0.9, 0.9}));
    return scene;
}

/// Another one mirrors it.
sim::SceneDef mirrored_ball() {
    sim::SceneDef scene = moving_ball({0, 0, 0.3});
    scene.bodies.push_back(sample::body(sim::Sphere{0.5}, {{-2.4, -0.4, 0.5}}, {0.8, 0.8, 0.8}));
    scene.bodies.back().look.metallic = 1.0;
    scene.bodies.back().look.roughness = 0.1;
    return scene;
}

struct Differences {
    int largest = 0;
    int count = 0; ///< of values that differ by more than a step
};

Differences differences(const render::Image& a, const render::Image& b) {
    Differences found;
    for (std::size_t k = 0; k < a.rgb.size(); ++k) {
        const int difference = std::abs(a.rgb[k] - b.rgb[k]);
        found.largest = std::max(found.largest, difference);
        found.count += difference > 1 ? 1 : 0;
    }
    return found;
}

} // namespace

// The whole pictures of the same states each have a shadow map of their own: under the ball some pixels differ by more
// than roundings.
TEST(changed, sub_frames_drawn_in_part_are_those_drawn_whole) {
    for (const sim::SceneDef& scene : {flying_ball(), shading_ball(), rolling_ball(), mirrored_ball()}) {
        const sim::Snapshot snapshot = sample::start(scene);
        const std::vector<sim::Snapshot> states = render::states_in_shutter(snapshot, 0.05, shutter_states);
        render::Renderer renderer(scene, frame_width, frame_height);
        render::PictureMean mean;
        for (const sim::Snapshot& state : states) {
            mean.add(renderer.draw(state), {0, 0, frame_width, frame_height});
        }
        const render::Image expected = mean.take();
        const Differences found = differences(renderer.draw_blurred(snapshot, 0.05, shutter_states), expected);
        EXPECT_LE(found.largest, 6);
        EXPECT_LT(found.count, 60);
        EXPECT_GT(differences(renderer.draw(snapshot), expected).largest, 30); // blurred it is

        const std::vector<render::DrawList> lists = render::PicturePlan(scene, frame_width, frame_height).lists(states);
        EXPECT_EQ(lists[0].redrawn, (render::PixelRect{0, 0, frame_width, frame_height}));
        EXPECT_EQ(lists[1].redrawn, lists[3].redrawn);
        EXPECT_LT(lists[1].redrawn.width * lists[1].redrawn.height, frame_width * frame_height / 4);
        EXPECT_LT(lists[1].shadows_redrawn.width, lists[0].shadows_redrawn.width * 3 / 4);
    }
}

TEST(changed, a_body_is_not_drawn_until_it_is_released) {
    const sim::SceneDef there = flying_ball();
    sim::SceneDef scene = there, none = there;
    scene.bodies[2].release = 1.0;
    none.bodies[2].look.visible = false;
    const auto picture = [](const sim::SceneDef& of, double time) {
        return render::Renderer(of, frame_width, frame_height).draw(sample::start(of, time)).rgb;
    };
    EXPECT_EQ(picture(scene, 1.0), picture(there, 1.0));
    EXPECT_EQ(picture(scene, 0.99), picture(none, 0.99)); // its shadow neither
    EXPECT_NE(picture(there, 1.0), picture(none, 1.0));
    // It comes, and stands, while the shutter is open.
    const sim::Snapshot snapshot = sample::start(scene, 1.0);
    render::Renderer renderer(scene, frame_width, frame_height);
    render::PictureMean mean;
    for (const sim::Snapshot& state : render::states_in_shutter(snapshot, 0.05, shutter_states)) {
        mean.add(renderer.draw(state), {0, 0, frame_width, frame_height});
    }
    EXPECT_LT(differences(renderer.draw_blurred(snapshot, 0.05, shutter_states), mean.take()).count, 60);
}

// More would come than rays can follow: it mirrors nothing from the start, not until they come.
TEST(changed, a_ball_mirrors_the_same_during_a_whole_film) {
    const auto mirrored_with = [](int later) {
        sim::SceneDef scene = mirrored_ball();
        for (int i = 0; i < later; ++i) {
            scene.bodies.push_back(sample::body(sim::Sphere{0.05}, {{0.2 * i, 1, 1}}, {0.9, 0.9, 0.9}));
            scene.bodies.back().release = 1.0;
        }
        const std::vector<sim::Snapshot> states{sample::start(scene)};
        return render::PicturePlan(scene, frame_width, frame_height).lists(states)[0].mirrored.spheres;
    };
    EXPECT_EQ(mirrored_with(30), 2);
    EXPECT_EQ(mirrored_with(31), 0);
}

TEST(changed, all_is_drawn_anew_where_the_camera_or_the_floor_moves) {
    sim::SceneDef scene = rolling_ball();
    const auto redrawn = [&scene] {
        const std::vector<sim::Snapshot> states = render::states_in_shutter(sample::start(scene), 0.05, shutter_states);
        return render::PicturePlan(scene, frame_width, frame_height).lists(states)[1].redrawn;
    };
    const render::PixelRect whole{0, 0, frame_width, frame_height};
    EXPECT_NE(redrawn(), whole);
    scene.bodies[0].velocity = sim::Vec3(0, 0, 0.1);
    EXPECT_EQ(redrawn(), whole);
    scene.bodies[0].velocity = sim::Vec3::Zero();
    scene.cameras[0].kind = sim::CameraKind::track;
    scene.cameras[0].body = 1;
    EXPECT_EQ(redrawn(), whole);
}
