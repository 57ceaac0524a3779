#pragma once
/// The parts that bodies and joints are drawn as: scene and snapshot (Eigen, double) -> instances (GLM, float).
#include "render/scene/camera.h"
#include "render/scene/geometry.h"
#include "sim/model/snapshot.h"

#include <array>
#include <vector>

namespace render {

/// Sides of the polygons that bodies of revolution are drawn with, from coarse to fine.
inline constexpr std::array<int, 5> lathe_sides{16, 32, 48, 64, 80};

/// A placed part together with what sorts it.
struct Part {
    Instance instance;
    int mesh;  ///< mesh_id of a round part, -1 of a box
    int level; ///< of fineness, of a body of revolution: index into lathe_sides
    sim::Pattern pattern;
    float depth; ///< along the view [m]
    std::uint32_t body; ///< index plus 1; 0: of none, a joint's rod
};

/// Of all bodies and joints; planes are none.
struct Parts {
    std::vector<Part> boxes;  ///< nearest first
    std::vector<Part> rounds; ///< by mesh and pattern, nearest first within one
};

/// Radius of a joint's rod, in view_scale()s of the camera.
constexpr double rod_radius_in_views = 0.0014;

sim::LookDef rod_look();

/// Joints are drawn as rods of a radius [m]; pixels_per_radian: of the picture, for the fineness of spheres.
struct PartSetup {
    double rod_radius = 0.0;
    double pixels_per_radian = 0.0;
};

/// Bodies whose pose is not finite are left out.
Parts collect_parts(const sim::SceneDef& scene, const SceneGeometry& geometry, const sim::Snapshot& snapshot,
                    const View& view, const PartSetup& setup);

/// Appends points in the world [m] whose convex hull holds the part.
void append_points(const Part& part, const SceneGeometry& geometry, std::vector<glm::vec3>& points);

} // namespace render
