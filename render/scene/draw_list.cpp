#include "render/scene/draw_list.h"

#include "render/scene/faces.h"
#include "sim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

namespace render {

namespace {

using sim::Pose;
using sim::Vec3;

/// What lies farther from the target than this many view distances throws no shadow.
constexpr double reach_in_views = 3.0;
/// Shadow texels are not smaller than this many view distances.
constexpr double least_texel_in_views = 0.0009;
/// Cells that the occlusion volume reaches beyond the bodies.
constexpr float occlusion_margin_cells = 4.0f;

glm::dvec3 to_glm_double(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

/// Floors of all visible plane bodies; what lies around them is filled in later.
std::vector<Floor> make_floors(const sim::SceneDef& scene, const sim::Snapshot& snapshot, const View& view) {
    std::vector<Floor> floors;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const sim::BodyDef& body = scene.bodies[i];
        if (!body.look.visible || !std::holds_alternative<sim::Plane>(body.shape)) {
            continue;
        }
        const Pose pose{snapshot.bodies[i].position, snapshot.bodies[i].orientation};
        const Vec3 normal = pose.orientation * Vec3::UnitZ();
        const Vec3 tangent = pose.orientation * Vec3::UnitX();
        const Vec3 across = normal.cross(tangent);
        // The lines are counted from the body's origin, but told from a point near the view: floats suffice
        // there.
        const Vec3 near = view.target - normal * (view.target - pose.position).dot(normal);
        Floor floor{};
        floor.frame = {to_glm(near), to_glm(normal), to_glm(tangent)};
        floor.grid_origin = {static_cast<float>((near - pose.position).dot(tangent)),
                             static_cast<float>((near - pose.position).dot(across))};
        floor.color = to_glm(body.look.color);
        floor.line_color = to_glm(body.look.pattern_color);
        floor.id = static_cast<std::uint32_t>(i + 1); // of the body, until the parts are numbered
        floors.push_back(floor);
    }
    return floors;
}

OcclusionVolume make_occlusion(const SceneGeometry& geometry, const Parts& parts,
                               const std::vector<Floor>& floors, const glm::vec3& target, float reach) {
    glm::vec3 lower(std::numeric_limits<float>::max());
    glm::vec3 upper(std::numeric_limits<float>::lowest());
    const auto include = [&](const Part& part) {
        const float radius = part.instance.bounding_radius;
        if (glm::length(part.instance.position - target) < reach && part.mesh != mesh_id::rod) {
            lower = glm::min(lower, part.instance.position - radius);
            upper = glm::max(upper, part.instance.position + radius);
        }
    };
    std::for_each(parts.boxes.begin(), parts.boxes.end(), include);
    std::for_each(parts.rounds.begin(), parts.rounds.end(), include);
    if (lower.x > upper.x) {
        return {};
    }
    const float cell = geometry.occlusion_cell;
    OcclusionVolume volume(glm::max(lower, target - reach) - occlusion_margin_cells * cell,
                           glm::min(upper, target + reach) + occlusion_margin_cells * cell, cell);
    for (const Part& part : parts.boxes) {
        volume.add_box(part.instance);
    }
    for (const Part& part : parts.rounds) {
        const auto own = static_cast<std::size_t>(part.mesh - mesh_id::lathe_first);
        if (part.mesh >= mesh_id::lathe_first && own < geometry.profiles.size()) {
            volume.add_lathe(part.instance, geometry.profiles[own]);
        } else if (part.mesh >= mesh_id::lathe_first) {
            volume.add_hull(part.instance, geometry.hulls[own - geometry.profiles.size()]);
        } else if (part.mesh != mesh_id::rod) {
            volume.add_ellipsoid(part.instance);
        }
    }
    for (const Floor& floor : floors) {
        volume.add_half_space(floor.frame.origin, floor.frame.normal);
    }
    volume.finish();
    return volume;
}

/// Rounds in batches, with ids that follow those of the faces.
void fill_rounds(const std::vector<Part>& parts, const SceneGeometry& geometry, DrawList& list) {
    auto next_id = static_cast<std::uint32_t>(list.faces.size() + 1);
    for (const Part& part : parts) {
        std::vector<RoundBatch>& batches = list.round_batches;
        if (batches.empty() || batches.back().mesh != part.mesh || batches.back().pattern != part.pattern) {
            batches.push_back({part.mesh, part.pattern, static_cast<int>(list.rounds.size()), 0});
        }
        ++batches.back().count;
        batches.back().is_polished |= is_polished(part);
        list.rounds.push_back(part.instance);
        list.rounds.back().id = next_id;
        const std::uint32_t groups = geometry.group_count[static_cast<std::size_t>(part.mesh)];
        list.body_of_id.insert(list.body_of_id.end(), groups, part.body);
        next_id += groups;
    }
    for (Floor& floor : list.floors) {
        list.body_of_id.push_back(floor.id);
        floor.id = next_id++;
    }
}

/// How far a ring around a region reaches, in sizes of the region, so that it ends beyond the horizon.
float ring_scale(const FloorRegion& region, float extent) {
    glm::vec2 middle(0.0f);
    for (const glm::vec2& corner : region) {
        middle += corner / static_cast<float>(region.size());
    }
    float inner_radius = std::numeric_limits<float>::max();
    for (std::size_t i = 0; i < region.size(); ++i) {
        const glm::vec2 side = region[(i + 1) % region.size()] - region[i];
        const glm::vec2 to_middle = middle - region[i];
        const float length = glm::length(side);
        if (length > 0.0f) {
            inner_radius =
                std::min(inner_radius, std::abs(side.x * to_middle.y - side.y * to_middle.x) / length);
        }
    }
    return 4.0f * extent / inner_radius;
}

FloorOcclusion floor_occlusion(const Floor& floor, const OcclusionVolume& volume) {
    FloorOcclusion result;
    if (volume.is_empty()) {
        return result;
    }
    glm::vec2 lower(std::numeric_limits<float>::max());
    glm::vec2 upper(std::numeric_limits<float>::lowest());
    for (int i = 0; i < 8; ++i) {
        const glm::vec3 share(i & 1, (i >> 1) & 1, (i >> 2) & 1);
        const glm::vec2 p = floor.frame.place(glm::mix(volume.lower(), volume.upper(), share));
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    // Points are multiples of the cell, so that the values on the floor do not wander with the volume.
    const glm::vec2 first =
        glm::floor((lower + floor.grid_origin) / volume.cell()) * volume.cell() - floor.grid_origin;
    const glm::ivec2 size = glm::clamp(glm::ivec2((upper - first) / volume.cell()) + 2, glm::ivec2(1),
                                       glm::ivec2(2 * OcclusionVolume::most_cells));
    result.width = size.x;
    result.height = size.y;
    result.open.clear();
    const glm::vec3 across = floor.frame.across();
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; x += 4) {
            std::array<glm::vec3, 4> points;
            for (int k = 0; k < 4; ++k) {
                const glm::vec2 p = first + (glm::vec2(x + k, y) + 0.5f) * volume.cell();
                points[static_cast<std::size_t>(k)] =
                    floor.frame.origin + floor.frame.tangent * p.x + across * p.y;
            }
            const std::array<float, 4> open = volume.open_shares(points, floor.frame.normal);
            result.open.insert(result.open.end(), open.begin(), open.begin() + std::min(4, size.x - x));
        }
    }
    const glm::vec2 scale = 1.0f / (glm::vec2(size) * volume.cell());
    result.place = glm::vec4(scale, -first * scale);
    return result;
}

} // namespace

DrawList make_draw_list(const sim::SceneDef& scene, const SceneGeometry& geometry,
                        const sim::CameraDef& camera, const sim::Snapshot& snapshot,
                        const Viewport& viewport) {
    CHECK(snapshot.bodies.size() == scene.bodies.size());
    const double aspect = static_cast<double>(viewport.width) / viewport.height;
    const View view = camera_view(camera, snapshot, aspect);
    const ViewPoint view_point{to_glm_double(view.eye), to_glm_double(view.target), view.fov_degrees, aspect};
    const double scale = view_scale(camera);
    const auto extent = static_cast<double>(geometry.floor_extent);

    const Parts parts = collect_parts(
        scene, geometry, snapshot, view,
        {rod_radius_in_views * scale, viewport.height / (2.0 * std::tan(0.5 * glm::radians(view.fov_degrees)))});

    DrawList list;
    list.floors = make_floors(scene, snapshot, view);

    std::vector<Instance> all;
    for (const std::vector<Part>* group : {&parts.boxes, &parts.rounds}) {
        for (const Part& part : *group) {
            all.push_back(part.instance);
        }
    }
    list.boxes.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(parts.boxes.size()));
    const std::span<const Instance> rounds = std::span<const Instance>(all).subspan(parts.boxes.size());
    list.camera = make_camera(view_point, depth_range(view_point, all, extent, !list.floors.empty()));
    const double margin = static_cast<double>(occlusion_margin_cells * geometry.occlusion_cell);
    list.shadow =
        make_shadow_volume({glm::dvec3(geometry.light.to_sun), view_point.target, scale, reach_in_views,
                            margin, viewport.shadow_size, least_texel_in_views * scale},
                           all);
    const float occlusion_reach = 2.0f * occlusion_margin_cells * geometry.occlusion_cell;
    const FloorRegionSetup region{geometry.light.to_sun, 3.0f * list.shadow.texel_size, occlusion_reach,
                                  2.0f * geometry.floor_extent};
    for (Floor& floor : list.floors) {
        floor.region = make_floor_region(floor.frame, region, list.boxes, rounds);
        floor.ring_scale = ring_scale(floor.region, geometry.floor_extent);
    }
    if (scene.output.ambient_occlusion) {
        list.occlusion =
            make_occlusion(geometry, parts, list.floors, glm::vec3(view_point.target), static_cast<float>(scale));
    }
    for (Floor& floor : list.floors) {
        floor.occlusion = floor_occlusion(floor, list.occlusion);
    }
    add_faces(parts.boxes, geometry, list);
    fill_rounds(parts.rounds, geometry, list);
    list.mirrored = find_mirrored(parts);
    return list;
}

} // namespace render
