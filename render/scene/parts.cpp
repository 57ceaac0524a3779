#include "render/scene/parts.h"

#include "sim/model/polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <tuple>

namespace render {

namespace {

using sim::Pose;
using sim::Vec3;

/// Spheres below these radii on the picture [px] are drawn with the first, second, third mesh: the polygon
/// stays within 0.35 px of the circle, and smooth edges know the circle.
constexpr std::array<double, mesh_id::sphere_count - 1> sphere_pixels{18.0, 73.0, 290.0};

/// The same of bodies of revolution that are no spheres.
constexpr std::array<double, lathe_sides.size() - 1> lathe_pixels{18.0, 73.0, 163.0, 290.0};

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
            double bounding_radius = 0.0;
            double radius = 0.0;
            for (const glm::vec2& point : geometry_.profiles[static_cast<std::size_t>(profile)]) {
                bounding_radius = std::max(bounding_radius, static_cast<double>(glm::length(point)));
                radius = std::max(radius, static_cast<double>(point.x));
            }
            mesh_ = mesh_id::lathe_first + profile;
            add_lathe(pose, bounding_radius, radius);
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
            body.drawn_shape());
    }

    /// A thin rod from a to b.
    void add_rod(const Vec3& a, const Vec3& b, double radius, const sim::LookDef& look) {
        const Vec3 along = b - a;
        if (!(along.norm() > 0.0)) {
            return;
        }
        look_ = &look;
        body_ = 0;
        const Pose pose{0.5 * (a + b), sim::rotation_between(Vec3::UnitZ(), along)};
        const double half = 0.5 * along.norm();
        parts.rounds.push_back(part(pose, {radius, radius, half}, half + radius, mesh_id::rod));
    }

    Parts parts;

private:
    void add_primitive(const sim::Box& box, const Pose& pose) {
        parts.boxes.push_back(part(pose, box.half_extents, box.half_extents.norm(), -1));
    }

    void add_primitive(const sim::Sphere& sphere, const Pose& pose) {
        const int level = level_of(sphere.radius, sphere.radius, pose, sphere_pixels);
        parts.rounds.push_back(
            part(pose, Vec3::Constant(sphere.radius), sphere.radius, mesh_id::sphere_first + level));
    }

    void add_primitive(const sim::Cylinder& cylinder, const Pose& pose) {
        add_lathe(pose, std::hypot(cylinder.radius, cylinder.half_length), cylinder.radius);
    }

    void add_primitive(const sim::Capsule& capsule, const Pose& pose) {
        add_lathe(pose, capsule.radius + capsule.half_length, capsule.radius);
    }

    void add_primitive(const sim::Hull& hull, const Pose& pose) {
        double radius = 0.0;
        for (const Vec3& vertex : hull.polytope->vertices) {
            radius = std::max(radius, vertex.norm());
        }
        parts.rounds.push_back(part(pose, Vec3::Ones(), radius, mesh_));
    }

    /// With the mesh at hand.
    void add_lathe(const Pose& pose, double bounding_radius, double radius) {
        parts.rounds.push_back(part(pose, Vec3::Ones(), bounding_radius, mesh_));
        parts.rounds.back().level = level_of(bounding_radius, radius, pose, lathe_pixels);
    }

    /// How many of the limits [px] a radius [m] exceeds on the picture.
    int level_of(double bounding_radius, double radius, const Pose& pose, std::span<const double> limits) const {
        const double distance = std::max((pose.position - view_.eye).norm(), bounding_radius);
        const double pixels = radius / distance * pixels_per_radian_;
        return static_cast<int>(std::ranges::upper_bound(limits, pixels) - limits.begin());
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
    const sim::LookDef look = rod_look();
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

/// Corners of a regular octagon are this many times as far from its middle as its sides.
constexpr float octagon = 1.0823922f;

/// A circle of a radius about z at height z.
void visit_ring(float radius, float z, const auto& visit) {
    const float far = radius * octagon;
    const float near = far * std::numbers::sqrt2_v<float> * 0.5f;
    for (const glm::vec2& p : {glm::vec2(far, 0), glm::vec2(0, far), glm::vec2(near, near), glm::vec2(near, -near)}) {
        visit(glm::vec3(p, z));
        visit(glm::vec3(-p, z));
    }
}

} // namespace

sim::LookDef rod_look() {
    sim::LookDef look;
    look.color = Vec3::Constant(0.10);
    look.roughness = 0.5;
    return look;
}

Parts collect_parts(const sim::SceneDef& scene, const SceneGeometry& geometry, const sim::Snapshot& snapshot,
                    const View& view, const PartSetup& setup) {
    PartCollector collector(geometry, view, setup.pixels_per_radian);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Pose pose{snapshot.bodies[i].position, snapshot.bodies[i].orientation};
        if (scene.bodies[i].look.visible && scene.bodies[i].is_there(snapshot.time) && pose.position.allFinite() &&
            pose.orientation.coeffs().allFinite()) {
            collector.add_body(scene.bodies[i], i, pose);
        }
    }
    add_joints(scene, snapshot, setup.rod_radius, collector);
    std::ranges::stable_sort(collector.parts.boxes, {}, &Part::depth);
    std::ranges::stable_sort(collector.parts.rounds, [](const Part& a, const Part& b) {
        return std::tie(a.mesh, a.pattern, a.depth) < std::tie(b.mesh, b.pattern, b.depth);
    });
    return std::move(collector.parts);
}

void append_points(const Part& part, const SceneGeometry& geometry, std::vector<glm::vec3>& points) {
    const Instance& instance = part.instance;
    const auto visit = [&](const glm::vec3& p) { points.push_back(instance.position + turned(instance.orientation, p)); };
    const auto own = static_cast<std::size_t>(part.mesh - mesh_id::lathe_first);
    if (part.mesh < 0 || part.mesh == mesh_id::rod) {
        for (int i = 0; i < 8; ++i) {
            visit(instance.scale * (2.0f * glm::vec3(i & 1, (i >> 1) & 1, (i >> 2) & 1) - 1.0f));
        }
    } else if (part.mesh < mesh_id::lathe_first) {
        constexpr float low = 0.4142135f; // tangent of 22.5 degrees
        for (const glm::vec2& p : {glm::vec2(1, low), glm::vec2(low, 1)}) {
            visit_ring(p.x * instance.scale.x, p.y * instance.scale.x, visit);
            visit_ring(p.x * instance.scale.x, -p.y * instance.scale.x, visit);
        }
    } else if (own < geometry.profiles.size()) {
        for (const glm::vec2& p : geometry.profiles[own]) {
            visit_ring(p.x, p.y, visit);
        }
    } else {
        for (const HullFace& face : geometry.hulls[own - geometry.profiles.size()]) {
            std::ranges::for_each(face.corners, visit);
        }
    }
}

} // namespace render
