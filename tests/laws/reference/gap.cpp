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

} // namespace reference
