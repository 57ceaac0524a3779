/// Gaps of cylinders and capsules to other solids, by a search over all directions.
#include "tests/laws/reference/gap.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace reference {
namespace {

constexpr int scattered_directions = 100; ///< over the sphere, to begin with
constexpr std::size_t searches = 6;       ///< from the best of them
constexpr double first_turn = 0.1;        ///< [rad] of a search
constexpr double last_turn = 1e-10;       ///< [rad]
constexpr double shrinking = 0.6;         ///< of the turn where none leads up [-]
constexpr int ways = 12;                  ///< tried at each turn

/// Farthest coordinate of the solid along a unit direction [m].
double highest(const OrientedBox& box, const Vector& u) {
    return u.dot(box.centre) + (box.axes.transpose() * u).cwiseAbs().dot(box.half_extents);
}
double highest(const Ball& ball, const Vector& u) {
    return u.dot(ball.centre) + ball.radius;
}
double highest(const Rod& rod, const Vector& u) {
    const double along = rod.axis.dot(u);
    return u.dot(rod.centre) + rod.half_length * std::abs(along) + rod.radius * rod.axis.cross(u).norm() + rod.rounding;
}

/// Directions that single out features of a solid.
void add_directions(const OrientedBox& box, std::vector<Vector>& directions) {
    for (int i = 0; i < 3; ++i) {
        directions.push_back(box.axes.col(i));
    }
}
void add_directions(const Ball&, std::vector<Vector>&) {}
void add_directions(const Polyhedron& solid, std::vector<Vector>& directions) {
    directions.insert(directions.end(), solid.normals.begin(), solid.normals.end());
}
void add_directions(const Rod& rod, std::vector<Vector>& directions) {
    directions.push_back(rod.axis);
}

Vector centre_of(const OrientedBox& box) {
    return box.centre;
}
Vector centre_of(const Ball& ball) {
    return ball.centre;
}
Vector centre_of(const Polyhedron& solid) {
    Vector sum = Vector::Zero();
    for (const Vector& vertex : solid.vertices) {
        sum += vertex;
    }
    return sum / static_cast<double>(solid.vertices.size());
}

/// Edges or axes, whose cross products with a rod's axis are directions of contact.
void add_edges(const OrientedBox& box, std::vector<Vector>& edges) {
    add_directions(box, edges);
}
void add_edges(const Ball&, std::vector<Vector>&) {}
void add_edges(const Polyhedron& solid, std::vector<Vector>& edges) {
    edges.insert(edges.end(), solid.edges.begin(), solid.edges.end());
}
void add_edges(const Rod& rod, std::vector<Vector>& edges) {
    edges.push_back(rod.axis);
}
Vector centre_of(const Rod& rod) {
    return rod.centre;
}

/// The largest separation along any direction is the gap. A direction that is not quite the best says less: a search
/// that ends too soon finds the solids deeper in each other than they are, and never less.
template <class A, class B>
double searched_gap(const A& a, const B& b) {
    const auto separation = [&](const Vector& n) { return -highest(a, -n) - highest(b, n); };
    struct Start {
        double value;
        Vector n;
    };
    std::vector<Start> starts;
    const auto add = [&](const Vector& direction) {
        const double length = direction.norm();
        if (length > 1e-9) {
            const Vector n = direction / length;
            starts.push_back({separation(n), n});
            starts.push_back({separation(-n), -n});
        }
    };
    std::vector<Vector> singled, edges_a, edges_b;
    add_directions(a, singled);
    add_directions(b, singled);
    add_edges(a, edges_a);
    add_edges(b, edges_b);
    singled.push_back(centre_of(a) - centre_of(b));
    for (const Vector& edge_a : edges_a) {
        for (const Vector& edge_b : edges_b) {
            singled.push_back(edge_a.cross(edge_b));
        }
    }
    for (const Vector& direction : singled) {
        add(direction);
    }
    constexpr double golden_angle = std::numbers::pi * (3.0 - 2.2360679774997896);
    for (int i = 0; i < scattered_directions; ++i) { // half of a Fibonacci sphere, for both signs are tried
        const double z = (i + 0.5) / scattered_directions;
        const double r = std::sqrt(1.0 - z * z);
        add(Vector(r * std::cos(golden_angle * i), r * std::sin(golden_angle * i), z));
    }
    const std::size_t kept = std::min(searches, starts.size());
    std::partial_sort(starts.begin(), starts.begin() + static_cast<std::ptrdiff_t>(kept), starts.end(),
                      [](const Start& x, const Start& y) { return x.value > y.value; });
    edges_a.insert(edges_a.end(), edges_b.begin(), edges_b.end());
    double largest = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < kept; ++k) {
        double best = starts[k].value;
        Vector n = starts[k].n;
        const auto improves = [&](const Vector& direction, double turn) {
            const Vector tried = (n + turn * direction).normalized();
            const double value = separation(tried);
            const bool is_better = value > best;
            n = is_better ? tried : n;
            best = is_better ? value : best;
            return is_better;
        };
        double phase = 0.0;
        for (double turn = first_turn; turn > last_turn;) {
            const Vector across = n.unitOrthogonal();
            const Vector other = n.cross(across);
            bool found = false;
            for (int i = 0; i < ways && !found; ++i) {
                const double angle = phase + 2.0 * std::numbers::pi * i / ways;
                found = improves(std::cos(angle) * across + std::sin(angle) * other, turn);
            }
            // The separation has ridges across edges and axes: along those.
            for (std::size_t i = 0; i < edges_a.size() && !found; ++i) {
                const Vector along = n.cross(edges_a[i]);
                const double length = along.norm();
                found = length > 1e-9 && (improves(along / length, turn) || improves(-along / length, turn));
            }
            phase += golden_angle;
            turn *= found ? 1.0 : shrinking;
        }
        largest = std::max(largest, best);
    }
    return largest;
}

} // namespace

double gap(const Rod& a, const Rod& b) {
    return searched_gap(a, b);
}
double gap(const Rod& rod, const OrientedBox& solid) {
    return searched_gap(rod, solid);
}
double gap(const Rod& rod, const Polyhedron& solid) {
    return searched_gap(rod, solid);
}
double gap(const Rod& rod, const Ball& ball) {
    return searched_gap(rod, ball);
}

} // namespace reference
