#include "render/scene/draw_list.h"

#include "render/scene/changed.h"
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

/// What bodies fill, the target's surroundings only.
struct Filled {
    glm::vec3 lower{std::numeric_limits<float>::max()};
    glm::vec3 upper{std::numeric_limits<float>::lowest()};
    glm::vec3 target;
    float reach;

    void include(const Part& part) {
        const float radius = part.instance.bounding_radius;
        if (glm::length(part.instance.position - target) < reach && part.mesh != mesh_id::rod) {
            lower = glm::min(lower, part.instance.position - radius);
            upper = glm::max(upper, part.instance.position + radius);
        }
    }
};

OcclusionVolume make_occlusion(const SceneGeometry& geometry, const Parts& parts,
                               const std::vector<Floor>& floors, const Filled& filled) {
    if (filled.lower.x > filled.upper.x) {
        return {};
    }
    const float cell = geometry.occlusion_cell;
    OcclusionVolume volume(
        glm::max(filled.lower, filled.target - filled.reach) - occlusion_margin_cells * cell,
        glm::min(filled.upper, filled.target + filled.reach) + occlusion_margin_cells * cell, cell);
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
        batches.back().is_metal |= part.instance.metallic > 0.0f;
        batches.back().is_polished |= is_polished(part);
        batches.back().level = std::max(batches.back().level, part.level);
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
    // Points are multiples of their distance, so that the values on the floor do not wander with the volume.
    const float distance = volume.point_distance();
    const glm::vec2 first = glm::floor((lower + floor.grid_origin) / distance) * distance - floor.grid_origin;
    const glm::ivec2 size = glm::clamp(glm::ivec2((upper - first) / distance) + 2, glm::ivec2(1),
                                       glm::ivec2(2 * OcclusionVolume::most_cells));
    result.width = size.x;
    result.height = size.y;
    result.open.clear();
    const glm::vec3 across = floor.frame.across();
    for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; x += 4) {
            std::array<glm::vec3, 4> points;
            for (int k = 0; k < 4; ++k) {
                const glm::vec2 p = first + (glm::vec2(x + k, y) + 0.5f) * distance;
                points[static_cast<std::size_t>(k)] =
                    floor.frame.origin + floor.frame.tangent * p.x + across * p.y;
            }
            const std::array<float, 4> open = volume.open_shares(points, floor.frame.normal);
            result.open.insert(result.open.end(), open.begin(), open.begin() + std::min(4, size.x - x));
        }
    }
    const glm::vec2 scale = 1.0f / (glm::vec2(size) * distance);
    result.place = glm::vec4(scale, -first * scale);
    return result;
}

/// A view, and the states that it shows.
struct Shown {
    const sim::SceneDef& scene;
    const SceneGeometry& geometry;
    View view;
    double scale; ///< [m] of the picture: view_scale() of the camera
    std::span<const sim::Snapshot> states;
};

std::vector<Parts> parts_of(const Shown& shown, const Viewport& viewport) {
    const PartSetup setup{rod_radius_in_views * shown.scale,
                          viewport.height / (2.0 * std::tan(0.5 * glm::radians(shown.view.fov_degrees)))};
    std::vector<Parts> parts;
    for (const sim::Snapshot& state : shown.states) {
        parts.push_back(collect_parts(shown.scene, shown.geometry, state, shown.view, setup));
    }
    return parts;
}

/// Camera, sun's view and floors, such that they do for the parts of all states; the filled part of space.
DrawList common_list(const Shown& shown, const std::vector<Parts>& parts, const Viewport& viewport, Filled& filled) {
    const SceneGeometry& geometry = shown.geometry;
    std::vector<Instance> all;
    std::vector<glm::vec3> points;
    for (const Parts& state : parts) {
        for (const std::vector<Part>* group : {&state.boxes, &state.rounds}) {
            for (const Part& part : *group) {
                all.push_back(part.instance);
                append_points(part, geometry, points);
                filled.include(part);
            }
        }
    }

    DrawList list;
    list.redrawn = {0, 0, viewport.width, viewport.height};
    list.shadows_redrawn = {0, 0, viewport.shadow_size, viewport.shadow_size};
    list.floors = make_floors(shown.scene, shown.states.front(), shown.view);
    const ViewPoint point = view_point(shown.view, static_cast<double>(viewport.width) / viewport.height);
    const auto extent = static_cast<double>(geometry.floor_extent);
    list.camera = make_camera(point, depth_range(point, all, extent, !list.floors.empty()));
    const double margin = static_cast<double>(occlusion_margin_cells * geometry.occlusion_cell);
    list.shadow =
        make_shadow_volume({glm::dvec3(geometry.light.to_sun), point.target, shown.scale, reach_in_views,
                            margin, viewport.shadow_size, least_texel_in_views * shown.scale},
                           all);
    const float occlusion_reach = 2.0f * occlusion_margin_cells * geometry.occlusion_cell;
    const FloorRegionSetup region{geometry.light.to_sun, 3.0f * list.shadow.texel_size, occlusion_reach,
                                  2.0f * geometry.floor_extent};
    for (Floor& floor : list.floors) {
        floor.region = make_floor_region(floor.frame, region, points);
        floor.ring_scale = ring_scale(floor.region, geometry.floor_extent);
    }
    return list;
}

/// Adds one state's parts to what it has in common with the others.
void add_state(const Shown& shown, const Parts& parts, const Filled& filled, DrawList& list) {
    list.boxes.reserve(parts.boxes.size());
    for (const Part& part : parts.boxes) {
        list.boxes.push_back(part.instance);
    }
    if (shown.scene.output.ambient_occlusion) {
        list.occlusion = make_occlusion(shown.geometry, parts, list.floors, filled);
    }
    for (Floor& floor : list.floors) {
        floor.occlusion = floor_occlusion(floor, list.occlusion);
    }
    add_faces(parts.boxes, shown.geometry, list);
    fill_rounds(parts.rounds, shown.geometry, list);
    list.mirrored = find_mirrored(parts, shown.scene);
}

/// Whether bodies are not where, or not there as, they are in the first state: [body + 1]; [0]: of joints' rods.
std::vector<bool> moving_bodies(const sim::SceneDef& scene, std::span<const sim::Snapshot> states) {
    std::vector<bool> moves(states.front().bodies.size() + 1, false);
    moves[0] = true;
    for (const sim::Snapshot& state : states) {
        for (std::size_t i = 0; i < state.bodies.size(); ++i) {
            const sim::BodySnapshot& first = states.front().bodies[i];
            const sim::BodySnapshot& body = state.bodies[i];
            const bool comes = scene.bodies[i].is_there(state.time) != scene.bodies[i].is_there(states.front().time);
            if (comes || body.position != first.position || body.orientation.coeffs() != first.orientation.coeffs()) {
                moves[i + 1] = true;
            }
        }
    }
    return moves;
}

/// Planes stand still: their floors are those of the first state.
bool has_moving_floor(const sim::SceneDef& scene, const std::vector<bool>& moves) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (moves[i + 1] && std::holds_alternative<sim::Plane>(scene.bodies[i].shape)) {
            return true;
        }
    }
    return false;
}

} // namespace

ViewPoint view_point(const View& view, double aspect) {
    return {{view.eye.x(), view.eye.y(), view.eye.z()},
            {view.target.x(), view.target.y(), view.target.z()},
            view.fov_degrees,
            aspect};
}

DrawList make_draw_list(const sim::SceneDef& scene, const SceneGeometry& geometry,
                        const sim::CameraDef& camera, const sim::Snapshot& snapshot,
                        const Viewport& viewport) {
    return std::move(make_draw_lists(scene, geometry, camera, {&snapshot, 1}, viewport).front());
}

std::vector<DrawList> make_draw_lists(const sim::SceneDef& scene, const SceneGeometry& geometry,
                                      const sim::CameraDef& camera, std::span<const sim::Snapshot> states,
                                      const Viewport& viewport) {
    CHECK(!states.empty());
    const double aspect = static_cast<double>(viewport.width) / viewport.height;
    const View view = camera_view(camera, states.front(), aspect);
    bool is_still = true;
    for (const sim::Snapshot& state : states) {
        CHECK(state.bodies.size() == scene.bodies.size());
        is_still = is_still && camera_view(camera, state, aspect) == view;
    }
    const std::vector<bool> moves = moving_bodies(scene, states);
    std::vector<DrawList> lists;
    if (states.size() > 1 && (!is_still || has_moving_floor(scene, moves))) {
        for (const sim::Snapshot& state : states) {
            lists.push_back(make_draw_list(scene, geometry, camera, state, viewport));
        }
        return lists;
    }
    const Shown shown{scene, geometry, view, view_scale(camera), states};
    const std::vector<Parts> parts = parts_of(shown, viewport);
    Filled filled{.target = to_glm(view.target), .reach = static_cast<float>(shown.scale)};
    const DrawList common = common_list(shown, parts, viewport, filled);
    for (const Parts& state : parts) {
        lists.push_back(common);
        add_state(shown, state, filled, lists.back());
    }
    if (states.size() > 1) {
        const Changed changed = find_changed({geometry, parts, lists, moves}, viewport);
        for (std::size_t i = 1; i < lists.size(); ++i) {
            lists[i].redrawn = changed.picture;
            lists[i].shadows_redrawn = changed.shadows;
        }
    }
    return lists;
}

} // namespace render
