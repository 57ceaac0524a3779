#pragma once
/// A convex part of a body, placed in the world: how far it reaches along a direction, and the features that face
/// it.
#include "sim/collide/manifold.h"

#include <vector>

namespace sim {

struct Polytope;

/// What is left of a shape when the ball that rounds it is taken off.
enum class CoreKind { point, segment, cylinder, polytope };

/// Sphere: a point with `rounding`; capsule: a segment along z with `rounding`; box and hull: polytopes.
struct Convex {
    CoreKind kind = CoreKind::point;
    double rounding = 0.0;               ///< [m]
    double radius = 0.0;                 ///< [m] of a cylinder
    double half_length = 0.0;            ///< [m] of a segment or cylinder
    const Polytope* polytope = nullptr;  ///< its vertices are multiplied by `scale`
    Vec3 scale = Vec3::Ones();           ///< [-], half extents [m] of a box
    double size = 0.0;                   ///< [m] the core lies within this distance of the part's origin
    Pose world_from_body;
    Pose body_from_part;
    Pose world_from_part;
    Mat3 turn = Mat3::Identity();        ///< rotation of world_from_part

    Vec3 axis() const { return turn.col(2); }
    Vec3 centre() const;      ///< about the middle of the core [m], world
    Vec3 vertex(int i) const; ///< of a polytope [m], world
    /// A point of the polytope in the world [m]; x: in its frame, before it is scaled.
    Vec3 placed(const Vec3& x) const { return world_from_part.position + turned(scale.cwiseProduct(x)); }
    Vec3 turned(const Vec3& x) const { return turn.col(0) * x[0] + turn.col(1) * x[1] + turn.col(2) * x[2]; }
};

Convex placed(const PrimitiveShape& shape, const Pose& world_from_body, const Pose& body_from_part);

/// Largest u . x over the core, x from the part's origin [m]. u: unit, world.
double support_height(const Convex& convex, const Vec3& u);

/// A point of the core where it is reached [m], world.
Vec3 support_point(const Convex& convex, const Vec3& u);

/// The same as the index of a polytope's vertex.
int support_vertex(const Convex& convex, const Vec3& u);

/// The middle [m], world, of all points of the core that reach as far along u, but for `slack` [m]: of a face, an edge, an end.
Vec3 support_middle(const Convex& convex, const Vec3& u, double slack);

/// A smooth piece of the core's surface. Its point lies on it (rim: its centre; cylinder's side: on its axis).
struct CoreFeature {
    enum class Kind { vertex, edge, rim, face } kind = Kind::vertex;
    int index = 0;                  ///< among those of its kind
    Vec3 point = Vec3::Zero();      ///< [m], world
    Vec3 direction = Vec3::Zero();  ///< unit, world: along the edge, out of the face, axis of the rim
    double radius = 0.0;            ///< [m] of a rim; of a cylinder's side, which is an edge with a radius
    double length = 0.0;            ///< [m] half of an edge; its point is the middle
};

/// Features whose outward directions may be near u: those that meet in the support point, within rounding; with_edges: a polytope's
/// edges, too.
void near_features(const Convex& convex, const Vec3& u, std::vector<CoreFeature>& features, bool with_edges = true);

/// Faces whose outward directions are nearer to u than this [-] (cosine).
void faces_along(const Convex& convex, const Vec3& u, double cosine, std::vector<CoreFeature>& features);

} // namespace sim
