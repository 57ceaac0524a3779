#pragma once
/// Triangles of the shapes that are drawn, in the unit size that an instance scales.
#include "render/scene/draw_types.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace render {

struct Vertex {
    glm::vec3 position;  ///< [-] or [m], as the mesh says
    glm::vec3 normal;    ///< unit, outwards
    std::uint32_t group; ///< surfaces that meet in an edge have different groups, 0..
    /// Of a hull's corner with three faces, for its shadow: their normals, and a place half way to the hull's middle.
    std::array<glm::vec3, 3> faces{};
    glm::vec3 inside{0.0f};
};

/// One band of a surface of revolution: from (radius, z) `lower` to `upper`.
struct LatheBand {
    glm::vec2 lower;
    glm::vec2 upper;
    std::uint32_t group; ///< bands that meet smoothly share one
};

/// Bands from bottom to top of a profile of (radius, z), at least two points; open ends are capped. Two bands
/// meet smoothly unless the profile turns by more than 35 degrees.
std::vector<LatheBand> make_lathe_bands(std::span<const glm::vec2> profile);

/// The profile of the unit rod: radius 1 about z, from z = -1 to z = 1.
std::span<const glm::vec2> rod_profile();

/// A flat face of a convex body.
struct HullFace {
    glm::vec3 normal;               ///< unit, outwards
    std::vector<glm::vec3> corners; ///< counter-clockwise seen from outside
};

/// Closed surface, counter-clockwise seen from outside.
struct Mesh {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices; ///< [3 * triangle_count]
};

/// Radius 1; `rings` >= 2 from pole to pole, 2 * rings around.
Mesh make_sphere_mesh(int rings);

/// Surface of revolution about z. `sides` >= 3.
Mesh make_lathe_mesh(std::span<const glm::vec2> profile, int sides);

/// Each face is a group.
Mesh make_hull_mesh(std::span<const HullFace> faces);

/// Triangles of the three sides of each box that look away from the sun; vertex 8 i + k is corner k of box i,
/// at x, y, z = +-1 by the bits 1, 2, 4 of k.
std::vector<std::uint32_t> sides_away_from(const glm::vec3& to_sun, std::span<const Instance> boxes);

} // namespace render
