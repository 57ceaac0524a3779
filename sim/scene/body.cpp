#include "sim/scene/body.h"

#include "sim/scene/shape.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

namespace sim {

namespace {

/// Of a body with neither density nor mass: water's [kg/m^3].
constexpr double default_density = 1000.0;

/// Rounding allowed in the triangle inequality of principal moments, relative to the largest: a thin plate
/// meets it with equality, and its moments may have been written with six digits.
constexpr double moment_rounding = 1e-5;

// --- mass ------------------------------------------------------------------------------------------------

/// The tensor of three or six moments; throws if no mass distribution has it.
Mat3 read_inertia(Section& section) {
    const std::vector<double> m = section.moments("inertia");
    Mat3 inertia = Vec3(m[0], m[1], m[2]).asDiagonal();
    if (m.size() == 6) {
        inertia(0, 1) = inertia(1, 0) = m[3];
        inertia(0, 2) = inertia(2, 0) = m[4];
        inertia(1, 2) = inertia(2, 1) = m[5];
    }
    const Vec3 principal = Eigen::SelfAdjointEigenSolver<Mat3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
    if (!(principal.minCoeff() > 0.0)) {
        section.fail("inertia",
                     fmt::format("inertia has the principal moments {:.6g}, {:.6g}, {:.6g}, expected all > 0",
                                 principal[0], principal[1], principal[2]));
    }
    if (principal[2] > (principal[0] + principal[1]) + moment_rounding * principal[2]) {
        section.fail("inertia",
                     fmt::format("inertia has the principal moments {:.6g}, {:.6g}, {:.6g}, expected none "
                                 "above the sum of the other two",
                                 principal[0], principal[1], principal[2]));
    }
    return inertia;
}

/// Mass properties of a dynamic body, in the frame its shape was given in.
MassProperties read_mass(Section& section, const Shape& shape) {
    if (section.has("density") && section.has("mass")) {
        section.fail("density", "expected density or mass, not both");
    }
    for (const auto& [key, needed] : {std::pair("inertia", "mass"), std::pair("centre_of_mass", "inertia")}) {
        if (section.has(key) && !section.has(needed)) {
            section.fail(key, fmt::format("{} is given without {}, expected both", key, needed));
        }
    }
    MassProperties result = mass_properties(shape, 1.0);
    if (section.has("inertia")) {
        result.mass = section.number("mass");
        result.inertia = read_inertia(section);
        if (section.has("centre_of_mass")) {
            result.centre_of_mass = section.vector("centre_of_mass");
        }
    } else {
        const std::optional<double> mass = section.optional_number("mass");
        const double density =
            mass ? *mass / result.mass : section.optional_number("density").value_or(default_density);
        result = mass_properties(shape, density);
        result.mass = mass.value_or(result.mass);
    }
    // Sizes near the ends of the number range.
    if (!(result.mass > 0.0 && std::isfinite(result.mass) && result.inertia.diagonal().minCoeff() > 0.0 &&
          result.inertia.allFinite() && result.centre_of_mass.allFinite())) {
        section.fail("shape",
                     fmt::format("mass {:.3g} kg and inertia {:.3g} kg m^2 come out of shape and density, "
                                 "expected finite numbers > 0",
                                 result.mass, result.inertia.diagonal().minCoeff()));
    }
    return result;
}

/// A body that no force moves has no mass and no velocity.
void refuse_motion(const Section& section, std::string_view why) {
    for (const char* key : {"density", "mass", "centre_of_mass", "inertia", "velocity", "angular_velocity"}) {
        if (section.has(key)) {
            section.fail(key, fmt::format("{} is given, but the body is {}, expected none", key, why));
        }
    }
}

/// A compound of one unturned part at its origin is that part.
Shape simplified(const Shape& shape) {
    const Compound* compound = std::get_if<Compound>(&shape);
    if (compound == nullptr || compound->parts.size() != 1) {
        return shape;
    }
    const CompoundPart& part = compound->parts[0];
    if (!part.body_from_part.position.isZero(0.0) || part.body_from_part.orientation.vec() != Vec3::Zero()) {
        return shape;
    }
    return std::visit([](const auto& primitive) { return Shape(primitive); }, part.shape);
}

/// The keys of a kinematic body.
void read_motion(Section& body, BodyDef& def) {
    if (body.has("static") && body.boolean("static")) {
        body.fail("keys", "keys are given, but the body is static, expected none");
    }
    Motion& motion = def.motion;
    motion.axis = body.direction("axis");
    motion.orientation = def.pose.orientation;
    for (const TreeNode* node : body.tables("keys")) {
        Section key(body.source(), *node, scene_section("body.keys"),
                    fmt::format("{} key {}", body.title(), motion.keys.size()));
        const Vec3 position = key.has("position") ? key.vector("position") : def.pose.position;
        const double angle = key.number("angle_degrees") * (std::numbers::pi / 180.0);
        const double time = key.number("time");
        if (!motion.is_empty() && time <= motion.keys.back().time) {
            key.fail("time", fmt::format("time is {}, expected more than that of the key before, {}", time,
                                         motion.keys.back().time));
        }
        motion.keys.push_back({time, static_cast<Easing>(key.choice("easing")), {}});
        motion.keys.back().value << position, angle;
    }
    if (motion.is_empty()) {
        body.fail("keys", "keys is an empty array, expected at least one key");
    }
    const Velocity velocity = motion.velocity_at(0.0);
    def.pose = motion.pose_at(0.0);
    def.velocity = velocity.v;
    def.angular_velocity = velocity.w;
}

} // namespace

MaterialDef read_material(Section& section) {
    MaterialDef material;
    material.restitution = section.optional_number("restitution");
    const std::optional<double> friction = section.optional_number("friction");
    material.mu_s = section.optional_number("mu_s");
    material.mu_d = section.optional_number("mu_d");
    if (friction && (material.mu_s || material.mu_d)) {
        section.fail("friction", "expected friction, or mu_s and mu_d, not both");
    }
    if (material.mu_s.has_value() != material.mu_d.has_value()) {
        section.fail(material.mu_s ? "mu_s" : "mu_d",
                     "expected mu_s and mu_d together; friction sets both to one value");
    }
    if (material.mu_s && *material.mu_s < *material.mu_d) {
        section.fail("mu_s", fmt::format("mu_s is {}, expected at least mu_d, which is {}", *material.mu_s,
                                         *material.mu_d));
    }
    if (friction) {
        material.mu_s = material.mu_d = friction;
    }
    return material;
}

LookDef read_look(Section& section) {
    LookDef look;
    look.color = section.color("color");
    look.pattern = static_cast<Pattern>(section.choice("pattern"));
    look.pattern_color = section.color("pattern_color");
    look.roughness = section.number("roughness");
    look.metallic = section.number("metallic");
    look.visible = section.boolean("visible");
    return look;
}

BodyDef read_body_template(Section& section, std::int64_t index, bool has_keys) {
    BodyDef body;
    body.shape = read_shape(section.source(), section.table("shape"), section.title() + " shape", index);
    const bool is_static = section.boolean("static");
    if (std::holds_alternative<Plane>(body.shape) && !is_static) {
        section.fail("shape", "a plane cannot move, expected static = true");
    }
    if (is_static || has_keys) {
        refuse_motion(section, is_static ? "static" : "moved by keys");
    } else {
        body.mass = read_mass(section, body.shape);
        body.velocity = section.vector("velocity");
        body.angular_velocity = section.vector("angular_velocity");
    }
    body.pose.orientation = read_orientation(section);
    body.material = read_material(section);
    body.look = read_look(section);
    if (std::holds_alternative<Plane>(body.shape)) {
        body.look.color = section.has("color") ? body.look.color : floor_color;
        body.look.pattern_color = section.has("pattern_color") ? body.look.pattern_color : floor_line_color;
    }
    if (section.has("drawn")) {
        body.drawn = read_shape(section.source(), section.table("drawn"), section.title() + " drawn", index);
        if (std::holds_alternative<Plane>(body.shape) || std::holds_alternative<Plane>(*body.drawn) || section.has("lathe")) {
            section.fail("drawn", section.has("lathe") ? "expected drawn or lathe, not both"
                                                       : "a plane has no end, expected another shape");
        }
    }
    if (section.has("lathe")) {
        body.look.lathe = section.profile("lathe");
        if (body.mass.centre_of_mass.head<2>() != Eigen::Vector2d::Zero()) {
            section.fail("lathe",
                         fmt::format("the centre of mass is at x = {:.3g}, y = {:.3g}, expected it on the z "
                                     "axis of a body with a lathe profile",
                                     body.mass.centre_of_mass.x(), body.mass.centre_of_mass.y()));
        }
    }
    return body;
}

BodyDef read_body(const TextSource& source, const TreeNode& node, const std::string& title) {
    Section section(source, node, scene_section("body"), title);
    const std::string name = section.text("name");
    const bool has_keys = section.has("keys");
    BodyDef body = read_body_template(section, 0, has_keys);
    body.name = name;
    body.pose.position = section.vector("position");
    body.release = read_release(section, body);
    if (has_keys) {
        read_motion(section, body);
    } else if (section.has("axis")) {
        section.fail("axis", "axis is given without keys, expected both");
    }
    settle(body);
    return body;
}

double read_release(Section& section, const BodyDef& body) {
    if (section.has("release") && body.is_static()) {
        section.fail("release", "release is given, but no force moves the body, expected none");
    }
    return section.number("release");
}

void settle(BodyDef& body) {
    const Vec3 origin = body.mass.centre_of_mass;
    if (!body.is_static()) {
        body.shape = shifted(body.shape, origin);
        if (body.drawn) {
            body.drawn = shifted(*body.drawn, origin);
        }
        body.pose.position = body.pose * origin;
        for (Eigen::Vector2d& point : body.look.lathe) {
            point.y() -= origin.z();
        }
        body.mass.centre_of_mass = Vec3::Zero();
    }
    body.shape = simplified(body.shape);
}

} // namespace sim
