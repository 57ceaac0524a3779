#include "tests/laws/reference/gap.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>

namespace reference {
namespace {

/// Half the length of the box's projection on a unit direction [m].
double half_width(const OrientedBox& box, const Vector& direction) {
    return (box.axes.transpose() * direction).cwiseAbs().dot(box.half_extents);
}

/// Separation of the two boxes along a unit direction, of either sign [m].
double separation(const OrientedBox& a, const OrientedBox& b, const Vector& direction) {
    const double distance = std::abs((a.centre - b.centre).dot(direction));
    return distance - half_width(a, direction) - half_width(b, direction);
}

} // namespace

double gap(const OrientedBox& a, const OrientedBox& b) {
    // Any unit direction gives a separation that is at most the true one, so an axis spoilt by rounding can
    // only be useless, never wrong. Edges whose cross product is shorter than this are parallel to within it,
    // and the face normals then give the depth to within parallel * (half diagonal), far below any tolerance.
    constexpr double parallel = 1e-12; // [-] sine of the angle between the edges
    double largest = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < 3; ++i) {
        largest = std::max(largest, separation(a, b, a.axes.col(i)));
        largest = std::max(largest, separation(a, b, b.axes.col(i)));
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const Vector cross = a.axes.col(i).cross(b.axes.col(j));
            const double length = cross.norm();
            if (length > parallel) {
                largest = std::max(largest, separation(a, b, cross / length));
            }
        }
    }
    return largest;
}

double gap(const OrientedBox& box, const HalfSpace& solid) {
    return (box.centre - solid.point).dot(solid.normal) - half_width(box, solid.normal);
}

double gap(const Ball& ball, const OrientedBox& box) {
    const Vector centre = box.axes.transpose() * (ball.centre - box.centre);
    const Vector beyond = centre.cwiseAbs() - box.half_extents; // > 0: outside that pair of faces
    const double inside = beyond.maxCoeff();
    return (inside > 0.0 ? beyond.cwiseMax(0.0).norm() : inside) - ball.radius;
}

double gap(const Ball& ball, const HalfSpace& solid) {
    return (ball.centre - solid.point).dot(solid.normal) - ball.radius;
}

double gap(const Ball& a, const Ball& b) {
    return (a.centre - b.centre).norm() - a.radius - b.radius;
}

double highest(const Polyhedron& solid, const Vector& u) {
    double h = -std::numeric_limits<double>::infinity();
    for (const Vector& vertex : solid.vertices) {
        h = std::max(h, vertex.dot(u));
    }
    return h;
}

namespace {

Polyhedron polyhedron_of(const OrientedBox& box) {
    Polyhedron solid;
    for (int i = 0; i < 8; ++i) {
        const Vector sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
        solid.vertices.push_back(box.centre + box.axes * sign.cwiseProduct(box.half_extents));
    }
    for (int k = 0; k < 3; ++k) {
        solid.edges.push_back(box.axes.col(k));
        solid.normals.push_back(box.axes.col(k));
        solid.normals.push_back(-box.axes.col(k));
    }
    return solid;
}

} // namespace

double gap(const Polyhedron& a, const Polyhedron& b) {
    double largest = -std::numeric_limits<double>::infinity();
    for (const Vector& n : a.normals) {
        largest = std::max(largest, -highest(b, -n) - highest(a, n));
    }
    for (const Vector& n : b.normals) {
        largest = std::max(largest, -highest(a, -n) - highest(b, n));
    }
    for (const Vector& x : a.edges) {
        for (const Vector& y : b.edges) {
            Vector n = x.cross(y);
            if (n.norm() < 1e-6) {
                continue; // parallel edges say what faces say
            }
            n.normalize();
            largest = std::max({largest, -highest(a, -n) - highest(b, n), -highest(b, -n) - highest(a, n)});
        }
    }
    return largest;
}

double gap(const Polyhedron& a, const OrientedBox& b) {
    return gap(a, polyhedron_of(b));
}

double gap(const Polyhedron& a, const HalfSpace& solid) {
    return -highest(a, -solid.normal) - solid.normal.dot(solid.point);
}

/// From the centre to the nearest vertex, edge or face; inside, to the nearest face.
double gap(const Ball& ball, const Polyhedron& solid) {
    double largest = -std::numeric_limits<double>::infinity();
    const auto try_direction = [&](const Vector& n) {
        largest = std::max(largest, n.dot(ball.centre) - highest(solid, n));
    };
    for (const Vector& n : solid.normals) {
        try_direction(n);
    }
    for (const Vector& vertex : solid.vertices) {
        const Vector to_centre = ball.centre - vertex;
        try_direction(to_centre.normalized());
        for (const Vector& edge : solid.edges) {
            try_direction((to_centre - edge * edge.dot(to_centre)).normalized());
        }
    }
    return largest - ball.radius;
}

double gap(const Rod& rod, const HalfSpace& solid) {
    const double along = rod.axis.dot(solid.normal);
    return solid.normal.dot(rod.centre - solid.point) - rod.half_length * std::abs(along) -
           rod.radius * std::sqrt(std::max(1.0 - along * along, 0.0)) - rod.rounding;
}

} // namespace reference
