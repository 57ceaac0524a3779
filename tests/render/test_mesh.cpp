#include "render/scene/mesh.h"

#include "render/scene/parts.h"
#include "sample_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace {

/// Volume enclosed by a mesh whose triangles turn outwards (divergence theorem).
double volume(const render::Mesh& mesh) {
    double sum = 0.0;
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a(mesh.vertices[mesh.indices[i]].position);
        const glm::dvec3 b(mesh.vertices[mesh.indices[i + 1]].position);
        const glm::dvec3 c(mesh.vertices[mesh.indices[i + 2]].position);
        sum += glm::dot(a, glm::cross(b, c)) / 6.0;
    }
    return sum;
}

/// Sum of the triangles' area vectors: zero for a closed surface.
glm::dvec3 open_area(const render::Mesh& mesh) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
        const glm::dvec3 a(mesh.vertices[mesh.indices[i]].position);
        const glm::dvec3 b(mesh.vertices[mesh.indices[i + 1]].position);
        const glm::dvec3 c(mesh.vertices[mesh.indices[i + 2]].position);
        sum += 0.5 * glm::cross(b - a, c - a);
    }
    return sum;
}

/// Area of a regular polygon of n corners on the unit circle.
double polygon_area(int n) {
    return 0.5 * n * std::sin(2.0 * std::numbers::pi / n);
}

} // namespace

TEST(mesh, sphere_is_closed_and_almost_as_large_as_it_should_be) {
    const render::Mesh mesh = render::make_sphere_mesh(32);
    EXPECT_LT(glm::length(open_area(mesh)), 1e-5);
    // An inscribed polyhedron: smaller by about (pi / 64)^2.
    const double exact = 4.0 / 3.0 * std::numbers::pi;
    EXPECT_LT(volume(mesh), exact);
    EXPECT_GT(volume(mesh), exact * (1.0 - 3.0 * std::pow(std::numbers::pi / 64.0, 2)));
    for (const render::Vertex& vertex : mesh.vertices) {
        EXPECT_NEAR(glm::length(vertex.position), 1.0f, 1e-6f);
        EXPECT_NEAR(glm::dot(vertex.position, vertex.normal), 1.0f, 1e-6f);
    }
}

TEST(mesh, lathe_closes_open_ends) {
    // A frustum from radius 2 at z = 0 to radius 1 at z = 3, given without its ends.
    const std::array<glm::vec2, 2> profile{glm::vec2(2, 0), glm::vec2(1, 3)};
    const render::Mesh mesh = render::make_lathe_mesh(profile, 24);
    EXPECT_LT(glm::length(open_area(mesh)), 1e-5);
    EXPECT_NEAR(volume(mesh), polygon_area(24) * 3.0 / 3.0 * (4.0 + 2.0 + 1.0), 1e-4);
}

TEST(mesh, lathe_edges_sharper_than_35_degrees_stay_edges) {
    const std::array<glm::vec2, 2> rod{glm::vec2(1, -1), glm::vec2(1, 1)};
    const std::vector<render::LatheBand> bands = render::make_lathe_bands(rod);
    ASSERT_EQ(bands.size(), 3u);
    EXPECT_EQ(bands[0].group, 0u);
    EXPECT_EQ(bands[1].group, 1u);
    EXPECT_EQ(bands[2].group, 2u);
    for (const render::Vertex& vertex : render::make_lathe_mesh(rod, 16).vertices) {
        const bool is_cap = vertex.group != 1;
        EXPECT_NEAR(std::abs(vertex.normal.z), is_cap ? 1.0f : 0.0f, 1e-6f);
    }
    // A ball from 20 points is one smooth surface.
    std::vector<glm::vec2> ball;
    for (int i = 0; i <= 20; ++i) {
        const double angle = std::numbers::pi * i / 20;
        ball.emplace_back(std::sin(angle) < 1e-9 ? 0.0 : std::sin(angle), -std::cos(angle));
    }
    EXPECT_EQ(render::make_lathe_bands(ball).back().group, 0u);
}

TEST(mesh, hull_has_flat_faces_of_their_own_groups) {
    // A tetrahedron: volume 1/6.
    const glm::vec3 o(0.0f), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    const std::array<render::HullFace, 4> faces{{{-z, {o, y, x}},
                                                 {-y, {o, x, z}},
                                                 {-x, {o, z, y}},
                                                 {glm::normalize(x + y + z), {x, y, z}}}};
    const render::Mesh mesh = render::make_hull_mesh(faces);
    EXPECT_LT(glm::length(open_area(mesh)), 1e-6);
    EXPECT_NEAR(volume(mesh), 1.0 / 6.0, 1e-6);
    ASSERT_EQ(mesh.vertices.size(), 12u);
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
        EXPECT_EQ(mesh.vertices[i].group, i / 3);
        EXPECT_EQ(mesh.vertices[i].normal, faces[i / 3].normal);
    }
}

TEST(mesh, points_of_a_part_enclose_its_mesh) {
    render::SceneGeometry geometry;
    geometry.profiles = {{{0.0f, -1.0f}, {0.7f, -0.4f}, {0.2f, 0.9f}}};
    const std::array<render::Mesh, 2> meshes{render::make_sphere_mesh(32), render::make_lathe_mesh(geometry.profiles[0], 80)};
    const std::array<int, 2> ids{render::mesh_id::sphere_first, render::mesh_id::lathe_first};
    for (std::size_t i = 0; i < meshes.size(); ++i) {
        render::Part part{};
        part.mesh = ids[i];
        part.instance.orientation = {0, 0, 0, 1};
        part.instance.scale = glm::vec3(1.0f);
        std::vector<glm::vec3> points;
        render::append_points(part, geometry, points);
        for (int k = 0; k < 64; ++k) {
            const glm::vec3 direction(std::sin(1.7f * k), std::cos(2.3f * k), std::sin(0.9f * k));
            float reach = -1e9f;
            for (const glm::vec3& point : points) {
                reach = std::max(reach, glm::dot(point, direction));
            }
            for (const render::Vertex& vertex : meshes[i].vertices) {
                ASSERT_LE(glm::dot(vertex.position, direction), reach + 1e-5f) << i;
            }
        }
    }
}

// Parts of a third of a pixel, where the radius is told in pixels.
TEST(mesh, cylinders_have_as_many_sides_as_their_size_on_the_picture_asks_for) {
    sim::SceneDef scene;
    scene.bodies.push_back(sample::body(sim::Cylinder{1.0, 1.0}, {}, {0.5, 0.5, 0.5}));
    sample::set_camera(scene, {0, -10, 0}, {0, 0, 0}, 40);
    const render::SceneGeometry geometry = render::make_scene_geometry(scene, scene.cameras.at(0));
    for (const auto& [pixels, sides] : {std::pair{10.0, 16}, {50.0, 32}, {100.0, 48}, {200.0, 64}, {2000.0, 80}}) {
        const render::View view{{0, -10, 0}, {0, 0, 0}, 40};
        const render::Parts parts =
            render::collect_parts(scene, geometry, sample::start(scene), view, {.pixels_per_radian = 10.0 * pixels});
        EXPECT_EQ(render::lathe_sides[static_cast<std::size_t>(parts.rounds.at(0).level)], sides);
        EXPECT_TRUE(sides == 80 || pixels * (1.0 - std::cos(std::numbers::pi / sides)) < 0.36);
    }
}
