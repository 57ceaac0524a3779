#pragma once
/// Convex polytopes: hulls of points, with their faces and edges.
#include "sim/base/math.h"

#include <optional>
#include <span>
#include <vector>

namespace sim {

/// A bounded convex body with flat faces. Coplanar neighbours are one face, no vertex lies within an edge.
struct Polytope {
    struct Edge {
        int from = 0; ///< vertex
        int to = 0;
        int left = 0; ///< face whose boundary runs along it, seen from outside
        int right = 0;
        Vec3 direction = Vec3::UnitX(); ///< unit
        Vec3 middle = Vec3::Zero();     ///< [m]
        double half_length = 0.0;       ///< [m]
    };
    struct Face {
        Vec3 normal = Vec3::UnitZ(); ///< unit, outwards
        int corner = 0;              ///< the first of its vertices, beside the normal for time only
        std::vector<int> loop;       ///< vertices, counter-clockwise seen from outside
    };
    /// What meets in each vertex.
    struct Around {
        std::vector<int> indices; ///< of the first vertex ascending, then of the next one
        std::vector<int> ends;    ///< [vertices] where its own end

        std::span<const int> of(int vertex) const {
            const auto v = static_cast<std::size_t>(vertex);
            const int begin = v == 0 ? 0 : ends[v - 1];
            return std::span(indices).subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(ends[v] - begin));
        }
    };

    /// Coordinates of two vertices [m]; the last one stands twice where their number is odd.
    struct TwoVertices {
        double x[2], y[2], z[2];
    };

    std::vector<Vec3> vertices; ///< [m]
    std::vector<TwoVertices> by_twos; ///< the same, for time only
    std::vector<Edge> edges;
    std::vector<Face> faces;
    Around edges_around;
    Around faces_around;
    Vec3 centre = Vec3::Zero();             ///< mean of the vertices [m]
    double radius = 0.0;                    ///< largest distance of a vertex from the origin [m]
};

/// The convex hull of finite points [m]; nothing if they lie in a plane, to 1e-9 of their extent. Points that
/// are no corners are left out.
std::optional<Polytope> convex_hull(std::span<const Vec3> points);

/// Corners at +-1.
const Polytope& unit_cube();

/// The same polytope with `offset` [m] added to its vertices.
Polytope moved(const Polytope& polytope, const Vec3& offset);

/// Volume integrals.
struct VolumeMoments {
    double volume = 0.0;          ///< [m^3]
    Vec3 centroid = Vec3::Zero(); ///< [m]
    Mat3 second = Mat3::Zero();   ///< integral of x x^T about the centroid [m^5]
};
VolumeMoments volume_moments(const Polytope& polytope);

} // namespace sim
