#include "sim/model/shape.h"

#include "sim/base/error.h"
#include "sim/model/polytope.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>

namespace sim {

namespace {

// --- mass properties -------------------------------------------------------------------------------------

/// Homogeneous box about its centre: J_xx = m (y^2 + z^2) / 3 with half extents y, z.
MassProperties primitive_mass(const Box& box, double density) {
    const Vec3& r = box.half_extents;
    MassProperties result;
    result.mass = density * 8.0 * r.prod();
    const Vec3 squares = r.cwiseProduct(r);
    result.inertia = (result.mass / 3.0 * (Vec3::Constant(squares.sum()) - squares)).asDiagonal();
    return result;
}

/// Homogeneous sphere about its centre: J = 2/5 m r^2.
MassProperties primitive_mass(const Sphere& sphere, double density) {
    const double r = sphere.radius;
    MassProperties result;
    result.mass = density * 4.0 / 3.0 * std::numbers::pi * r * r * r;
    result.inertia = Mat3::Identity() * (0.4 * result.mass * r * r);
    return result;
}

/// Homogeneous cylinder about its centre: J_zz = m r^2 / 2, J_xx = m (r^2 / 4 + l^2 / 3) with half length l.
MassProperties primitive_mass(const Cylinder& cylinder, double density) {
    const double r2 = cylinder.radius * cylinder.radius;
    const double l = cylinder.half_length;
    MassProperties result;
    result.mass = density * 2.0 * std::numbers::pi * r2 * l;
    const double across = result.mass * (0.25 * r2 + l * l / 3.0);
    result.inertia = Vec3(across, across, 0.5 * result.mass * r2).asDiagonal();
    return result;
}

/// A cylinder and two half balls, whose centres of mass lie 3/8 r beyond its ends.
MassProperties primitive_mass(const Capsule& capsule, double density) {
    const double r = capsule.radius;
    MassProperties result = primitive_mass(Cylinder{r, capsule.half_length}, density);
    const MassProperties ball = primitive_mass(Sphere{r}, density);
    // A half ball about its own centre of mass: J of the ball, less m (3/8 r)^2 across its axis.
    const double to_centre = 0.375 * r;
    const double reach = capsule.half_length + to_centre;
    const double across =
        ball.inertia(0, 0) + ball.mass * (reach * reach - to_centre * to_centre);
    result.mass += ball.mass;
    result.inertia += Vec3(across, across, ball.inertia(2, 2)).asDiagonal().toDenseMatrix();
    return result;
}

/// J = tr(S) 1 - S with S the integral of density x x^T about the centre of mass.
MassProperties primitive_mass(const Hull& hull, double density) {
    const VolumeMoments moments = volume_moments(*hull.polytope);
    MassProperties result;
    result.mass = density * moments.volume;
    result.centre_of_mass = moments.centroid;
    result.inertia = density * (moments.second.trace() * Mat3::Identity() - moments.second);
    return result;
}

/// Parallel axis theorem: what a mass away from the axis adds to the inertia tensor. offset [m].
Mat3 steiner(double mass, const Vec3& offset) {
    return mass * (offset.squaredNorm() * Mat3::Identity() - offset * offset.transpose());
}

MassProperties primitive_mass(const Compound& compound, double density) {
    CHECK(!compound.parts.empty());
    std::vector<MassProperties> parts;
    MassProperties result;
    // Mass and centre of mass of all parts.
    for (const CompoundPart& part : compound.parts) {
        parts.push_back(
            std::visit([&](const auto& shape) { return primitive_mass(shape, density); }, part.shape));
        result.mass += parts.back().mass;
        result.centre_of_mass +=
            parts.back().mass * (part.body_from_part * parts.back().centre_of_mass);
    }
    result.centre_of_mass /= result.mass;
    // Each part's tensor, turned into the compound's axes and moved to the common centre.
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const Pose& pose = compound.parts[i].body_from_part;
        const Mat3 turn = pose.orientation.toRotationMatrix();
        result.inertia += turn * parts[i].inertia * turn.transpose();
        result.inertia += steiner(parts[i].mass, pose * parts[i].centre_of_mass - result.centre_of_mass);
    }
    return result;
}

MassProperties primitive_mass(const Plane&, double) {
    CHECK(!"a plane has a mass");
    return {};
}

// --- shifting --------------------------------------------------------------------------------------------

template <class Primitive>
Shape shifted_primitive(const Primitive& primitive, const Vec3& origin) {
    return Compound{{CompoundPart{primitive, Pose{-origin, Quat::Identity()}}}};
}

Shape shifted_primitive(const Hull& hull, const Vec3& origin) {
    return Hull{std::make_shared<const Polytope>(moved(*hull.polytope, -origin))};
}

Shape shifted_primitive(const Compound& compound, const Vec3& origin) {
    Compound result = compound;
    for (CompoundPart& part : result.parts) {
        part.body_from_part.position -= origin;
    }
    return result;
}

Shape shifted_primitive(const Plane&, const Vec3&) {
    CHECK(!"a plane is shifted");
    return Plane{};
}

// --- bounding boxes --------------------------------------------------------------------------------------

/// |R| maps half extents to the half extents of the turned box's bounding box.
Bounds primitive_bounds(const Box& box, const Pose& pose) {
    const Vec3 reach = pose.orientation.toRotationMatrix().cwiseAbs() * box.half_extents;
    return {pose.position - reach, pose.position + reach};
}

Bounds primitive_bounds(const Sphere& sphere, const Pose& pose) {
    const Vec3 reach = Vec3::Constant(sphere.radius);
    return {pose.position - reach, pose.position + reach};
}

/// A disc across the unit vector z reaches r sqrt(1 - z_k^2) along axis k.
Bounds primitive_bounds(const Cylinder& cylinder, const Pose& pose) {
    const Vec3 z = pose.orientation * Vec3::UnitZ();
    const Vec3 across = (Vec3::Ones() - z.cwiseProduct(z)).cwiseMax(0.0).cwiseSqrt();
    const Vec3 reach = cylinder.half_length * z.cwiseAbs() + cylinder.radius * across;
    return {pose.position - reach, pose.position + reach};
}

Bounds primitive_bounds(const Capsule& capsule, const Pose& pose) {
    const Vec3 reach = capsule.half_length * (pose.orientation * Vec3::UnitZ()).cwiseAbs() +
                       Vec3::Constant(capsule.radius);
    return {pose.position - reach, pose.position + reach};
}

Bounds primitive_bounds(const Hull& hull, const Pose& pose) {
    const Mat3 turn = pose.orientation.toRotationMatrix();
    Vec3 lower = turn * hull.polytope->vertices[0];
    Vec3 upper = lower;
    for (const Vec3& vertex : hull.polytope->vertices) {
        const Vec3 x = turn * vertex;
        lower = lower.cwiseMin(x);
        upper = upper.cwiseMax(x);
    }
    return {pose.position + lower, pose.position + upper};
}

Bounds primitive_bounds(const Plane&, const Pose&) {
    return {};
}

Bounds primitive_bounds(const Compound& compound, const Pose& pose) {
    CHECK(!compound.parts.empty());
    Bounds result;
    for (std::size_t i = 0; i < compound.parts.size(); ++i) {
        const CompoundPart& part = compound.parts[i];
        const Pose world_from_part{pose * part.body_from_part.position,
                                   pose.orientation * part.body_from_part.orientation};
        const Bounds b = std::visit(
            [&](const auto& shape) { return primitive_bounds(shape, world_from_part); }, part.shape);
        result.lower = i == 0 ? b.lower : result.lower.cwiseMin(b.lower).eval();
        result.upper = i == 0 ? b.upper : result.upper.cwiseMax(b.upper).eval();
    }
    return result;
}

// --- JSON; fmt prints the shortest decimals that read back as the same doubles ---------------------------

std::string json_of(const Vec3& v) {
    return fmt::format("[{},{},{}]", v.x(), v.y(), v.z());
}

std::string primitive_json(const Plane&) {
    return R"({"kind":"plane"})";
}

std::string primitive_json(const Box& box) {
    return fmt::format(R"({{"kind":"box","half_extents":{}}})", json_of(box.half_extents));
}

std::string primitive_json(const Sphere& sphere) {
    return fmt::format(R"({{"kind":"sphere","radius":{}}})", sphere.radius);
}

std::string primitive_json(const Cylinder& cylinder) {
    return fmt::format(R"({{"kind":"cylinder","radius":{},"half_length":{}}})", cylinder.radius,
                       cylinder.half_length);
}

std::string primitive_json(const Capsule& capsule) {
    return fmt::format(R"({{"kind":"capsule","radius":{},"half_length":{}}})", capsule.radius,
                       capsule.half_length);
}

std::string primitive_json(const Hull& hull) {
    std::vector<std::string> points;
    for (const Vec3& vertex : hull.polytope->vertices) {
        points.push_back(json_of(vertex));
    }
    std::vector<std::string> faces;
    for (const Polytope::Face& face : hull.polytope->faces) {
        faces.push_back(fmt::format("[{}]", fmt::join(face.loop, ",")));
    }
    return fmt::format(R"({{"kind":"hull","points":[{}],"faces":[{}]}})", fmt::join(points, ","),
                       fmt::join(faces, ","));
}

std::string primitive_json(const Compound& compound) {
    std::string parts;
    for (const CompoundPart& part : compound.parts) {
        std::string text = std::visit([](const auto& shape) { return primitive_json(shape); }, part.shape);
        text.pop_back();
        const Quat& q = part.body_from_part.orientation;
        parts += fmt::format(R"({}{},"position":{},"orientation":[{},{},{},{}]}})", parts.empty() ? "" : ",",
                             text, json_of(part.body_from_part.position), q.w(), q.x(), q.y(), q.z());
    }
    return fmt::format(R"({{"kind":"compound","parts":[{}]}})", parts);
}

} // namespace

MassProperties mass_properties(const Shape& shape, double density) {
    return std::visit([&](const auto& s) { return primitive_mass(s, density); }, shape);
}

Shape shifted(const Shape& shape, const Vec3& origin) {
    if (origin.isZero(0.0)) {
        return shape;
    }
    return std::visit([&](const auto& s) { return shifted_primitive(s, origin); }, shape);
}

Bounds bounds(const Shape& shape, const Pose& world_from_body) {
    return std::visit([&](const auto& s) { return primitive_bounds(s, world_from_body); }, shape);
}

std::string shape_to_json(const Shape& shape) {
    return std::visit([](const auto& s) { return primitive_json(s); }, shape);
}

} // namespace sim
