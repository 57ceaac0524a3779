#pragma once
/// What is drawn of one snapshot: the seam between the scene (Eigen, double) and OpenGL (GLM, float).
#include "render/scene/camera.h"
#include "render/scene/draw_types.h"
#include "render/scene/floor_region.h"
#include "render/scene/geometry.h"
#include "render/scene/mirrored.h"
#include "render/scene/occlusion.h"
#include "render/scene/projection.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace render {

/// A flat face that the camera can see, as the vertex shader reads it (texels of 16 bytes).
struct Face {
    glm::vec3 center; ///< [m]
    float roughness;  ///< [-] 0.05..1
    glm::vec3 half_u; ///< [m] from the centre to the middle of an edge; half_u x half_v points outwards
    float metallic;   ///< [-] 0..1
    glm::vec3 half_v; ///< [m]
    std::uint32_t id; ///< index into DrawList::faces, plus 1
    glm::vec3 color;  ///< linear RGB
    std::uint32_t
        open_corners; ///< share of the sky seen at -u-v, +u-v, -u+v, +u+v, 1/255 each, lowest byte first
    glm::vec3 pattern_color; ///< linear RGB
    std::uint32_t box; ///< number of the box whose face it is
    glm::vec4
        open_place; ///< of a large face: texture coordinates of the corners -u-v and +u+v in the sky atlas
    glm::vec3 body_center; ///< in the body, in the units that its pattern is counted in
    float unused_1;
    glm::vec3 body_half_u;
    float unused_2;
    glm::vec3 body_half_v;
    float unused_3;
};
static_assert(sizeof(Face) == 9 * 16);

/// Which program draws a face.
struct FaceKind {
    sim::Pattern pattern = sim::Pattern::plain;
    bool is_lit = false;   ///< turned towards the sun
    bool is_metal = false; ///< at least in part
    bool is_large =
        false; ///< so large that the share of the sky is told in the atlas, not at the corners alone

    friend auto operator<=>(const FaceKind&, const FaceKind&) = default;
};

/// Faces drawn by one call.
struct FaceBatch {
    FaceKind kind;
    int first = 0; ///< index into DrawList::faces
    int count = 0;
};

/// Shares of the sky on all large faces, each in a rectangle of its own.
struct SkyAtlas {
    static constexpr int width = 256;
    int height = 1;
    std::vector<float> open = std::vector<float>(width, 1.0f); ///< [height * width] 0..1
};

/// Instances drawn by one call: the same mesh and pattern.
struct RoundBatch {
    int mesh = 0;
    sim::Pattern pattern = sim::Pattern::plain;
    int first = 0; ///< index into DrawList::rounds
    int count = 0;
    int level = 0;            ///< of the finest: index into lathe_sides
    bool is_metal = false;    ///< one of them at least
    bool is_polished = false; ///< the same
};

/// Open share of the sky on a floor, around the bodies.
struct FloorOcclusion {
    int width = 1;
    int height = 1;
    std::vector<float> open{1.0f}; ///< [height * width] 0..1, rows along the floor's tangent
    glm::vec4 place{0.0f};         ///< texture coordinates = floor position * xy + zw
};

/// A plane body: its surface is drawn as a floor with a grid.
struct Floor {
    FloorFrame frame;      ///< origin: a point on it near what the camera looks at
    glm::vec2 grid_origin; ///< of the frame's origin in the grid, along tangent and across it [m]
    glm::vec3 color;       ///< linear RGB
    glm::vec3 line_color;  ///< linear RGB
    FloorRegion region;    ///< outside it the floor is in full light
    float ring_scale;      ///< the ring around it reaches this many times as far from its middle
    FloorOcclusion occlusion;
    std::uint32_t id;
};

struct DrawList {
    CameraBlock camera;
    PixelRect redrawn; ///< the rest of the picture is as in the first list that was made with this one
    PixelRect shadows_redrawn; ///< the same of the shadow map
    ShadowVolume shadow;
    std::vector<Instance> boxes;  ///< all boxes, for the shadow map; not what the camera sees
    std::vector<Instance> rounds; ///< grouped by batch, nearest first within one
    std::vector<RoundBatch> round_batches;
    std::vector<Face> faces; ///< grouped by batch, nearest first within one
    std::vector<FaceBatch> face_batches;
    SkyAtlas sky_atlas;
    std::vector<Floor> floors;
    std::vector<std::uint32_t> body_of_id{0}; ///< [id]: index of the body plus 1; 0: sky, or a joint's rod
    OcclusionVolume occlusion; ///< empty: all is open
    Mirrored mirrored;
};

/// Picture size and shadow map size, in pixels.
struct Viewport {
    int width = 0;
    int height = 0;
    int shadow_size = 0;
};

/// A view, for pictures of width / height `aspect`.
ViewPoint view_point(const View& view, double aspect);

/// What is drawn. camera: one of the scene's. Bodies whose pose is not finite are left out.
DrawList make_draw_list(const sim::SceneDef& scene, const SceneGeometry& geometry,
                        const sim::CameraDef& camera, const sim::Snapshot& snapshot,
                        const Viewport& viewport);

/// The same of several states that one picture shows, at least one. If the camera stands still, all but the first are
/// drawn anew only where they may differ.
std::vector<DrawList> make_draw_lists(const sim::SceneDef& scene, const SceneGeometry& geometry,
                                      const sim::CameraDef& camera, std::span<const sim::Snapshot> states,
                                      const Viewport& viewport);

} // namespace render
