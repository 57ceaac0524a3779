#pragma once
/// What is drawn of one snapshot: the seam between the scene (Eigen, double) and OpenGL (GLM, float).
#include "render/camera.h"
#include "sim/scene_def.h"
#include "sim/snapshot.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace render {

/// Triangles an instance is made of. A lathe surface has its own mesh: lathe_first + index into the lathes.
namespace mesh_id {
inline constexpr int box = 0;
inline constexpr int sphere_fine = 1;
inline constexpr int sphere_coarse = 2;
inline constexpr int rod = 3;
inline constexpr int lathe_first = 4;
} // namespace mesh_id

/// One drawn part, as the vertex shader reads it.
struct Instance {
    glm::vec4 orientation;   ///< unit quaternion world_from_body, x y z w
    glm::vec3 position;      ///< [m]
    float roughness;         ///< [-] 0.05..1
    glm::vec3 scale;         ///< [m], of the unit mesh (half extents of a box); 1 for a lathe
    float metallic;          ///< [-] 0..1
    glm::vec3 color;         ///< linear RGB
    std::uint32_t id;        ///< of the part, 1..; 0 is the background
    glm::vec3 pattern_color; ///< linear RGB
    float bounding_radius;   ///< [m] about position
};

/// Instances drawn by one call: the same mesh and pattern.
struct Batch {
    int mesh = 0;
    sim::Pattern pattern = sim::Pattern::plain;
    int first = 0;
    int count = 0;
    bool has_rounded_edges = false;
};

/// A plane body: its surface is drawn as a floor with a grid.
struct Floor {
    glm::vec3 origin;      ///< a point on it near what the camera looks at [m]
    glm::vec3 normal;      ///< unit
    glm::vec3 tangent;     ///< unit, direction of the grid's first lines
    glm::vec2 grid_origin; ///< of `origin` in the grid, along tangent and across it [m]
    glm::vec3 color;       ///< linear RGB
    glm::vec3 line_color;  ///< linear RGB
    float roughness;       ///< [-]
    std::uint32_t id;
};

struct CameraBlock {
    glm::mat4 clip_from_world; ///< depth 1 at the near plane, 0 at the far plane
    glm::mat4 world_from_clip;
    glm::vec3 eye;       ///< [m]
    float near_distance; ///< [m] along the view direction
    float far_distance;  ///< [m]
    float view_distance; ///< [m] eye to target
};

/// Orthographic volume seen from the sun that holds everything that throws a shadow.
struct ShadowVolume {
    glm::mat4 clip_from_world;
    float texel_size; ///< [m] on a plane across the light
};

struct LightBlock {
    glm::vec3 to_sun;     ///< unit
    glm::vec3 sun;        ///< linear RGB, irradiance / pi
    glm::vec3 sky_zenith; ///< linear RGB radiance
    glm::vec3 sky_horizon;
    glm::vec3 ground; ///< radiance seen below the horizon
};

struct DrawList {
    CameraBlock camera;
    ShadowVolume shadow;
    LightBlock light;
    std::vector<Instance> instances; ///< grouped by batch, nearest first within one
    std::vector<Batch> batches;
    std::vector<Floor> floors;
    float floor_extent = 0.0f; ///< [m] a floor has faded into the sky at this distance from the eye
    float grid_spacing = 1.0f; ///< [m] of the fine lines; every tenth is a strong one
};

/// Picture size and shadow map size, in pixels.
struct Viewport {
    int width = 0;
    int height = 0;
    int shadow_size = 0;
};

/// The surfaces of revolution of a scene, each once.
struct LatheTable {
    std::vector<std::vector<glm::vec2>> profiles; ///< (radius, z) [m]
    std::vector<int> profile_of_body;             ///< [body_count], -1: drawn as its shape
};
LatheTable make_lathe_table(const sim::SceneDef& scene);

/// camera: one of the scene's. Bodies whose pose is not finite are left out.
DrawList make_draw_list(const sim::SceneDef& scene, const LatheTable& lathes, const sim::CameraDef& camera,
                        const sim::Snapshot& snapshot, const Viewport& viewport);

} // namespace render
