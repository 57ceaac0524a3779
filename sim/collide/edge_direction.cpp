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
    const double b_left = of_a.across.dot(of_b.left);
    const double b_right = of_a.across.dot(of_b.right);
    const double a_left = -of_b.across.dot(of_a.left);
    const double a_right = -of_b.across.dot(of_a.right);
    return b_left * b_right <= parallel_directions && a_left * a_right <= parallel_directions &&
           (of_a.left + of_a.right).dot(of_b.left + of_b.right) < 1.0;
}

} // namespace

void find_edge_normals(const Convex& convex, const std::vector<CoreFeature>& features, std::vector<EdgeNormals>& normals) {
    normals.assign(features.size(), {});
    for (std::size_t i = 0; convex.kind == CoreKind::polytope && i < features.size(); ++i) {
        if (features[i].kind == CoreFeature::Kind::edge) {
            const Polytope::Edge& edge = convex.polytope->edges[static_cast<std::size_t>(features[i].index)];
            const Vec3& left = convex.polytope->faces[static_cast<std::size_t>(edge.left)].normal;
            const Vec3& right = convex.polytope->faces[static_cast<std::size_t>(edge.right)].normal;
            normals[i] = {convex.turned(left), convex.turned(right), convex.turned(left + right), {}};
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
    const Vec3 outward = of_b.sum - of_a.sum;
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
