#include "render/scene/geometry.h"

#include "render/scene/camera.h"
#include "sim/model/polytope.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace render {

namespace {

using sim::Vec3;

/// A floor fades into the sky over this many view distances.
constexpr double floor_extent_in_views = 14.0;
/// Cells of the occlusion volume across the smallest body, and cells of the whole volume at most.
constexpr double cells_across_body = 6.0;
constexpr double most_occlusion_cells = 2e5;

/// Light of a scene whose ground has the colour `floor`; without one the horizon's light comes from below
/// too.
LightBlock make_light(const sim::LightDef& light, const std::optional<glm::vec3>& floor) {
    LightBlock block{};
    block.to_sun = to_glm(Vec3(light.to_sun.normalized()));
    block.sun = to_glm(Vec3(light.sun_color * light.sun_intensity));
    block.sky_zenith = to_glm(Vec3(light.sky_zenith * light.sky_intensity));
    block.sky_horizon = to_glm(Vec3(light.sky_horizon * light.sky_intensity));
    block.ground = block.sky_horizon;
    if (floor) {
        // As ambient_irradiance of shaders/common_light.glsl for what looks up.
        const glm::vec3 mean_sky = 0.5f * (block.sky_zenith + block.sky_horizon);
        block.ground = *floor * (block.sun * std::max(block.to_sun.z, 0.0f) + mean_sky);
    }
    return block;
}

/// Cell of the occlusion volume: a share of the smallest moving body (of all bodies, if none moves), coarser
/// where the start fills much space; told from the scene alone, so that it is the same in all pictures.
float occlusion_cell(const sim::SceneDef& scene, double reach) {
    constexpr double none = std::numeric_limits<double>::max();
    double smallest_moving = none;
    double smallest = none;
    Vec3 lower = Vec3::Constant(none);
    Vec3 upper = Vec3::Constant(-none);
    for (const sim::BodyDef& body : scene.bodies) {
        const sim::Bounds bounds = sim::bounds(body.shape, body.pose);
        const Vec3 size = bounds.upper - bounds.lower;
        if (!size.allFinite() || !body.look.visible) {
            continue;
        }
        lower = lower.cwiseMin(bounds.lower);
        upper = upper.cwiseMax(bounds.upper);
        smallest = std::min(smallest, size.minCoeff());
        if (!body.is_static()) {
            smallest_moving = std::min(smallest_moving, size.minCoeff());
        }
    }
    if (smallest == none) {
        return static_cast<float>(reach);
    }
    const double body_size = smallest_moving == none ? smallest : smallest_moving;
    const Vec3 extent = (upper - lower).cwiseMax(body_size).cwiseMin(2.0 * reach);
    return static_cast<float>(
        std::max(body_size / cells_across_body, std::cbrt(extent.prod() / most_occlusion_cells)));
}

/// Index of a value in a list, to which it is added if it is new.
template <class T>
int place_of(const T& value, std::vector<T>& list) {
    const auto known = std::find(list.begin(), list.end(), value);
    const auto place = static_cast<int>(known - list.begin());
    if (known == list.end()) {
        list.push_back(value);
    }
    return place;
}

/// A cylinder (bend 0) or capsule: (radius, z) of its outline from bottom to top.
std::vector<glm::vec2> rod_outline(double radius, double half_length, double bend) {
    constexpr int segments = 16; // of a quarter circle: the outline stays within 0.12 % of the radius
    std::vector<glm::vec2> profile;
    for (const double end : {-1.0, 1.0}) {
        const int count = bend > 0.0 ? segments : 0;
        for (int i = 0; i <= count; ++i) {
            const int k = end < 0.0 ? count - i : i;
            const double angle = count > 0 ? 0.5 * std::numbers::pi * k / count : 0.0;
            profile.emplace_back(static_cast<float>(k == count && count > 0 ? 0.0 : radius * std::cos(angle)),
                                 static_cast<float>(end * (half_length + bend * std::sin(angle))));
        }
    }
    return profile;
}

/// Finds or makes the meshes of cylinders, capsules and hulls.
class PartMeshes {
public:
    explicit PartMeshes(SceneGeometry& geometry) : geometry_(geometry) {}

    std::vector<int> of_body(const sim::Shape& shape) {
        std::vector<int> meshes;
        std::visit(Overload{[&](const sim::Compound& compound) {
                                for (const sim::CompoundPart& part : compound.parts) {
                                    meshes.push_back(std::visit(
                                        [&](const auto& s) { return of_primitive(s); }, part.shape));
                                }
                            },
                            [&](const auto& primitive) { meshes.push_back(of_primitive(primitive)); }},
                   shape);
        return meshes;
    }

    /// Hulls come after all profiles, so their numbers are known last.
    void number_hulls() {
        for (std::vector<int>& meshes : geometry_.mesh_of_part) {
            for (int& mesh : meshes) {
                mesh = mesh < -1
                           ? mesh_id::lathe_first + static_cast<int>(geometry_.profiles.size()) - 2 - mesh
                           : mesh;
            }
        }
    }

private:
    template <class Primitive>
    int of_primitive(const Primitive&) {
        return -1;
    }
    int of_primitive(const sim::Cylinder& cylinder) {
        return mesh_id::lathe_first +
               place_of(rod_outline(cylinder.radius, cylinder.half_length, 0.0), geometry_.profiles);
    }
    int of_primitive(const sim::Capsule& capsule) {
        return mesh_id::lathe_first +
               place_of(rod_outline(capsule.radius, capsule.half_length, capsule.radius), geometry_.profiles);
    }
    int of_primitive(const sim::Hull& hull) {
        const int hull_index = place_of(hull.polytope.get(), polytopes_);
        if (static_cast<std::size_t>(hull_index) == geometry_.hulls.size()) {
            std::vector<HullFace> faces;
            for (const sim::Polytope::Face& face : hull.polytope->faces) {
                faces.push_back({to_glm(face.normal), {}});
                for (const int v : face.loop) {
                    faces.back().corners.push_back(
                        to_glm(hull.polytope->vertices[static_cast<std::size_t>(v)]));
                }
            }
            geometry_.hulls.push_back(std::move(faces));
        }
        return -2 - hull_index;
    }

    SceneGeometry& geometry_;
    std::vector<const sim::Polytope*> polytopes_;
};

} // namespace

SceneGeometry make_scene_geometry(const sim::SceneDef& scene, const sim::CameraDef& camera) {
    SceneGeometry geometry;
    for (const sim::BodyDef& body : scene.bodies) {
        geometry.profile_of_body.push_back(-1);
        if (body.look.lathe.size() < 2) {
            continue;
        }
        std::vector<glm::vec2> profile;
        for (const Eigen::Vector2d& point : body.look.lathe) {
            profile.emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()));
        }
        geometry.profile_of_body.back() = place_of(profile, geometry.profiles);
    }
    PartMeshes part_meshes(geometry);
    for (const sim::BodyDef& body : scene.bodies) {
        geometry.mesh_of_part.push_back(part_meshes.of_body(body.drawn_shape()));
    }
    part_meshes.number_hulls();
    geometry.group_count.assign(mesh_id::lathe_first, 1);
    geometry.group_count[mesh_id::rod] = make_lathe_bands(rod_profile()).back().group + 1;
    for (const std::vector<glm::vec2>& profile : geometry.profiles) {
        geometry.group_count.push_back(make_lathe_bands(profile).back().group + 1);
    }
    for (const std::vector<HullFace>& hull : geometry.hulls) {
        geometry.group_count.push_back(static_cast<std::uint32_t>(hull.size()));
    }
    const double scale = view_scale(camera);
    geometry.occlusion_cell = occlusion_cell(scene, scale);
    geometry.floor_extent = static_cast<float>(floor_extent_in_views * scale);
    geometry.grid_spacing = static_cast<float>(std::pow(10.0, std::floor(std::log10(scale / 5.0))));
    const auto floor = std::find_if(scene.bodies.begin(), scene.bodies.end(), [](const sim::BodyDef& body) {
        return body.look.visible && std::holds_alternative<sim::Plane>(body.shape);
    });
    if (floor == scene.bodies.end()) {
        geometry.light = make_light(scene.light, std::nullopt);
    } else {
        geometry.floor_color = to_glm(floor->look.color);
        const Vec3 normal = floor->pose.orientation * Vec3::UnitZ();
        geometry.floor_plane =
            glm::vec4(to_glm(normal), static_cast<float>(normal.dot(floor->pose.position)));
        geometry.light = make_light(scene.light, geometry.floor_color);
    }
    return geometry;
}

} // namespace render
