#include "tests/laws/reference/overlap.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace reference {
namespace {

using Shape = decltype(Piece::shape);

/// The piece's shape in the world.
Shape placed(const Shape& shape, const Placement& placement) {
    const Matrix rotation = placement.orientation.normalized().toRotationMatrix();
    if (const auto* box = std::get_if<OrientedBox>(&shape)) {
        return OrientedBox{rotation * box->centre + placement.position, rotation * box->axes,
                           box->half_extents};
    }
    if (const auto* ball = std::get_if<Ball>(&shape)) {
        return Ball{rotation * ball->centre + placement.position, ball->radius};
    }
    if (const auto* rod = std::get_if<Rod>(&shape)) {
        return Rod{rotation * rod->centre + placement.position, rotation * rod->axis, rod->half_length, rod->radius,
                   rod->rounding};
    }
    if (const auto* polyhedron = std::get_if<Polyhedron>(&shape)) {
        Polyhedron result = *polyhedron;
        for (Vector& vertex : result.vertices) {
            vertex = rotation * vertex + placement.position;
        }
        for (std::vector<Vector>* directions : {&result.normals, &result.edges}) {
            for (Vector& direction : *directions) {
                direction = rotation * direction;
            }
        }
        return result;
    }
    const auto& solid = std::get<HalfSpace>(shape);
    return HalfSpace{rotation * solid.point + placement.position, rotation * solid.normal};
}

double shape_gap(const Shape& a, const Shape& b) {
    return std::visit(
        [](const auto& x, const auto& y) -> double {
            if constexpr (requires { gap(x, y); }) {
                return gap(x, y);
            } else if constexpr (requires { gap(y, x); }) {
                return gap(y, x);
            } else {
                return std::numeric_limits<double>::infinity(); // two half spaces, both static
            }
        },
        a, b);
}

struct Extent {
    Vector lower, upper; ///< [m]
};

/// Axis-aligned extent of a placed shape.
Extent extent(const Shape& shape) {
    if (const auto* box = std::get_if<OrientedBox>(&shape)) {
        const Vector reach = box->axes.cwiseAbs() * box->half_extents;
        return {box->centre - reach, box->centre + reach};
    }
    if (const auto* ball = std::get_if<Ball>(&shape)) {
        return {ball->centre - Vector::Constant(ball->radius), ball->centre + Vector::Constant(ball->radius)};
    }
    if (const auto* rod = std::get_if<Rod>(&shape)) {
        const Vector reach = Vector::Constant(rod->radius + rod->rounding) + rod->half_length * rod->axis.cwiseAbs();
        return {rod->centre - reach, rod->centre + reach};
    }
    if (const auto* polyhedron = std::get_if<Polyhedron>(&shape)) {
        Extent result{polyhedron->vertices.at(0), polyhedron->vertices.at(0)};
        for (const Vector& vertex : polyhedron->vertices) {
            result.lower = result.lower.cwiseMin(vertex);
            result.upper = result.upper.cwiseMax(vertex);
        }
        return result;
    }
    const double infinity = std::numeric_limits<double>::infinity();
    return {Vector::Constant(-infinity), Vector::Constant(infinity)};
}

struct PlacedBody {
    std::vector<Shape> shapes;
    Extent extent;
};

PlacedBody place_body(const Solid& solid, const Placement& placement, double margin) {
    PlacedBody body;
    const double infinity = std::numeric_limits<double>::infinity();
    body.extent = {Vector::Constant(infinity), Vector::Constant(-infinity)};
    for (const Piece& piece : solid.pieces) {
        body.shapes.push_back(placed(piece.shape, placement));
        const Extent e = extent(body.shapes.back());
        body.extent.lower = body.extent.lower.cwiseMin(e.lower);
        body.extent.upper = body.extent.upper.cwiseMax(e.upper);
    }
    body.extent.lower.array() -= margin / 2;
    body.extent.upper.array() += margin / 2;
    return body;
}

double body_gap(const PlacedBody& a, const PlacedBody& b) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Shape& shape_a : a.shapes) {
        for (const Shape& shape_b : b.shapes) {
            smallest = std::min(smallest, shape_gap(shape_a, shape_b));
        }
    }
    return smallest;
}

bool overlap_in_yz(const Extent& a, const Extent& b) {
    return a.lower.y() <= b.upper.y() && b.lower.y() <= a.upper.y() && a.lower.z() <= b.upper.z() &&
           b.lower.z() <= a.upper.z();
}

/// Whether the straight path from p to q enters the placed shape.
bool path_enters(const Shape& shape, const Vector& p, const Vector& q) {
    if (const auto* solid = std::get_if<HalfSpace>(&shape)) {
        return (q - solid->point).dot(solid->normal) < 0.0;
    }
    const auto* box = std::get_if<OrientedBox>(&shape);
    if (!box) {
        return false;
    }
    // Clip the path's parameter range against the three pairs of faces.
    const Vector start = box->axes.transpose() * (p - box->centre);
    const Vector way = box->axes.transpose() * (q - p);
    double from = 0.0, to = 1.0;
    for (int i = 0; i < 3; ++i) {
        if (way[i] == 0.0) {
            if (std::abs(start[i]) > box->half_extents[i]) {
                return false;
            }
            continue;
        }
        const double s0 = (-box->half_extents[i] - start[i]) / way[i];
        const double s1 = (box->half_extents[i] - start[i]) / way[i];
        from = std::max(from, std::min(s0, s1));
        to = std::min(to, std::max(s0, s1));
    }
    return from < to;
}

} // namespace

double pair_gap(const Solid& a, const Placement& at_a, const Solid& b, const Placement& at_b) {
    return body_gap(place_body(a, at_a, 0.0), place_body(b, at_b, 0.0));
}

std::vector<PairGap> near_pairs(const std::vector<Solid>& solids, const std::vector<Placement>& placements,
                                double margin, const ExcludedPairs& excluded) {
    std::vector<PlacedBody> bodies;
    bodies.reserve(solids.size());
    for (std::size_t i = 0; i < solids.size(); ++i) {
        bodies.push_back(place_body(solids[i], placements[i], margin));
    }
    // Sweep along x: a body meets only those that begin before it ends.
    std::vector<int> order(solids.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int i, int j) {
        return std::pair(bodies[i].extent.lower.x(), i) < std::pair(bodies[j].extent.lower.x(), j);
    });
    std::vector<PairGap> found;
    for (std::size_t s = 0; s < order.size(); ++s) {
        for (std::size_t t = s + 1; t < order.size(); ++t) {
            const int a = std::min(order[s], order[t]), b = std::max(order[s], order[t]);
            if (bodies[order[t]].extent.lower.x() > bodies[order[s]].extent.upper.x()) {
                break;
            }
            if ((solids[a].is_static && solids[b].is_static) || excluded.contains({a, b}) ||
                !overlap_in_yz(bodies[a].extent, bodies[b].extent)) {
                continue;
            }
            const double g = body_gap(bodies[a], bodies[b]);
            if (g <= margin) {
                found.push_back({a, b, g});
            }
        }
    }
    std::sort(found.begin(), found.end(),
              [](const PairGap& x, const PairGap& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
    return found;
}

std::vector<int> passed_through(const std::vector<Solid>& solids, const std::vector<Placement>& before,
                                const std::vector<Placement>& after) {
    std::vector<Shape> walls;
    for (std::size_t i = 0; i < solids.size(); ++i) {
        if (solids[i].is_static) {
            for (const Piece& piece : solids[i].pieces) {
                walls.push_back(placed(piece.shape, after[i]));
            }
        }
    }
    std::vector<int> found;
    for (std::size_t i = 0; i < solids.size(); ++i) {
        const bool enters =
            !solids[i].is_static && std::any_of(walls.begin(), walls.end(), [&](const Shape& wall) {
                return path_enters(wall, before[i].position, after[i].position);
            });
        if (enters) {
            found.push_back(static_cast<int>(i));
        }
    }
    return found;
}

void OverlapStatistics::add(const std::vector<PairGap>& pairs) {
    for (const PairGap& pair : pairs) {
        if (pair.gap < 0.0) {
            depths_.push_back(-pair.gap);
        }
    }
}

double OverlapStatistics::quantile(double q) const {
    if (depths_.empty()) {
        return 0.0;
    }
    std::vector<double> sorted = depths_;
    const auto rank = static_cast<std::size_t>(std::ceil(q * static_cast<double>(sorted.size())));
    const std::size_t index = std::clamp<std::size_t>(rank, 1, sorted.size()) - 1;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(index), sorted.end());
    return sorted[index];
}

std::size_t OverlapStatistics::count_above(double tolerance) const {
    return static_cast<std::size_t>(
        std::count_if(depths_.begin(), depths_.end(), [&](double depth) { return depth > tolerance; }));
}

double OverlapStatistics::share_above(double tolerance) const {
    return depths_.empty() ? 0.0 : static_cast<double>(count_above(tolerance)) / static_cast<double>(count());
}

} // namespace reference
