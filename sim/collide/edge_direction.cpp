#include "sim/collide/edge_direction.h"

#include "sim/model/polytope.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Edges whose cross product is shorter than this [-] are parallel.
constexpr double parallel_directions = 1e-9;

/// Unit vector of what `between` has across the unit vector `along`; any, if it has nothing.
Vec3 direction_across(const Vec3& along, const Vec3& between) {
    const Vec3 across = between - along * along.dot(between);
    return across.norm() > 0.0 ? Vec3(across.stableNormalized()) : Vec3(along.unitOrthogonal());
}

/// Do the arc of the normals of an edge of a, turned round, and that of an edge of b meet on the unit sphere?
bool arcs_cross(const EdgeNormals& of_a, const EdgeNormals& of_b) {
    const auto parts = [](const EdgeNormals& one, const EdgeNormals& other) { // the plane of the one arc the ends of the other
        return one.across.dot(other.left) * one.across.dot(other.right) <= parallel_directions;
    };
    return parts(of_a, of_b) && parts(of_b, of_a) && (of_a.left + of_a.right).dot(of_b.left + of_b.right) < 1.0;
}

} // namespace

void find_edge_normals(const Convex& convex, const std::vector<CoreFeature>& features, std::vector<EdgeNormals>& normals) {
    if (convex.kind != CoreKind::polytope) {
        normals.assign(features.size(), {});
        return;
    }
    const auto normal_of = [&](int face) { return convex.turned(convex.polytope->faces[static_cast<std::size_t>(face)].normal); };
    normals.resize(features.size());
    for (std::size_t i = 0; i < features.size(); ++i) {
        if (features[i].kind == CoreFeature::Kind::edge) {
            const Polytope::Edge& edge = convex.polytope->edges[static_cast<std::size_t>(features[i].index)];
            normals[i].left = normal_of(edge.left);
            normals[i].right = normal_of(edge.right);
            normals[i].across = normals[i].left.cross(normals[i].right);
        }
    }
}

Vec3 edge_direction(const CoreFeature& fa, const CoreFeature& fb, const EdgeNormals& of_a, const EdgeNormals& of_b) {
    const Vec3 between = fa.point - fb.point;
    const Vec3 cross = fa.direction.cross(fb.direction);
    if (cross.squaredNorm() < parallel_directions * parallel_directions) {
        return direction_across(fa.direction, between);
    }
    if (!arcs_cross(of_a, of_b)) {
        return Vec3::Zero();
    }
    const Vec3 n = cross.normalized();
    const Vec3 outward = (of_b.left + of_b.right) - (of_a.left + of_a.right);
    const double side = outward.isZero(0.0) ? n.dot(between) : n.dot(outward);
    return side >= 0.0 ? n : Vec3(-n);
}

double inside_of_ends(const CoreFeature& fa, const CoreFeature& fb) {
    const Vec3 cross = fa.direction.cross(fb.direction);
    const Vec3 between = fb.point - fa.point;
    const double scale = cross.squaredNorm();
    if (scale <= parallel_directions * parallel_directions) {
        return -1.0;
    }
    return std::min(fa.length * scale - std::abs(between.cross(fb.direction).dot(cross)),
                    fb.length * scale - std::abs(between.cross(fa.direction).dot(cross))) /
           std::sqrt(scale);
}

} // namespace sim
