#include "sim/scene/shape.h"

#include "sim/base/error.h"
#include "sim/base/random.h"
#include "sim/model/obj_file.h"
#include "sim/model/polytope.h"
#include "sim/scene/inlined.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

namespace sim {

namespace {

/// Order of the choices of the key "kind".
enum class ShapeKind { box, sphere, cylinder, capsule, hull, rock, plane, compound };
constexpr std::array<std::string_view, 8> kind_names{"box",  "sphere", "cylinder", "capsule",
                                                     "hull", "rock",   "plane",    "compound"};

/// More points would take minutes to wrap.
constexpr std::size_t most_points = 10000;

/// The kind alone, read ahead of the section it selects. group: "shape" or "part".
ShapeKind read_kind(const TextSource& source, const TreeNode& node, std::string_view group,
                    const std::string& title) {
    TreeNode only_kind = node;
    std::erase_if(only_kind.children, [](const TreeNode& child) { return child.key != "kind"; });
    Section section(source, only_kind, scene_section(fmt::format("{} box", group)), title);
    return static_cast<ShapeKind>(section.choice("kind"));
}

Box read_box(Section& section) {
    if (section.has("half_extents") == section.has("size")) {
        section.fail("size", section.has("size") ? "expected half_extents or size, not both"
                                                 : "half_extents or size is missing, expected one of them");
    }
    return Box{section.has("size") ? Vec3(section.vector("size") / 2.0) : section.vector("half_extents")};
}

Hull hull_of(const Section& section, const std::string& key, const std::vector<Vec3>& points) {
    if (points.size() < 4 || points.size() > most_points) {
        section.fail(key, fmt::format("{} has {} points, expected 4 to {}", key, points.size(), most_points));
    }
    std::optional<Polytope> polytope = convex_hull(points);
    if (!polytope) {
        section.fail(key, fmt::format("the {} points of {} lie in one plane, expected a hull with a volume",
                                      points.size(), key));
    }
    return Hull{std::make_shared<const Polytope>(std::move(*polytope))};
}

Hull read_hull(Section& section) {
    if (section.has("points") == section.has("file")) {
        section.fail("points", section.has("points") ? "expected points or file, not both"
                                                     : "points or file is missing, expected one of them");
    }
    const std::string key = section.has("points") ? "points" : "file";
    const std::vector<Vec3> points = section.has("points") ? section.points("points") : read_beside(section, "file", obj_points);
    return hull_of(section, key, points);
}

/// Tries of random points for a rock: four nearly always span a volume.
constexpr int most_tries = 100;

/// Random points on an ellipsoid: some shapes are rounder, some longer.
Hull read_rock(Section& section, std::int64_t index) {
    const Vec3 half = 0.5 * section.vector("size");
    const int corners = section.integer("corners");
    Random random(static_cast<std::uint64_t>(section.long_integer("seed") + index));
    for (int i = 0; i < most_tries; ++i) {
        std::vector<Vec3> points;
        for (int k = 0; k < corners; ++k) {
            points.push_back(random.direction().cwiseProduct(half));
        }
        if (std::optional<Polytope> polytope = convex_hull(points)) {
            return Hull{std::make_shared<const Polytope>(std::move(*polytope))};
        }
    }
    section.fail("size", fmt::format("size is {:.3g} by {:.3g} by {:.3g} m, expected a rock that is not flat and whose "
                                     "squares are numbers",
                                     2.0 * half.x(), 2.0 * half.y(), 2.0 * half.z()));
}

/// A shape of one piece.
PrimitiveShape read_primitive(ShapeKind kind, Section& section, std::int64_t index) {
    section.choice("kind");
    switch (kind) {
    case ShapeKind::sphere:
        return Sphere{section.number("radius")};
    case ShapeKind::cylinder:
        return Cylinder{section.number("radius"), 0.5 * section.number("length")};
    case ShapeKind::capsule:
        return Capsule{section.number("radius"), 0.5 * section.number("length")};
    case ShapeKind::hull:
        return read_hull(section);
    case ShapeKind::rock:
        return read_rock(section, index);
    default:
        return read_box(section);
    }
}

CompoundPart read_part(const TextSource& source, const TreeNode& node, const std::string& title,
                       std::int64_t index) {
    const ShapeKind kind = read_kind(source, node, "part", title);
    if (kind == ShapeKind::plane || kind == ShapeKind::compound) {
        fail_at(source, node.find("kind")->place,
                fmt::format("{}: kind is {}, expected a bounded shape of one piece in a compound", title,
                            describe_value(*node.find("kind"))));
    }
    Section section(source, node,
                    scene_section(fmt::format("part {}", kind_names[static_cast<std::size_t>(kind)])), title);
    const PrimitiveShape shape = read_primitive(kind, section, index);
    return {shape, {section.vector("position"), read_orientation(section)}};
}

/// A rock, or a compound with one.
bool is_random(const TreeNode& shape) {
    const TreeNode* kind = shape.find("kind");
    const TreeNode* parts = shape.find("parts");
    return (kind != nullptr && kind->text == "rock") || (parts != nullptr && std::ranges::any_of(parts->children, is_random));
}

} // namespace

Quat read_orientation(Section& section) {
    constexpr std::array<std::string_view, 3> ways{"orientation", "axis_angle_degrees", "euler_degrees"};
    const auto given = [&](std::string_view key) { return section.has(key); };
    if (std::ranges::count_if(ways, given) > 1) {
        section.fail(*std::ranges::find_if(ways, given),
                     "expected only one of orientation, axis_angle_degrees and euler_degrees");
    }
    if (section.has("orientation")) {
        return section.quaternion("orientation");
    }
    if (section.has("axis_angle_degrees")) {
        return section.axis_angle("axis_angle_degrees");
    }
    if (section.has("euler_degrees")) {
        const Vec3 angles = section.vector("euler_degrees") * (std::numbers::pi / 180.0);
        return Eigen::AngleAxisd(angles.z(), Vec3::UnitZ()) * Eigen::AngleAxisd(angles.y(), Vec3::UnitY()) *
               Eigen::AngleAxisd(angles.x(), Vec3::UnitX());
    }
    return Quat::Identity();
}

Shape read_shape(const TextSource& source, const TreeNode& node, const std::string& title, std::int64_t index) {
    const ShapeKind kind = read_kind(source, node, "shape", title);
    Section section(source, node,
                    scene_section(fmt::format("shape {}", kind_names[static_cast<std::size_t>(kind)])), title);
    if (kind == ShapeKind::plane) {
        return Plane{};
    }
    if (kind != ShapeKind::compound) {
        return std::visit([](const auto& primitive) { return Shape(primitive); },
                          read_primitive(kind, section, index));
    }
    Compound compound;
    if (section.has("parts") == section.has("file")) {
        section.fail("parts", section.has("parts") ? "expected parts or file, not both"
                                                   : "parts or file is missing, expected one of them");
    }
    if (section.has("file")) {
        for (const std::vector<Vec3>& group : read_beside(section, "file", obj_groups)) {
            compound.parts.push_back({hull_of(section, "file", group), {}});
        }
        if (compound.parts.empty()) {
            section.fail("file", "file has no group of faces, expected at least one");
        }
        return compound;
    }
    for (const TreeNode* part : section.tables("parts")) {
        compound.parts.push_back(
            read_part(source, *part, fmt::format("{} part {}", title, compound.parts.size()), index));
    }
    if (compound.parts.empty()) {
        section.fail("parts", "parts is an empty array, expected at least one part");
    }
    return compound;
}

bool is_random_shape(const TreeNode& body) {
    for (const char* key : {"shape", "drawn"}) {
        const TreeNode* shape = body.find(key);
        if (shape != nullptr && is_random(*shape)) {
            return true;
        }
    }
    return false;
}

} // namespace sim
