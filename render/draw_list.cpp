#include "render/draw_list.h"

#include "render/faces.h"
#include "render/mesh.h"
#include "sim/error.h"
#include "sim/polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <tuple>

namespace render {

namespace {

using sim::Pose;
using sim::Vec3;

/// A floor fades into the sky over this many view distances.
constexpr double floor_extent_in_views = 14.0;
/// What lies farther from the target than this many view distances throws no shadow.
constexpr double reach_in_views = 3.0;
/// Shadow texels are not smaller than this many view distances.
constexpr double least_texel_in_views = 0.0009;
/// Spheres below these radii on the picture [px] are drawn with the first, second, third mesh: the polygon
/// stays within 0.15 px of the circle.
constexpr std::array<double, mesh_id::sphere_count - 1> sphere_pixels{7.0, 30.0, 120.0};
/// Radius of the rod that a joint is drawn as, in view distances; and the least on the picture, so that a rod
/// covers the centre of at least one pixel in each row (edges.cpp then counts its true width) [px].
constexpr double rod_radius_in_views = 0.0014;
/// Cells of the occlusion volume across the smallest body, and cells of the whole volume at most.
constexpr double cells_across_body = 6.0;
constexpr double most_occlusion_cells = 2e5;
/// Round bodies of metal smoother than this show the bodies around them, if these are not more than that.
constexpr float polished_roughness = 0.4f;
constexpr std::size_t most_mirrored = 32;
/// Cells that the occlusion volume reaches beyond the bodies.
constexpr float occlusion_margin_cells = 4.0f;
glm::vec3 to_glm(const Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

glm::dvec3 to_glm_double(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

glm::vec4 to_glm(const sim::Quat& q) {
    return {static_cast<float>(q.x()), static_cast<float>(q.y()), static_cast<float>(q.z()),
            static_cast<float>(q.w())};
}

template <class... Fs>
struct Overload : Fs... {
    using Fs::operator()...;
};
template <class... Fs>
Overload(Fs...) -> Overload<Fs...>;

/// Distance between eye and target of the camera's first key: the length scale of the picture, constant in
/// time.
double view_scale(const sim::CameraDef& camera) {
    return std::max(1e-6, (camera.keys.front().eye - camera.keys.front().target).norm());
}

/// Collects the parts of all bodies and joints.
class PartCollector {
public:
    PartCollector(const SceneGeometry& geometry, const View& view, double pixels_per_radian)
        : geometry_(geometry), view_(view), forward_((view.target - view.eye).normalized()),
          pixels_per_radian_(pixels_per_radian) {}

    void add_body(const sim::BodyDef& body, std::size_t index, const Pose& pose) {
        look_ = &body.look;
        body_ = static_cast<std::uint32_t>(index + 1);
        const int profile = geometry_.profile_of_body[index];
        if (profile >= 0) {
            double radius = 0.0;
            for (const glm::vec2& point : geometry_.profiles[static_cast<std::size_t>(profile)]) {
                radius = std::max(radius, static_cast<double>(glm::length(point)));
            }
            rounds.push_back(part(pose, Vec3::Ones(), radius, mesh_id::lathe_first + profile));
            return;
        }
        std::visit(
            Overload{[](const sim::Plane&) {},
                     [&](const sim::Compound& compound) {
                         for (std::size_t i = 0; i < compound.parts.size(); ++i) {
                             const sim::CompoundPart& piece = compound.parts[i];
                             const Pose world_from_part{pose * piece.body_from_part.position,
                                                        pose.orientation * piece.body_from_part.orientation};
                             mesh_ = geometry_.mesh_of_part[index][i];
                             std::visit([&](const auto& shape) { add_primitive(shape, world_from_part); },
                                        piece.shape);
                         }
                     },
                     [&](const auto& shape) {
                         mesh_ = geometry_.mesh_of_part[index][0];
                         add_primitive(shape, pose);
                     }},
            body.shape);
    }

    /// A thin rod from a to b.
    void add_rod(const Vec3& a, const Vec3& b, double radius, const sim::LookDef& look) {
        const Vec3 along = b - a;
        if (!(along.norm() > 0.0)) {
            return;
        }
        look_ = &look;
        body_ = 0;
        const Pose pose{0.5 * (a + b), sim::Quat::FromTwoVectors(Vec3::UnitZ(), along)};
        const double half = 0.5 * along.norm();
        rounds.push_back(part(pose, {radius, radius, half}, half + radius, mesh_id::rod));
    }

    std::vector<Part> boxes;
    std::vector<Part> rounds;

private:
    void add_primitive(const sim::Box& box, const Pose& pose) {
        boxes.push_back(part(pose, box.half_extents, box.half_extents.norm(), -1));
    }

    void add_primitive(const sim::Sphere& sphere, const Pose& pose) {
        const double distance = std::max((pose.position - view_.eye).norm(), sphere.radius);
        const double pixels = sphere.radius / distance * pixels_per_radian_;
        const auto level = std::upper_bound(sphere_pixels.begin(), sphere_pixels.end(), pixels);
        rounds.push_back(part(pose, Vec3::Constant(sphere.radius), sphere.radius,
                              mesh_id::sphere_first + static_cast<int>(level - sphere_pixels.begin())));
    }

    void add_primitive(const sim::Cylinder& cylinder, const Pose& pose) {
        rounds.push_back(part(pose, Vec3::Ones(), std::hypot(cylinder.radius, cylinder.half_length), mesh_));
    }

    void add_primitive(const sim::Capsule& capsule, const Pose& pose) {
        rounds.push_back(part(pose, Vec3::Ones(), capsule.radius + capsule.half_length, mesh_));
    }

    void add_primitive(const sim::Hull& hull, const Pose& pose) {
        double radius = 0.0;
        for (const Vec3& vertex : hull.polytope->vertices) {
            radius = std::max(radius, vertex.norm());
        }
        rounds.push_back(part(pose, Vec3::Ones(), radius, mesh_));
    }

    Part part(const Pose& pose, const Vec3& scale, double bounding_radius, int mesh) const {
        Part result{};
        Instance& instance = result.instance;
        instance.orientation = to_glm(pose.orientation);
        instance.position = to_glm(pose.position);
        instance.scale = to_glm(scale);
        instance.roughness = static_cast<float>(look_->roughness);
        instance.metallic = static_cast<float>(look_->metallic);
        instance.color = to_glm(look_->color);
        instance.pattern_color = to_glm(look_->pattern_color);
        instance.bounding_radius = static_cast<float>(bounding_radius);
        result.mesh = mesh;
        result.pattern = look_->pattern;
        result.depth = static_cast<float>((pose.position - view_.eye).dot(forward_));
        result.body = body_;
        return result;
    }

    const SceneGeometry& geometry_;
    View view_;
    Vec3 forward_;
    double pixels_per_radian_;
    const sim::LookDef* look_ = nullptr;
    std::uint32_t body_ = 0;
    int mesh_ = -1; ///< of the part at hand, where it has one of its own
};

/// Rods of all drawn joints: from the anchor to the centre of body a.
void add_joints(const sim::SceneDef& scene, const sim::Snapshot& snapshot, double radius,
                PartCollector& collector) {
    sim::LookDef look;
    look.color = Vec3::Constant(0.10);
    look.roughness = 0.5;
    for (const sim::JointDef& joint : scene.joints) {
        if (!joint.is_drawn || joint.body_a < 0) {
            continue;
        }
        const auto a = static_cast<std::size_t>(joint.body_a);
        // The anchor as body b holds it now; where b is the world it does not move.
        Vec3 anchor = joint.anchor;
        if (joint.body_b >= 0) {
            const auto b = static_cast<std::size_t>(joint.body_b);
            const Vec3 anchor_body =
                scene.bodies[b].pose.orientation.conjugate() * (joint.anchor - scene.bodies[b].pose.position);
            anchor = snapshot.bodies[b].orientation * anchor_body + snapshot.bodies[b].position;
        }
        if (anchor.allFinite() && snapshot.bodies[a].position.allFinite()) {
            collector.add_rod(anchor, snapshot.bodies[a].position, radius, look);
        }
    }
}

void collect_parts(const sim::SceneDef& scene, const sim::Snapshot& snapshot, double rod_radius,
                   PartCollector& collector) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Pose pose{snapshot.bodies[i].position, snapshot.bodies[i].orientation};
        if (scene.bodies[i].look.visible && pose.position.allFinite() &&
            pose.orientation.coeffs().allFinite()) {
            collector.add_body(scene.bodies[i], i, pose);
        }
    }
    add_joints(scene, snapshot, rod_radius, collector);
    std::stable_sort(collector.boxes.begin(), collector.boxes.end(),
                     [](const Part& a, const Part& b) { return a.depth < b.depth; });
    std::stable_sort(collector.rounds.begin(), collector.rounds.end(), [](const Part& a, const Part& b) {
        return std::tie(a.mesh, a.pattern, a.depth) < std::tie(b.mesh, b.pattern, b.depth);
    });
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

OcclusionVolume make_occlusion(const SceneGeometry& geometry, const PartCollector& parts,
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

/// What polished round bodies mirror, unless it is too much to follow rays to.
void fill_mirrored(const PartCollector& parts, DrawList& list) {
    const auto is_polished = [](const Part& part) {
        return part.instance.metallic > 0.5f && part.instance.roughness < polished_roughness;
    };
    if (std::none_of(parts.rounds.begin(), parts.rounds.end(), is_polished)) {
        return;
    }
    for (const Part& part : parts.rounds) {
        if (part.mesh < mesh_id::sphere_first + mesh_id::sphere_count) {
            list.mirrored.push_back(part.instance);
        }
    }
    list.mirrored_spheres = static_cast<int>(list.mirrored.size());
    for (const Part& part : parts.boxes) {
        list.mirrored.push_back(part.instance);
    }
    if (list.mirrored.size() > most_mirrored) {
        list.mirrored.clear();
    }
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
        geometry.mesh_of_part.push_back(part_meshes.of_body(body.shape));
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

DrawList make_draw_list(const sim::SceneDef& scene, const SceneGeometry& geometry,
                        const sim::CameraDef& camera, const sim::Snapshot& snapshot,
                        const Viewport& viewport) {
    CHECK(snapshot.bodies.size() == scene.bodies.size());
    const View view = camera_view(camera, snapshot);
    const ViewPoint view_point{to_glm_double(view.eye), to_glm_double(view.target), view.fov_degrees,
                               static_cast<double>(viewport.width) / viewport.height};
    const double scale = view_scale(camera);
    const auto extent = static_cast<double>(geometry.floor_extent);

    PartCollector parts(geometry, view,
                        viewport.height / (2.0 * std::tan(0.5 * glm::radians(view.fov_degrees))));
    collect_parts(scene, snapshot, rod_radius_in_views * scale, parts);

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
    list.occlusion =
        make_occlusion(geometry, parts, list.floors, glm::vec3(view_point.target), static_cast<float>(scale));
    for (Floor& floor : list.floors) {
        floor.occlusion = floor_occlusion(floor, list.occlusion);
    }
    add_faces(parts.boxes, geometry, list);
    fill_rounds(parts.rounds, geometry, list);
    fill_mirrored(parts, list);
    return list;
}

} // namespace render
