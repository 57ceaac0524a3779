#include "render/draw_list.h"

#include "sim/error.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace render {

namespace {

using sim::Pose;
using sim::Vec3;

/// A floor fades into the sky over this many view distances.
constexpr double floor_extent_in_views = 14.0;
/// What lies farther from the target than this many view distances throws no shadow.
constexpr double shadow_reach_in_views = 3.0;
/// Spheres above this radius on the picture are drawn with the fine mesh [px].
constexpr double fine_sphere_pixels = 24.0;
/// Radius of the rod that a joint is drawn as, in view distances.
constexpr double rod_radius_in_views = 0.0018;

glm::vec3 to_glm(const Vec3& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
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

/// A part together with what sorts it.
struct Part {
    Instance instance;
    int mesh;
    sim::Pattern pattern;
    float depth; ///< along the view [m]
};

/// Collects the parts of all bodies and joints.
class PartCollector {
public:
    PartCollector(const LatheTable& lathes, const View& view, double pixels_per_radian)
        : lathes_(lathes), view_(view), forward_((view.target - view.eye).normalized()),
          pixels_per_radian_(pixels_per_radian) {}

    void add_body(const sim::BodyDef& body, std::size_t index, const Pose& pose) {
        look_ = &body.look;
        const int profile = lathes_.profile_of_body[index];
        if (profile >= 0) {
            double radius = 0.0;
            for (const glm::vec2& point : lathes_.profiles[static_cast<std::size_t>(profile)]) {
                radius = std::max(radius, static_cast<double>(glm::length(point)));
            }
            add(mesh_id::lathe_first + profile, pose, Vec3::Ones(), radius);
            return;
        }
        std::visit(
            Overload{[](const sim::Plane&) {},
                     [&](const sim::Compound& compound) {
                         for (const sim::CompoundPart& part : compound.parts) {
                             const Pose world_from_part{pose * part.body_from_part.position,
                                                        pose.orientation * part.body_from_part.orientation};
                             std::visit([&](const auto& shape) { add_primitive(shape, world_from_part); },
                                        part.shape);
                         }
                     },
                     [&](const auto& shape) { add_primitive(shape, pose); }},
            body.shape);
    }

    /// A thin rod from a to b.
    void add_rod(const Vec3& a, const Vec3& b, double radius, const sim::LookDef& look) {
        const Vec3 along = b - a;
        if (!(along.norm() > 0.0)) {
            return;
        }
        look_ = &look;
        const Pose pose{0.5 * (a + b), sim::Quat::FromTwoVectors(Vec3::UnitZ(), along)};
        add(mesh_id::rod, pose, {radius, radius, 0.5 * along.norm()}, 0.5 * along.norm() + radius);
    }

    std::vector<Part>& parts() { return parts_; }

private:
    void add_primitive(const sim::Box& box, const Pose& pose) {
        add(mesh_id::box, pose, box.half_extents, box.half_extents.norm());
    }

    void add_primitive(const sim::Sphere& sphere, const Pose& pose) {
        const double distance = std::max((pose.position - view_.eye).norm(), sphere.radius);
        const bool is_fine = sphere.radius / distance * pixels_per_radian_ > fine_sphere_pixels;
        add(is_fine ? mesh_id::sphere_fine : mesh_id::sphere_coarse, pose, Vec3::Constant(sphere.radius),
            sphere.radius);
    }

    void add(int mesh, const Pose& pose, const Vec3& scale, double bounding_radius) {
        if (!pose.position.allFinite() || !pose.orientation.coeffs().allFinite()) {
            return;
        }
        Part part{};
        part.instance.orientation = to_glm(pose.orientation);
        part.instance.position = to_glm(pose.position);
        part.instance.scale = to_glm(scale);
        part.instance.roughness = static_cast<float>(look_->roughness);
        part.instance.metallic = static_cast<float>(look_->metallic);
        part.instance.color = to_glm(look_->color);
        part.instance.pattern_color = to_glm(look_->pattern_color);
        part.instance.bounding_radius = static_cast<float>(bounding_radius);
        part.instance.id = static_cast<std::uint32_t>(parts_.size() + 1);
        part.mesh = mesh;
        part.pattern = look_->pattern;
        part.depth = static_cast<float>((pose.position - view_.eye).dot(forward_));
        parts_.push_back(part);
    }

    const LatheTable& lathes_;
    View view_;
    Vec3 forward_;
    double pixels_per_radian_;
    const sim::LookDef* look_ = nullptr;
    std::vector<Part> parts_;
};

/// Rods of all drawn joints: from the anchor to the centre of body a.
void add_joints(const sim::SceneDef& scene, const sim::Snapshot& snapshot, double radius,
                PartCollector& collector) {
    sim::LookDef look;
    look.color = Vec3::Constant(0.25);
    look.roughness = 0.4;
    look.metallic = 0.6;
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
        collector.add_rod(anchor, snapshot.bodies[a].position, radius, look);
    }
}

/// Floors of all visible plane bodies.
std::vector<Floor> make_floors(const sim::SceneDef& scene, const sim::Snapshot& snapshot, const View& view,
                               std::uint32_t first_id) {
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
        floor.origin = to_glm(near);
        floor.normal = to_glm(normal);
        floor.tangent = to_glm(tangent);
        floor.grid_origin = {static_cast<float>((near - pose.position).dot(tangent)),
                             static_cast<float>((near - pose.position).dot(across))};
        floor.color = to_glm(body.look.color);
        floor.line_color = to_glm(body.look.pattern_color);
        floor.roughness = static_cast<float>(body.look.roughness);
        floor.id = first_id + static_cast<std::uint32_t>(floors.size());
        floors.push_back(floor);
    }
    return floors;
}

/// Depth range [m] along the view that holds all parts, and the floors up to `extent`.
std::pair<double, double> depth_range(const std::vector<Part>& parts, const std::vector<Floor>& floors,
                                      double extent) {
    double nearest = extent;
    double farthest = 0.0;
    for (const Part& part : parts) {
        const double radius = static_cast<double>(part.instance.bounding_radius);
        nearest = std::min(nearest, static_cast<double>(part.depth) - radius);
        farthest = std::max(farthest, static_cast<double>(part.depth) + radius);
    }
    if (!floors.empty()) {
        // Depth is stored as a float that grows towards the eye, so a small near distance costs no precision.
        nearest = std::min(nearest, extent * 1e-4);
        farthest = std::max(farthest, extent);
    }
    farthest = std::max(farthest, 1e-6);
    return {std::max(nearest * 0.95, farthest * 1e-5), farthest * 1.05};
}

/// Perspective with depth 1 at the near plane and 0 at the far plane.
glm::dmat4 reversed_perspective(double fov_degrees, double aspect, double near, double far) {
    const double f = 1.0 / std::tan(0.5 * glm::radians(fov_degrees));
    glm::dmat4 m(0.0);
    m[0][0] = f / aspect;
    m[1][1] = f;
    m[2][2] = near / (far - near);
    m[2][3] = -1.0;
    m[3][2] = near * far / (far - near);
    return m;
}

CameraBlock make_camera(const View& view, double aspect, std::pair<double, double> range) {
    const glm::dvec3 eye(view.eye.x(), view.eye.y(), view.eye.z());
    const glm::dvec3 target(view.target.x(), view.target.y(), view.target.z());
    const glm::dvec3 forward = glm::normalize(target - eye);
    const bool is_vertical = std::abs(forward.z) > 0.9999;
    const glm::dvec3 up = is_vertical ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    const glm::dmat4 clip_from_world =
        reversed_perspective(view.fov_degrees, aspect, range.first, range.second) *
        glm::lookAt(eye, target, up);
    CameraBlock camera{};
    camera.clip_from_world = glm::mat4(clip_from_world);
    camera.world_from_clip = glm::mat4(glm::inverse(clip_from_world));
    camera.eye = glm::vec3(eye);
    camera.near_distance = static_cast<float>(range.first);
    camera.far_distance = static_cast<float>(range.second);
    camera.view_distance = static_cast<float>(glm::length(target - eye));
    return camera;
}

/// Smallest power of 2^(1/4) that is at least x: the volume keeps its size while the bodies move.
double stepped_size(double x) {
    return std::exp2(0.25 * std::ceil(4.0 * std::log2(std::max(x, 1e-9))));
}

ShadowVolume make_shadow_volume(const std::vector<Part>& parts, const glm::dvec3& to_sun, const View& view,
                                double reach, int shadow_size) {
    const glm::dvec3 up = std::abs(to_sun.z) > 0.99 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    const glm::dmat4 light_from_world = glm::lookAt(glm::dvec3(0.0), -to_sun, up);
    const glm::dvec3 target(view.target.x(), view.target.y(), view.target.z());
    glm::dvec3 lower(1e300);
    glm::dvec3 upper(-1e300);
    for (const Part& part : parts) {
        const glm::dvec3 position(part.instance.position);
        const double radius = static_cast<double>(part.instance.bounding_radius);
        if (glm::length(position - target) - radius > reach) {
            continue;
        }
        const glm::dvec3 p(light_from_world * glm::dvec4(position, 1.0));
        // A body larger than the reach fills the volume without stretching it.
        const double shown = std::min(radius, reach);
        lower = glm::min(lower, p - shown);
        upper = glm::max(upper, p + shown);
    }
    if (lower.x > upper.x) {
        lower = glm::dvec3(light_from_world * glm::dvec4(target, 1.0)) - reach;
        upper = lower + 2.0 * reach;
    }
    // Two texels on each side stay free, so that what lies outside is lit.
    const double side = stepped_size(std::max(upper.x - lower.x, upper.y - lower.y));
    const double texel = side / (shadow_size - 8);
    const double half = 0.5 * texel * shadow_size;
    // The volume moves by whole texels only: shadow edges do not crawl.
    const glm::dvec2 centre = glm::round((glm::dvec2(lower) + glm::dvec2(upper)) * 0.5 / texel) * texel;
    const double depth = stepped_size(upper.z - lower.z);
    const glm::dmat4 clip_from_light =
        glm::orthoRH_ZO(centre.x - half, centre.x + half, centre.y - half, centre.y + half,
                        -upper.z - depth * 0.01, -lower.z + depth * 0.01);
    return {glm::mat4(clip_from_light * light_from_world), static_cast<float>(texel)};
}

LightBlock make_light(const sim::LightDef& light, const std::vector<Floor>& floors) {
    LightBlock block{};
    block.to_sun = to_glm(light.to_sun.normalized());
    block.sun = to_glm(Vec3(light.sun_color * light.sun_intensity));
    block.sky_zenith = to_glm(Vec3(light.sky_zenith * light.sky_intensity));
    block.sky_horizon = to_glm(Vec3(light.sky_horizon * light.sky_intensity));
    block.ground = block.sky_horizon;
    if (!floors.empty()) {
        const glm::vec3 mean_sky = 0.5f * (block.sky_zenith + block.sky_horizon);
        block.ground = floors.front().color * (block.sun * std::max(block.to_sun.z, 0.0f) + mean_sky);
    }
    return block;
}

/// Sorts the parts by batch, nearest first within one, and describes the batches.
void fill_batches(std::vector<Part>& parts, DrawList& list) {
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) {
        return std::tie(a.mesh, a.pattern, a.depth, a.instance.id) <
               std::tie(b.mesh, b.pattern, b.depth, b.instance.id);
    });
    list.instances.reserve(parts.size());
    for (const Part& part : parts) {
        if (list.batches.empty() || list.batches.back().mesh != part.mesh ||
            list.batches.back().pattern != part.pattern) {
            list.batches.push_back({part.mesh, part.pattern, static_cast<int>(list.instances.size()), 0});
        }
        ++list.batches.back().count;
        list.instances.push_back(part.instance);
    }
}

} // namespace

LatheTable make_lathe_table(const sim::SceneDef& scene) {
    LatheTable table;
    for (const sim::BodyDef& body : scene.bodies) {
        if (body.look.lathe.size() < 2) {
            table.profile_of_body.push_back(-1);
            continue;
        }
        std::vector<glm::vec2> profile;
        for (const Eigen::Vector2d& point : body.look.lathe) {
            profile.emplace_back(static_cast<float>(point.x()), static_cast<float>(point.y()));
        }
        const auto known = std::find(table.profiles.begin(), table.profiles.end(), profile);
        table.profile_of_body.push_back(static_cast<int>(known - table.profiles.begin()));
        if (known == table.profiles.end()) {
            table.profiles.push_back(std::move(profile));
        }
    }
    return table;
}

DrawList make_draw_list(const sim::SceneDef& scene, const LatheTable& lathes, const sim::CameraDef& camera,
                        const sim::Snapshot& snapshot, const Viewport& viewport) {
    CHECK(snapshot.bodies.size() == scene.bodies.size());
    const View view = camera_view(camera, snapshot);
    const double scale = view_scale(camera);
    const double pixels_per_radian = viewport.height / (2.0 * std::tan(0.5 * glm::radians(view.fov_degrees)));

    PartCollector collector(lathes, view, pixels_per_radian);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].look.visible) {
            collector.add_body(scene.bodies[i], i,
                               {snapshot.bodies[i].position, snapshot.bodies[i].orientation});
        }
    }
    add_joints(scene, snapshot, rod_radius_in_views * scale, collector);
    std::vector<Part>& parts = collector.parts();

    DrawList list;
    list.floors = make_floors(scene, snapshot, view, static_cast<std::uint32_t>(parts.size() + 1));
    list.floor_extent = static_cast<float>(floor_extent_in_views * scale);
    list.grid_spacing = static_cast<float>(std::pow(10.0, std::floor(std::log10(scale / 5.0))));
    list.light = make_light(scene.light, list.floors);
    list.camera = make_camera(view, static_cast<double>(viewport.width) / viewport.height,
                              depth_range(parts, list.floors, floor_extent_in_views * scale));
    const Vec3 to_sun = scene.light.to_sun.normalized();
    list.shadow = make_shadow_volume(parts, {to_sun.x(), to_sun.y(), to_sun.z()}, view,
                                     shadow_reach_in_views * scale, viewport.shadow_size);
    fill_batches(parts, list);
    return list;
}

} // namespace render
