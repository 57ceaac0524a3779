#include "render/scene/projection.h"

#include "render/scene/floor_region.h"
#include "sample_scenes.h"

#include <gtest/gtest.h>

#include <vector>

namespace {

render::Instance box_at(const glm::vec3& position, float half) {
    render::Instance box{};
    box.orientation = {0, 0, 0, 1};
    box.position = position;
    box.scale = glm::vec3(half);
    box.bounding_radius = half * 1.7320508f;
    return box;
}

const render::ViewPoint view{{0, -10, 2}, {0, 0, 0}, 40.0, 16.0 / 9.0};

std::vector<render::Instance> scattered_boxes() {
    sample::Random random(3);
    std::vector<render::Instance> boxes;
    for (int i = 0; i < 50; ++i) {
        boxes.push_back(box_at(glm::vec3(random() * 8 - 4, random() * 8 - 4, random() * 6 + 0.5), 0.4f));
    }
    return boxes;
}

glm::vec3 in_clip(const glm::mat4& clip_from_world, const glm::vec3& p) {
    const glm::vec4 q = clip_from_world * glm::vec4(p, 1.0f);
    return glm::vec3(q) / q.w;
}

} // namespace

TEST(projection, target_is_in_the_middle_and_depth_falls_from_one_to_zero) {
    const render::CameraBlock camera = render::make_camera(view, {1.0, 100.0});
    const glm::vec3 target = in_clip(camera.clip_from_world, glm::vec3(view.target));
    EXPECT_NEAR(target.x, 0.0f, 1e-5f);
    EXPECT_NEAR(target.y, 0.0f, 1e-5f);
    const glm::vec3 forward(glm::normalize(view.target - view.eye));
    EXPECT_NEAR(in_clip(camera.clip_from_world, camera.eye + forward * 1.0f).z, 1.0f, 1e-5f);
    EXPECT_NEAR(in_clip(camera.clip_from_world, camera.eye + forward * 100.0f).z, 0.0f, 1e-5f);
}

TEST(projection, depth_range_holds_all_instances) {
    const std::vector<render::Instance> boxes = scattered_boxes();
    const render::DepthRange range = render::depth_range(view, boxes, 140.0, false);
    const render::CameraBlock camera = render::make_camera(view, range);
    for (const render::Instance& box : boxes) {
        const float z = in_clip(camera.clip_from_world, box.position).z;
        EXPECT_GT(z, 0.0f);
        EXPECT_LT(z, 1.0f);
    }
}

TEST(projection, only_what_misses_the_picture_is_outside) {
    const render::CameraBlock camera = render::make_camera(view, {1.0, 100.0});
    EXPECT_FALSE(render::is_outside(camera, {0, 0, 0}, 0.1f));
    EXPECT_TRUE(render::is_outside(camera, {0, -20, 0}, 1.0f));
    EXPECT_TRUE(render::is_outside(camera, {30, 0, 0}, 1.0f));
    EXPECT_FALSE(render::is_outside(camera, {30, 0, 0}, 29.0f));
}

TEST(projection, shadow_volume_holds_its_instances_and_moves_by_whole_texels) {
    std::vector<render::Instance> boxes = scattered_boxes();
    const render::ShadowSetup setup{
        glm::normalize(glm::dvec3(-1, -2, 3)), {0, 0, 0}, 10.0, 3.0, 0.5, 512, 0.001};
    const render::ShadowVolume first = render::make_shadow_volume(setup, boxes);
    for (const render::Instance& box : boxes) {
        const glm::vec3 p = in_clip(first.clip_from_world, box.position);
        EXPECT_LT(std::max({std::abs(p.x), std::abs(p.y), std::abs(2.0f * p.z - 1.0f)}), 1.0f);
    }
    // All boxes drift: a fixed point keeps its place within the texels.
    for (render::Instance& box : boxes) {
        box.position += glm::vec3(0.013f, 0.007f, -0.011f);
    }
    const render::ShadowVolume second = render::make_shadow_volume(setup, boxes);
    EXPECT_EQ(first.texel_size, second.texel_size);
    const glm::vec3 move =
        (in_clip(second.clip_from_world, {1, 1, 1}) - in_clip(first.clip_from_world, {1, 1, 1})) *
        (0.5f * static_cast<float>(setup.map_size));
    EXPECT_NEAR(move.x, std::round(move.x), 1e-2f);
    EXPECT_NEAR(move.y, std::round(move.y), 1e-2f);
}

TEST(projection, floor_region_holds_every_shadow) {
    std::vector<glm::vec3> corners;
    for (const render::Instance& box : scattered_boxes()) {
        for (int i = 0; i < 8; ++i) {
            corners.push_back(box.position + box.scale * (2.0f * glm::vec3(i & 1, (i >> 1) & 1, i >> 2) - 1.0f));
        }
    }
    const render::FloorFrame floor{{1, 2, 0}, {0, 0, 1}, {1, 0, 0}};
    const glm::vec3 to_sun = glm::normalize(glm::vec3(-1, -2, 3));
    const render::FloorRegion region = render::make_floor_region(floor, {to_sun, 0.0f, 0.0f, 100.0f}, corners);
    const auto is_inside = [&](const glm::vec2& p) {
        for (std::size_t i = 0; i < region.size(); ++i) {
            const glm::vec2 side = region[(i + 1) % region.size()] - region[i];
            const glm::vec2 to = p - region[i];
            if (side.x * to.y - side.y * to.x < -1e-3f) {
                return false;
            }
        }
        return true;
    };
    for (const glm::vec3& corner : corners) {
        EXPECT_TRUE(is_inside(floor.place(corner - to_sun * (corner.z / to_sun.z))));
    }
    EXPECT_FALSE(is_inside({30, 30}));
}
