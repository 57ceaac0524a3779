#include "render/scene/occlusion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

render::Instance box(const glm::vec3& position, const glm::vec3& half,
                     const glm::vec4& orientation = {0, 0, 0, 1}) {
    render::Instance result{};
    result.orientation = orientation;
    result.position = position;
    result.scale = half;
    result.bounding_radius = glm::length(half);
    return result;
}

/// Sum of all cells [m^3].
float filled_volume(const render::OcclusionVolume& volume) {
    float sum = 0.0f;
    for (const float share : volume.level(0).filled) {
        sum += share;
    }
    return sum * std::pow(volume.cell(), 3.0f);
}

} // namespace

TEST(occlusion, filled_cells_have_the_volume_of_the_bodies) {
    render::OcclusionVolume volume({-2, -2, -2}, {2, 2, 2}, 0.1f);
    volume.add_box(box({0.03f, 0.02f, 0.01f}, {0.5f, 0.7f, 0.3f}));
    EXPECT_NEAR(filled_volume(volume), 8 * 0.5f * 0.7f * 0.3f, 0.01f);
    // Turned by 30 degrees about z.
    render::OcclusionVolume turned({-2, -2, -2}, {2, 2, 2}, 0.1f);
    turned.add_box(box({0, 0, 0}, {0.5f, 0.7f, 0.3f}, {0, 0, std::sin(0.2618f), std::cos(0.2618f)}));
    EXPECT_NEAR(filled_volume(turned), 8 * 0.5f * 0.7f * 0.3f, 0.02f);
    render::OcclusionVolume ball({-2, -2, -2}, {2, 2, 2}, 0.1f);
    ball.add_ellipsoid(box({0, 0, 0}, {1, 1, 1}));
    EXPECT_NEAR(filled_volume(ball), 4.18879f, 0.1f);
}

TEST(occlusion, lone_face_sees_the_whole_sky) {
    for (int i = 0; i < 12; ++i) {
        const float angle = 0.13f * static_cast<float>(i);
        const glm::vec4 turn(std::sin(angle) * 0.6f, 0, std::sin(angle) * 0.8f, std::cos(angle));
        render::OcclusionVolume volume({-3, -3, -3}, {3, 3, 3}, 0.1f);
        volume.add_box(box({0, 0, 0}, {1, 1, 1}, turn));
        volume.finish();
        const glm::vec3 normal = render::turned(turn, {0, 0, 1});
        for (const glm::vec3& place : {glm::vec3(0, 0, 1), glm::vec3(1, 1, 1), glm::vec3(0.5f, -0.9f, 1)}) {
            EXPECT_GT(volume.open_share(render::turned(turn, place), normal), 0.985f) << i;
        }
    }
}

TEST(occlusion, a_wall_takes_sky_from_the_ground_beside_it_and_less_farther_away) {
    render::OcclusionVolume volume({-3, -3, -1}, {3, 3, 4}, 0.1f);
    volume.add_half_space({0, 0, 0}, {0, 0, 1});
    volume.add_box(box({1.0f, 0, 1.5f}, {0.5f, 2.5f, 1.5f}));
    volume.finish();
    float last = 0.0f;
    for (const float distance : {0.02f, 0.2f, 0.4f, 0.8f}) {
        const float open = volume.open_share({0.5f - distance, 0, 0}, {0, 0, 1});
        EXPECT_GT(open, last);
        last = open;
    }
    // A long high wall takes half of the sky at its foot; the samples reach one and a half metres.
    EXPECT_LT(volume.open_share({0.48f, 0, 0}, {0, 0, 1}), 0.7f);
    EXPECT_GT(volume.open_share({-1.5f, 0, 0}, {0, 0, 1}), 0.95f);
    EXPECT_EQ(volume.open_share({0, 0, 30}, {0, 0, 1}), 1.0f);
}

TEST(occlusion, without_bodies_all_is_open) {
    EXPECT_EQ(render::OcclusionVolume().open_share({0, 0, 0}, {0, 0, 1}), 1.0f);
}
