#pragma once
/// The direction along which two convex cores are farthest apart, or least deep in each other.
#include "sim/collide/convex.h"

namespace sim {

/// For every unit vector n the cores' gap along it is s(n) = min over a of n . x - max over b of n . x. Its largest
/// value is the distance where they are apart and minus the depth where they overlap. The direction of the largest
/// value belongs to a pair of features: a face of one, or two edges, rims or vertices.
struct SeparatingDirection {
    Vec3 n = Vec3::UnitZ(); ///< unit, from b to a
    double core_gap = 0.0;  ///< s(n) [m], of the cores: without rounding
    bool is_face_of_a = false;
    bool is_face_of_b = false;
    CoreFeature a; ///< a face of a: only this one counts; the same for b
    CoreFeature b;

    bool is_face() const { return is_face_of_a || is_face_of_b; }
};

/// Crossing edges whose normal is this near [-] (cosine) to a face's: the faces are about to meet, and within one
/// step the contact may pass from the edges to the faces' corners.
constexpr double nearly_flat = 0.998;

/// Gaps that differ by less than this share [-] of the size are one: a face is preferred to the edges near it, and faces that rest on
/// each other keep their contacts from step to step.
constexpr double same_gap = 1e-9;

/// The direction, and the best direction of a face near it (for bodies that are about to meet flat).
struct Separation {
    SeparatingDirection best;
    SeparatingDirection best_face; ///< is_face() false: there is none as near as nearly_flat
    bool is_beyond = false;        ///< the search ended early: the gap exceeds `enough`, by best.core_gap at least
};

/// enough [m]: the search may end where the gap of the cores is known to be larger. near: where it begins, as where it ended in the
/// last step; null: anywhere.
Separation find_separation(const Convex& a, const Convex& b, double enough, const Vec3* near);

/// s(n) [m].
double core_gap(const Convex& a, const Convex& b, const Vec3& n);

/// n of the largest s(n); where that is larger than `enough` [m], one of which s(n) is, too.
Vec3 find_direction(const Convex& a, const Convex& b, double enough);

} // namespace sim
