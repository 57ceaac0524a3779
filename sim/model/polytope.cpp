#include "sim/model/polytope.h"

#include "sim/base/error.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>

namespace sim {
namespace {

/// Distances within this share [-] of the points' extent are rounding while the hull is built.
constexpr double polytope_rounding = 1e-12;

/// Points that leave a plane by less than this share [-] of their extent span no volume.
constexpr double flat = 1e-9;

/// Neighbouring triangles are one face if their corners lie in one plane to this share [-] of the extent: points
/// may have been written with seven digits.
constexpr double same_face = 1e-6;

struct Triangle {
    std::array<int, 3> v{};
    std::array<int, 3> beyond{}; ///< triangle behind the edge v[i], v[i + 1]
    Vec3 normal = Vec3::Zero();  ///< unit, outwards
    bool is_alive = true;
};

/// Hull of points by adding one at a time. A triangle counts as seen from a new point also where the point
/// lies in its plane, so that no triangle without area comes about.
class HullBuilder {
public:
    explicit HullBuilder(std::span<const Vec3> points) : points_(points) {
        Vec3 lower = points[0];
        Vec3 upper = points[0];
        for (const Vec3& p : points) {
            lower = lower.cwiseMin(p);
            upper = upper.cwiseMax(p);
        }
        extent_ = (upper - lower).norm();
    }

    double extent() const { return extent_; } ///< [m]

    /// False if the points are flat.
    bool build() {
        if (!start()) {
            return false;
        }
        for (int p = 0; p < static_cast<int>(points_.size()); ++p) {
            add(p);
        }
        return true;
    }

    /// The triangles left, with their neighbours.
    std::vector<Triangle> triangles() const {
        std::vector<int> place(triangles_.size(), -1);
        std::vector<Triangle> result;
        for (std::size_t i = 0; i < triangles_.size(); ++i) {
            if (triangles_[i].is_alive) {
                place[i] = static_cast<int>(result.size());
                result.push_back(triangles_[i]);
            }
        }
        for (Triangle& triangle : result) {
            for (int& neighbour : triangle.beyond) {
                neighbour = place[static_cast<std::size_t>(neighbour)];
            }
        }
        return result;
    }

private:
    struct OutlineEdge {
        int from;
        int to;
        int beyond; ///< triangle that is not seen
    };

    const Vec3& point(int i) const { return points_[static_cast<std::size_t>(i)]; }
    Triangle& triangle(int i) { return triangles_[static_cast<std::size_t>(i)]; }

    double height(const Triangle& t, int p) const { return t.normal.dot(point(p) - point(t.v[0])); }

    /// Index of the point for which f is largest.
    template <typename F>
    int farthest(const F& f) const {
        int best = 0;
        for (int i = 1; i < static_cast<int>(points_.size()); ++i) {
            best = f(point(i)) > f(point(best)) ? i : best;
        }
        return best;
    }

    /// A tetrahedron of far points.
    bool start() {
        const int a = farthest([&](const Vec3& x) { return -x.x(); });
        const int b = farthest([&](const Vec3& x) { return (x - point(a)).squaredNorm(); });
        const Vec3 ab = (point(b) - point(a)).stableNormalized();
        const int c = farthest([&](const Vec3& x) { return (x - point(a)).cross(ab).squaredNorm(); });
        const Vec3 n = ab.cross(point(c) - point(a)).stableNormalized();
        const int d = farthest([&](const Vec3& x) { return std::abs(n.dot(x - point(a))); });
        const double height = n.dot(point(d) - point(a));
        const double width = (point(c) - point(a)).cross(ab).norm();
        if (!(std::abs(height) > flat * extent_ && width > flat * extent_)) {
            return false;
        }
        const auto [second, third] = height < 0.0 ? std::pair(b, c) : std::pair(c, b);
        triangles_ = {make(a, second, third), make(a, third, d), make(third, second, d), make(second, a, d)};
        triangles_[0].beyond = {3, 2, 1};
        triangles_[1].beyond = {0, 2, 3};
        triangles_[2].beyond = {0, 3, 1};
        triangles_[3].beyond = {0, 1, 2};
        return true;
    }

    Triangle make(int a, int b, int c) const {
        Triangle t;
        t.v = {a, b, c};
        t.normal = (point(b) - point(a)).cross(point(c) - point(a)).stableNormalized();
        return t;
    }

    /// Replaces what point p sees by triangles from its outline to p. A point whose view has no simple outline,
    /// by rounding, lies on the hull and is left out.
    void add(int p) {
        const double eps = polytope_rounding * extent_;
        int first = -1;
        double highest = eps;
        for (int i = 0; i < static_cast<int>(triangles_.size()); ++i) {
            if (triangle(i).is_alive && height(triangle(i), p) > highest) {
                highest = height(triangle(i), p);
                first = i;
            }
        }
        if (first < 0) {
            return;
        }
        // Everything seen, from the first on; the edges to what is not seen are the outline.
        std::vector<int> seen{first};
        std::vector<OutlineEdge> outline;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            const Triangle& t = triangle(seen[k]);
            for (std::size_t i = 0; i < 3; ++i) {
                const int next = t.beyond[i];
                if (std::ranges::find(seen, next) != seen.end()) {
                    continue;
                }
                if (height(triangle(next), p) > -eps) {
                    seen.push_back(next);
                } else {
                    outline.push_back({t.v[i], t.v[(i + 1) % 3], next});
                }
            }
        }
        std::map<int, int> starting_at; // vertex of the outline -> new triangle
        const int base = static_cast<int>(triangles_.size());
        for (std::size_t k = 0; k < outline.size(); ++k) {
            starting_at[outline[k].from] = base + static_cast<int>(k);
        }
        const auto goes_on = [&](const OutlineEdge& edge) { return starting_at.contains(edge.to); };
        if (starting_at.size() != outline.size() || !std::ranges::all_of(outline, goes_on)) {
            return;
        }
        for (const int t : seen) {
            triangle(t).is_alive = false;
        }
        for (std::size_t k = 0; k < outline.size(); ++k) {
            const OutlineEdge& edge = outline[k];
            const int own = base + static_cast<int>(k);
            Triangle t = make(edge.from, edge.to, p);
            t.beyond = {edge.beyond, starting_at.at(edge.to), -1};
            triangles_.push_back(t);
            Triangle& old = triangle(edge.beyond);
            for (std::size_t i = 0; i < 3; ++i) {
                if (old.v[i] == edge.to && old.v[(i + 1) % 3] == edge.from) {
                    old.beyond[i] = own;
                }
            }
        }
        for (std::size_t k = 0; k < outline.size(); ++k) {
            const int next = triangle(base + static_cast<int>(k)).beyond[1];
            triangle(next).beyond[2] = base + static_cast<int>(k);
        }
    }

    std::span<const Vec3> points_;
    double extent_ = 0.0;
    std::vector<Triangle> triangles_;
};

/// Number of the flat group of each triangle. Groups grow from the largest triangles: slivers have no reliable
/// normal.
std::vector<int> flat_groups(const std::vector<Triangle>& triangles, std::span<const Vec3> points, double extent) {
    const auto corner = [&](const Triangle& t, std::size_t i) -> const Vec3& {
        return points[static_cast<std::size_t>(t.v[i])];
    };
    const auto area = [&](std::size_t i) {
        const Triangle& t = triangles[i];
        return (corner(t, 1) - corner(t, 0)).cross(corner(t, 2) - corner(t, 0)).norm();
    };
    std::vector<std::size_t> order(triangles.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, std::ranges::greater{}, area);
    std::vector<int> group(triangles.size(), -1);
    int count = 0;
    for (const std::size_t first : order) {
        if (group[first] >= 0) {
            continue;
        }
        const Triangle& seed = triangles[first];
        const auto lies_in_plane = [&](const Triangle& t) {
            bool result = t.normal.dot(seed.normal) > 0.0;
            for (std::size_t i = 0; i < 3; ++i) {
                const double height = seed.normal.dot(corner(t, i) - corner(seed, 0));
                result = result && std::abs(height) < same_face * extent;
            }
            return result;
        };
        std::vector<std::size_t> members{first};
        group[first] = count;
        for (std::size_t k = 0; k < members.size(); ++k) {
            for (const int next : triangles[members[k]].beyond) {
                const auto n = static_cast<std::size_t>(next);
                if (group[n] < 0 && lies_in_plane(triangles[n])) {
                    group[n] = count;
                    members.push_back(n);
                }
            }
        }
        ++count;
    }
    return group;
}

/// of: [vertices] what meets in each.
Polytope::Around around(std::span<const std::vector<int>> of) {
    Polytope::Around result;
    for (const std::vector<int>& own : of) {
        result.indices.insert(result.indices.end(), own.begin(), own.end());
        result.ends.push_back(static_cast<int>(result.indices.size()));
    }
    return result;
}

/// Fills in, from the faces' loops, what follows from them.
void connect(Polytope& polytope) {
    std::vector<std::vector<int>> edges_of(polytope.vertices.size());
    std::vector<std::vector<int>> faces_of(polytope.vertices.size());
    std::map<std::pair<int, int>, int> face_along;
    for (int f = 0; f < static_cast<int>(polytope.faces.size()); ++f) {
        const std::vector<int>& loop = polytope.faces[static_cast<std::size_t>(f)].loop;
        polytope.faces[static_cast<std::size_t>(f)].corner = loop.front();
        for (std::size_t i = 0; i < loop.size(); ++i) {
            face_along[{loop[i], loop[(i + 1) % loop.size()]}] = f;
            faces_of[static_cast<std::size_t>(loop[i])].push_back(f);
        }
    }
    for (const auto& [ends, left] : face_along) {
        const auto [from, to] = ends;
        if (from > to) {
            continue;
        }
        const auto a = static_cast<std::size_t>(from);
        const auto b = static_cast<std::size_t>(to);
        const int index = static_cast<int>(polytope.edges.size());
        const Vec3 along = polytope.vertices[b] - polytope.vertices[a];
        polytope.edges.push_back({from, to, left, face_along.at({to, from}), along.stableNormalized(),
                                  0.5 * (polytope.vertices[a] + polytope.vertices[b]), 0.5 * along.norm()});
        edges_of[a].push_back(index);
        edges_of[b].push_back(index);
    }
    polytope.edges_around = around(edges_of);
    polytope.faces_around = around(faces_of);
}

/// Fills centre, radius and by_twos from the vertices.
void find_extent(Polytope& polytope) {
    const std::vector<Vec3>& vertices = polytope.vertices;
    polytope.centre.setZero();
    polytope.radius = 0.0;
    for (const Vec3& vertex : vertices) {
        polytope.centre += vertex / static_cast<double>(vertices.size());
        polytope.radius = std::max(polytope.radius, vertex.norm());
    }
    polytope.by_twos.clear();
    for (std::size_t i = 0; i < vertices.size(); i += 2) {
        const Vec3& first = vertices[i];
        const Vec3& second = vertices[std::min(i + 1, vertices.size() - 1)];
        polytope.by_twos.push_back({{first.x(), second.x()}, {first.y(), second.y()}, {first.z(), second.z()}});
    }
}

/// Boundary loop of each group, of vertices where at least three groups meet.
std::vector<Polytope::Face> merged_faces(const std::vector<Triangle>& triangles, std::span<const Vec3> points,
                                         double extent) {
    const std::vector<int> group = flat_groups(triangles, points, extent);
    const int count = *std::ranges::max_element(group) + 1;
    std::vector<std::map<int, int>> next(static_cast<std::size_t>(count)); // along the boundary of a group
    std::map<int, int> groups_at;                                         // vertex -> boundaries through it
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const auto g = static_cast<std::size_t>(group[t]);
        for (std::size_t i = 0; i < 3; ++i) {
            if (group[static_cast<std::size_t>(triangles[t].beyond[i])] != group[t]) {
                next[g][triangles[t].v[i]] = triangles[t].v[(i + 1) % 3];
                ++groups_at[triangles[t].v[i]];
            }
        }
    }
    std::vector<Polytope::Face> faces;
    for (const std::map<int, int>& boundary : next) {
        Polytope::Face face;
        int v = boundary.begin()->first;
        for (std::size_t k = 0; k < boundary.size(); ++k, v = boundary.at(v)) {
            if (groups_at.at(v) >= 3) {
                face.loop.push_back(v);
            }
        }
        // Newell's normal: the mean over the loop.
        Vec3 sum = Vec3::Zero();
        const Vec3& origin = points[static_cast<std::size_t>(face.loop.at(0))];
        for (std::size_t i = 0; i + 1 < face.loop.size(); ++i) {
            sum += (points[static_cast<std::size_t>(face.loop[i])] - origin)
                       .cross(points[static_cast<std::size_t>(face.loop[i + 1])] - origin);
        }
        face.normal = sum.stableNormalized();
        faces.push_back(std::move(face));
    }
    return faces;
}

} // namespace

std::optional<Polytope> convex_hull(std::span<const Vec3> points) {
    if (points.size() < 4) {
        return std::nullopt;
    }
    HullBuilder builder(points);
    if (!builder.build()) {
        return std::nullopt;
    }
    Polytope result;
    result.faces = merged_faces(builder.triangles(), points, builder.extent());
    // Corners in the order in which they were given.
    std::vector<int> place(points.size(), -1);
    for (const Polytope::Face& face : result.faces) {
        for (const int v : face.loop) {
            place[static_cast<std::size_t>(v)] = 0;
        }
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (place[i] == 0) {
            place[i] = static_cast<int>(result.vertices.size());
            result.vertices.push_back(points[i]);
        }
    }
    for (Polytope::Face& face : result.faces) {
        for (int& v : face.loop) {
            v = place[static_cast<std::size_t>(v)];
        }
    }
    connect(result);
    find_extent(result);
    return result;
}

const Polytope& unit_cube() {
    static const Polytope cube = [] {
        std::vector<Vec3> corners;
        for (int i = 0; i < 8; ++i) {
            corners.emplace_back((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0,
                                 (i & 4) != 0 ? 1.0 : -1.0);
        }
        return *convex_hull(corners);
    }();
    return cube;
}

Polytope moved(const Polytope& polytope, const Vec3& offset) {
    Polytope result = polytope;
    for (Vec3& vertex : result.vertices) {
        vertex += offset;
    }
    for (Polytope::Edge& edge : result.edges) {
        edge.middle += offset;
    }
    find_extent(result);
    return result;
}

VolumeMoments volume_moments(const Polytope& polytope) {
    // Tetrahedra from one vertex to the triangles of all faces: integrals of 1, x and x x^T in closed form.
    const Vec3 origin = polytope.vertices.at(0);
    VolumeMoments result;
    Vec3 first = Vec3::Zero();
    for (const Polytope::Face& face : polytope.faces) {
        const auto corner = [&](std::size_t i) {
            return Vec3(polytope.vertices[static_cast<std::size_t>(face.loop[i])] - origin);
        };
        for (std::size_t i = 1; i + 1 < face.loop.size(); ++i) {
            const Vec3 a = corner(0);
            const Vec3 b = corner(i);
            const Vec3 c = corner(i + 1);
            const double six_volumes = a.dot(b.cross(c));
            const Vec3 sum = a + b + c;
            result.volume += six_volumes / 6.0;
            first += six_volumes / 24.0 * sum;
            result.second += six_volumes / 120.0 *
                             (a * a.transpose() + b * b.transpose() + c * c.transpose() +
                              sum * sum.transpose());
        }
    }
    const Vec3 centroid = first / result.volume;
    result.second -= result.volume * centroid * centroid.transpose();
    result.centroid = origin + centroid;
    return result;
}

} // namespace sim
