#pragma once
/// Plain data that travels from the draw list to the stages of one picture (GLM, float).
#include <glm/glm.hpp>

#include <cstdint>

namespace render {

/// Triangles an instance is made of. A lathe surface has its own mesh: lathe_first + index of its profile; after all
/// of them come the hulls.
namespace mesh_id {
inline constexpr int sphere_first = 0; ///< spheres from coarse to fine
inline constexpr int sphere_count = 4;
inline constexpr int rod = sphere_count;
inline constexpr int lathe_first = rod + 1;
} // namespace mesh_id

/// One placed part, as the vertex shader reads it.
struct Instance {
    glm::vec4 orientation;   ///< unit quaternion world_from_body, x y z w
    glm::vec3 position;      ///< [m]
    float roughness;         ///< [-] 0.05..1
    glm::vec3 scale;         ///< [m], of the unit mesh (half extents of a box); 1 for a lathe
    float metallic;          ///< [-] 0..1
    glm::vec3 color;         ///< linear RGB
    std::uint32_t id;        ///< of its first surface group; 0 is the background
    glm::vec3 pattern_color; ///< linear RGB
    float bounding_radius;   ///< [m] about position
};
static_assert(sizeof(Instance) == 5 * 16);

/// Pixels of a picture, counted from its lowest left corner.
struct PixelRect {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;

    friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

struct CameraBlock {
    glm::mat4 clip_from_world; ///< depth 1 at the near plane, 0 at the far plane
    glm::mat4 world_from_clip;
    glm::vec3 eye; ///< [m]
};

/// Orthographic volume seen from the sun that holds everything that throws a shadow.
struct ShadowVolume {
    glm::mat4 clip_from_world; ///< depth 0 nearest to the sun, 1 farthest
    glm::mat4 world_from_clip;
    float texel_size; ///< [m] on a plane across the light
};

struct LightBlock {
    glm::vec3 to_sun;     ///< unit
    glm::vec3 sun;        ///< linear RGB, irradiance / pi
    glm::vec3 sky_zenith; ///< linear RGB radiance
    glm::vec3 sky_horizon;
    glm::vec3 ground; ///< radiance seen below the horizon
};

/// x turned by the unit quaternion q (x y z w).
inline glm::vec3 turned(const glm::vec4& q, const glm::vec3& x) {
    const glm::vec3 v(q);
    const glm::vec3 t = 2.0f * glm::cross(v, x);
    return x + q.w * t + glm::cross(v, t);
}

/// The inverse turn.
inline glm::vec3 turned_back(const glm::vec4& q, const glm::vec3& x) {
    return turned({-q.x, -q.y, -q.z, q.w}, x);
}

} // namespace render
