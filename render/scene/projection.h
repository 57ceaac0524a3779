#pragma once
/// The two views of a picture: the camera's perspective and the sun's parallel one.
#include "render/scene/draw_types.h"

#include <glm/glm.hpp>

#include <span>

namespace render {

/// Where a camera stands, in GLM.
struct ViewPoint {
    glm::dvec3 eye;     ///< [m]
    glm::dvec3 target;  ///< [m]
    double fov_degrees; ///< vertical
    double aspect;      ///< width / height
};

/// Distances along the view direction [m].
struct DepthRange {
    double near;
    double far;
};

/// Range that holds all instances, and floors up to `extent` [m] if there are any.
DepthRange depth_range(const ViewPoint& view, std::span<const Instance> instances, double extent,
                       bool has_floor);

CameraBlock make_camera(const ViewPoint& view, const DepthRange& range);

/// True if no point within `radius` of `center` can be in the picture.
bool is_outside(const CameraBlock& camera, const glm::vec3& center, float radius);

/// What throws shadows.
struct ShadowSetup {
    glm::dvec3 to_sun;    ///< unit
    glm::dvec3 target;    ///< what the camera looks at [m]
    double view_distance; ///< [m] from the eye to the target
    double
        reach_in_views; ///< instances farther from the target than this many view distances throw no shadow
    double margin;      ///< [m] kept free around them
    int map_size;       ///< [px]
    double least_texel; ///< [m] texels are not smaller: half shadows are four texels wide
};

/// Volume that holds all instances within reach. It changes its size in steps and its place by whole texels,
/// so that shadow edges do not crawl while bodies move.
ShadowVolume make_shadow_volume(const ShadowSetup& setup, std::span<const Instance> instances);

} // namespace render
