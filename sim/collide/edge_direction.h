#pragma once
/// The separating direction of two edges.
#include "sim/collide/convex.h"

namespace sim {

/// Outward normals of the faces that an edge of a polytope joins, and their cross product; world.
struct EdgeNormals {
    Vec3 left = Vec3::Zero();
    Vec3 right = Vec3::Zero();
    Vec3 across = Vec3::Zero();
};

/// Of those of the features that are edges [features]; all zero where no polytope has them.
void find_edge_normals(const Convex& convex, const std::vector<CoreFeature>& features, std::vector<EdgeNormals>& normals);

/// The unit vector from b to a across both edges, where the arcs of their outward normals, if they have any, cross. Zero: there is
/// none.
Vec3 edge_direction(const CoreFeature& fa, const CoreFeature& fb, const EdgeNormals& of_a, const EdgeNormals& of_b);

/// How far inside the ends of both the points lie at which two edges come nearest to each other, across the other one [m];
/// negative beyond an end, and of parallel ones.
double inside_of_ends(const CoreFeature& fa, const CoreFeature& fb);

} // namespace sim
