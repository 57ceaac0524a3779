#include "render/mesh.h"

#include "sim/error.h"

#include <cmath>
#include <numbers>

namespace render {

namespace {

/// A profile that turns by more than this keeps its edge. cos(35 degrees).
constexpr float crease_cosine = 0.819f;

void append_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c, a, c, d});
}

/// One face of a box: normal along `axis` with sign `side`.
void append_box_face(Mesh& mesh, int axis, float side, int cells) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    const int u = (axis + 1) % 3;
    const int v = (axis + 2) % 3;
    glm::vec3 normal(0.0f);
    normal[axis] = side;
    for (int j = 0; j <= cells; ++j) {
        for (int i = 0; i <= cells; ++i) {
            glm::vec3 position(0.0f);
            position[axis] = side;
            position[u] = (2.0f * static_cast<float>(i) / static_cast<float>(cells) - 1.0f) * side;
            position[v] = 2.0f * static_cast<float>(j) / static_cast<float>(cells) - 1.0f;
            mesh.vertices.push_back({position, normal});
        }
    }
    const auto row = static_cast<std::uint32_t>(cells + 1);
    for (std::uint32_t j = 0; j + 1 < row; ++j) {
        for (std::uint32_t i = 0; i + 1 < row; ++i) {
            const std::uint32_t at = first + j * row + i;
            append_quad(mesh, at, at + 1, at + row + 1, at + row);
        }
    }
}

/// Unit circle; the last point repeats the first exactly.
std::vector<glm::vec2> circle(int sides) {
    std::vector<glm::vec2> points;
    for (int i = 0; i < sides; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / sides;
        points.emplace_back(std::cos(angle), std::sin(angle));
    }
    points.push_back(points.front());
    return points;
}

/// One point of a profile and the outward normal (radial, z) it has on one of its segments.
struct ProfilePoint {
    glm::vec2 position;
    glm::vec2 normal;
};

/// The band between two profile points, lower first; triangles of no area at the axis are left out.
void append_band(Mesh& mesh, const ProfilePoint& lower, const ProfilePoint& upper,
                 std::span<const glm::vec2> around) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const glm::vec2& d : around) {
        for (const ProfilePoint* point : {&lower, &upper}) {
            const glm::vec2& n = point->normal;
            mesh.vertices.push_back({{d * point->position.x, point->position.y}, {d * n.x, n.y}});
        }
    }
    for (std::uint32_t i = 0; i + 1 < around.size(); ++i) {
        const std::uint32_t at = first + 2 * i;
        if (lower.position.x > 0.0f) {
            mesh.indices.insert(mesh.indices.end(), {at, at + 2, at + 1});
        }
        if (upper.position.x > 0.0f) {
            mesh.indices.insert(mesh.indices.end(), {at + 1, at + 2, at + 3});
        }
    }
}

/// Profile with both ends on the axis and no repeated points.
std::vector<glm::vec2> closed_profile(std::span<const glm::vec2> profile) {
    std::vector<glm::vec2> points;
    const auto append = [&points](const glm::vec2& point) {
        if (points.empty() || points.back() != point) {
            points.push_back(point);
        }
    };
    append({0.0f, profile.front().y});
    for (const glm::vec2& point : profile) {
        append(point);
    }
    append({0.0f, profile.back().y});
    return points;
}

/// Outward normal of the segment from a to b.
glm::vec2 segment_normal(const glm::vec2& a, const glm::vec2& b) {
    const glm::vec2 along = glm::normalize(b - a);
    return {along.y, -along.x};
}

} // namespace

Mesh make_box_mesh(int cells) {
    CHECK(cells >= 1);
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        append_box_face(mesh, axis, 1.0f, cells);
        append_box_face(mesh, axis, -1.0f, cells);
    }
    return mesh;
}

Mesh make_sphere_mesh(int rings) {
    CHECK(rings >= 2);
    const std::vector<glm::vec2> around = circle(2 * rings);
    Mesh mesh;
    for (int ring = 0; ring < rings; ++ring) {
        const auto point = [&](int i) {
            const double angle = std::numbers::pi * i / rings;
            const float radius = i == 0 || i == rings ? 0.0f : static_cast<float>(std::sin(angle));
            const glm::vec2 p(radius, static_cast<float>(-std::cos(angle)));
            return ProfilePoint{p, p};
        };
        append_band(mesh, point(ring), point(ring + 1), around);
    }
    return mesh;
}

Mesh make_cylinder_mesh(int sides) {
    const std::vector<glm::vec2> profile{{1.0f, -1.0f}, {1.0f, 1.0f}};
    return make_lathe_mesh(profile, sides);
}

Mesh make_lathe_mesh(std::span<const glm::vec2> profile, int sides) {
    CHECK(profile.size() >= 2 && sides >= 3);
    const std::vector<glm::vec2> points = closed_profile(profile);
    const std::vector<glm::vec2> around = circle(sides);
    std::vector<glm::vec2> normals;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        normals.push_back(segment_normal(points[i], points[i + 1]));
    }
    // Two segments that meet smoothly share the mean normal at their common point.
    const auto smooth_normal = [&](std::size_t own, std::size_t other) {
        if (other >= normals.size() || glm::dot(normals[own], normals[other]) < crease_cosine) {
            return normals[own];
        }
        return glm::normalize(normals[own] + normals[other]);
    };
    Mesh mesh;
    for (std::size_t i = 0; i < normals.size(); ++i) {
        append_band(mesh, {points[i], smooth_normal(i, i - 1)}, {points[i + 1], smooth_normal(i, i + 1)},
                    around);
    }
    return mesh;
}

} // namespace render
