#pragma once
/// Triangles of the shapes that are drawn, in the unit size that an instance scales.
#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace render {

struct Vertex {
    glm::vec3 position; ///< [-] or [m], as the mesh says
    glm::vec3 normal;   ///< unit, outwards
};

/// Closed surface, counter-clockwise seen from outside.
struct Mesh {
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices; ///< [3 * triangle_count]
};

/// Corners at +-1; each face divided into `cells` x `cells` quads, cells >= 1.
Mesh make_box_mesh(int cells = 1);

/// Radius 1; `rings` >= 2 from pole to pole, 2 * rings around.
Mesh make_sphere_mesh(int rings);

/// Radius 1 about z, from z = -1 to z = 1, with end caps; `sides` >= 3.
Mesh make_cylinder_mesh(int sides);

/// Surface of revolution about z: profile of (radius, z) [m] from bottom to top, at least two points; open
/// ends are capped. Smooth except where the profile turns by more than 35 degrees. `sides` >= 3.
Mesh make_lathe_mesh(std::span<const glm::vec2> profile, int sides);

} // namespace render
