#pragma once
/// Where on a floor the bodies throw shadow or take sky away: a polygon with sides in sixteen fixed
/// directions.
#include "render/scene/draw_types.h"

#include <glm/glm.hpp>

#include <array>
#include <span>

namespace render {

/// With the sun lower than this over the floor (sine of the angle) shadows are long beyond use.
inline constexpr float least_sun_height = 0.1f;

/// A floor's own coordinates: along the tangent and across it, from the origin [m].
struct FloorFrame {
    glm::vec3 origin;  ///< [m]
    glm::vec3 normal;  ///< unit
    glm::vec3 tangent; ///< unit

    glm::vec3 across() const { return glm::cross(normal, tangent); }
    glm::vec2 place(const glm::vec3& point) const {
        return {glm::dot(point - origin, tangent), glm::dot(point - origin, across())};
    }
};

/// Corners, counter-clockwise, in floor coordinates [m].
using FloorRegion = std::array<glm::vec2, 16>;

/// What decides how far the bodies reach.
struct FloorRegionSetup {
    glm::vec3 to_sun;       ///< unit
    float shadow_margin;    ///< [m] width of the half shadow on a plane across the light
    float occlusion_margin; ///< [m] bodies nearer than that take sky from the floor, this far around them
    float most;             ///< [m] the region ends at this distance from the origin
};

/// Region that holds the shadows of bodies, and what they shade by being near; points: their convex hulls hold the
/// bodies [m]. The whole square of `most` if the sun is too low.
FloorRegion make_floor_region(const FloorFrame& floor, const FloorRegionSetup& setup, std::span<const glm::vec3> points);

} // namespace render
