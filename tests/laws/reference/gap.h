#pragma once
/// Signed distances of simple convex solids, written apart from sim/ so that one can judge the other.
/// A gap is > 0 apart and < 0 overlapping; -gap is then the exact penetration: the shortest translation [m]
/// that parts the two solids.
#include <Eigen/Core>

#include <vector>

namespace reference {

using Vector = Eigen::Vector3d;
using Matrix = Eigen::Matrix3d;

struct OrientedBox {
    Vector centre = Vector::Zero();              ///< [m]
    Matrix axes = Matrix::Identity();            ///< unit edge directions in columns, world
    Vector half_extents = Vector::Constant(0.5); ///< [m]
};

struct Ball {
    Vector centre = Vector::Zero(); ///< [m]
    double radius = 0.5;            ///< [m]
};

/// A convex body with flat faces. Normals and edges may be repeated.
struct Polyhedron {
    std::vector<Vector> vertices; ///< [m]
    std::vector<Vector> normals;  ///< unit, of the faces, outwards
    std::vector<Vector> edges;    ///< unit
};

/// A cylinder, or with `rounding` a capsule (radius 0).
struct Rod {
    Vector centre = Vector::Zero(); ///< [m]
    Vector axis = Vector::UnitZ();  ///< unit
    double half_length = 0.5;       ///< [m]
    double radius = 0.5;            ///< [m]
    double rounding = 0.0;          ///< [m]
};

/// Farthest coordinate along a unit direction [m].
double highest(const Polyhedron& solid, const Vector& u);

/// All points x with (x - point) . normal <= 0.
struct HalfSpace {
    Vector point = Vector::Zero();   ///< [m]
    Vector normal = Vector::UnitZ(); ///< unit, out of the solid
};

/// Exact penetration by the separating axes of two boxes (6 face normals, 9 edge pairs). Where the boxes are
/// apart the value is the largest separation along these axes, a lower bound of their distance.
double gap(const OrientedBox& a, const OrientedBox& b);
double gap(const OrientedBox& box, const HalfSpace& solid);
double gap(const Ball& ball, const OrientedBox& box);
double gap(const Ball& ball, const HalfSpace& solid);
double gap(const Ball& a, const Ball& b);
/// The same with all faces and all pairs of edges.
double gap(const Polyhedron& a, const Polyhedron& b);
double gap(const Polyhedron& a, const OrientedBox& b);
double gap(const Polyhedron& a, const HalfSpace& solid);
double gap(const Ball& ball, const Polyhedron& solid);
double gap(const Rod& rod, const HalfSpace& solid);
/// A search over all directions, to about 1e-9 m: never less deep than the solids are.
double gap(const Rod& a, const Rod& b);
double gap(const Rod& rod, const OrientedBox& solid);
double gap(const Rod& rod, const Polyhedron& solid);
double gap(const Rod& rod, const Ball& ball);

} // namespace reference
