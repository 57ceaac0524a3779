#include "render/scene/mesh.h"

#include "sim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace render {

namespace {

/// A profile that turns by more than this keeps its edge. cos(35 degrees).
constexpr float crease_cosine = 0.819f;

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
void append_band(Mesh& mesh, const ProfilePoint& lower, const ProfilePoint& upper, std::uint32_t group,
                 std::span<const glm::vec2> around) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const glm::vec2& d : around) {
        for (const ProfilePoint* point : {&lower, &upper}) {
            const glm::vec2& n = point->normal;
            mesh.vertices.push_back({{d * point->position.x, point->position.y}, {d * n.x, n.y}, group});
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

/// Outward normal (radial, z) of a band.
glm::vec2 band_normal(const LatheBand& band) {
    const glm::vec2 along = glm::normalize(band.upper - band.lower);
    return {along.y, -along.x};
}

/// Fills in what the shadow asks of the corners with three faces.
void add_corners(std::span<const HullFace> faces, Mesh& mesh) {
    glm::vec3 middle(0.0f);
    for (const Vertex& vertex : mesh.vertices) {
        middle += vertex.position / static_cast<float>(mesh.vertices.size());
    }
    for (Vertex& vertex : mesh.vertices) {
        std::vector<glm::vec3> normals;
        for (const HullFace& face : faces) {
            if (std::ranges::find(face.corners, vertex.position) != face.corners.end()) {
                normals.push_back(face.normal);
            }
        }
        if (normals.size() == vertex.faces.size()) {
            std::ranges::copy(normals, vertex.faces.begin());
            vertex.inside = 0.5f * (vertex.position + middle);
        }
    }
}

} // namespace

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
        append_band(mesh, point(ring), point(ring + 1), 0, around);
    }
    return mesh;
}

std::vector<LatheBand> make_lathe_bands(std::span<const glm::vec2> profile) {
    CHECK(profile.size() >= 2);
    const std::vector<glm::vec2> points = closed_profile(profile);
    std::vector<LatheBand> bands;
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
        LatheBand band{points[i], points[i + 1], 0};
        if (!bands.empty()) {
            const LatheBand& last = bands.back();
            const bool is_smooth = glm::dot(band_normal(last), band_normal(band)) >= crease_cosine;
            band.group = last.group + (is_smooth ? 0 : 1);
        }
        bands.push_back(band);
    }
    return bands;
}

std::span<const glm::vec2> rod_profile() {
    static constexpr glm::vec2 profile[] = {{1.0f, -1.0f}, {1.0f, 1.0f}};
    return profile;
}

Mesh make_lathe_mesh(std::span<const glm::vec2> profile, int sides) {
    CHECK(sides >= 3);
    const std::vector<LatheBand> bands = make_lathe_bands(profile);
    const std::vector<glm::vec2> around = circle(sides);
    // Two bands of one group share the mean normal at their common point.
    const auto normal_towards = [&](std::size_t own, std::size_t other) {
        if (other >= bands.size() || bands[own].group != bands[other].group) {
            return band_normal(bands[own]);
        }
        return glm::normalize(band_normal(bands[own]) + band_normal(bands[other]));
    };
    Mesh mesh;
    for (std::size_t i = 0; i < bands.size(); ++i) {
        append_band(mesh, {bands[i].lower, normal_towards(i, i - 1)},
                    {bands[i].upper, normal_towards(i, i + 1)}, bands[i].group, around);
    }
    return mesh;
}

Mesh make_hull_mesh(std::span<const HullFace> faces) {
    Mesh mesh;
    for (std::uint32_t group = 0; group < faces.size(); ++group) {
        const HullFace& face = faces[group];
        const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
        for (const glm::vec3& corner : face.corners) {
            mesh.vertices.push_back({corner, face.normal, group});
        }
        for (std::uint32_t i = 1; i + 1 < face.corners.size(); ++i) {
            mesh.indices.insert(mesh.indices.end(), {first, first + i, first + i + 1});
        }
    }
    add_corners(faces, mesh);
    return mesh;
}

std::vector<std::uint32_t> sides_away_from(const glm::vec3& to_sun, std::span<const Instance> boxes) {
    using Side = std::array<std::uint32_t, 4>; // around it
    constexpr std::array<std::array<Side, 2>, 3> sides{
        {{{{0, 4, 6, 2}, {1, 3, 7, 5}}}, {{{0, 1, 5, 4}, {2, 6, 7, 3}}}, {{{0, 2, 3, 1}, {4, 5, 7, 6}}}}};
    std::vector<std::uint32_t> indices;
    indices.reserve(boxes.size() * 18);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        const glm::vec3 sun = turned_back(boxes[i].orientation, to_sun);
        const glm::ivec3 is_away(glm::lessThanEqual(sun, glm::vec3(0.0f)));
        const auto far_corner = static_cast<std::uint32_t>(is_away.x + 2 * is_away.y + 4 * is_away.z);
        for (int axis = 0; axis < 3; ++axis) {
            const Side& side = sides[static_cast<std::size_t>(axis)][static_cast<std::size_t>(is_away[axis])];
            const auto at = static_cast<std::size_t>(std::ranges::find(side, far_corner) - side.begin());
            for (const std::size_t k : {0, 1, 2, 0, 2, 3}) {
                indices.push_back(static_cast<std::uint32_t>(8 * i) + side[(at + k) % 4]);
            }
        }
    }
    return indices;
}

} // namespace render
