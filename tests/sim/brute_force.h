#pragma once
/// The gap of two convex bodies by brute force: every direction that a pair of features could define is tried on all
/// vertices, and rims are sampled finer and finer. Shares no code with sim/.
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace brute {

using Vec3 = Eigen::Vector3d;

/// Circle on which a cylinder ends, world.
struct Rim {
    Vec3 centre;
    Vec3 axis;
    Vec3 across;
    double radius;

    Vec3 point(double angle) const {
        return centre + radius * (std::cos(angle) * across + std::sin(angle) * axis.cross(across));
    }
    Vec3 tangent(double angle) const {
        return -std::sin(angle) * across + std::cos(angle) * axis.cross(across);
    }
};

/// Hull of points and rims, all within `rounding` of it.
struct Solid {
    std::vector<Vec3> vertices;
    std::vector<Rim> rims;
    double rounding = 0.0;

    double reach(const Vec3& u) const {
        double h = -std::numeric_limits<double>::infinity();
        for (const Vec3& v : vertices) {
            h = std::max(h, v.dot(u));
        }
        for (const Rim& rim : rims) {
            h = std::max(h, rim.centre.dot(u) + rim.radius * rim.axis.cross(u).norm());
        }
        return h + rounding;
    }

    /// Directions of all lines through two vertices, and of the sides of a cylinder.
    std::vector<Vec3> lines() const {
        std::vector<Vec3> result;
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            for (std::size_t j = 0; j < i; ++j) {
                result.push_back((vertices[i] - vertices[j]).normalized());
            }
        }
        if (!rims.empty()) {
            result.push_back(rims[0].axis);
        }
        return result;
    }

    /// Points that, with a direction of lines(), lie on each line.
    std::vector<Vec3> line_points() const {
        std::vector<Vec3> result;
        for (std::size_t i = 0; i < vertices.size(); ++i) {
            result.insert(result.end(), i, vertices[i]);
        }
        if (!rims.empty()) {
            result.push_back(rims[0].centre);
        }
        return result;
    }
};

/// Largest value over all directions of: min over a of n . x - max over b of n . x, and that direction.
class Search {
public:
    Search(const Solid& a, const Solid& b) : a_(a), b_(b) {
        const std::vector<Vec3> lines_a = a.lines();
        const std::vector<Vec3> lines_b = b.lines();
        try_faces(lines_a);
        try_faces(lines_b);
        for (const Vec3& x : lines_a) {
            for (const Vec3& y : lines_b) {
                try_both(x.cross(y));
            }
        }
        const std::vector<Vec3> points_a = a.line_points();
        const std::vector<Vec3> points_b = b.line_points();
        for (std::size_t i = 0; i < lines_a.size(); ++i) {
            for (const std::vector<Vec3>* points : {&b.vertices, &points_b}) {
                for (const Vec3& y : *points) {
                    try_both(across(points_a[i] - y, lines_a[i]));
                }
            }
        }
        for (const Vec3& x : a.vertices) {
            for (const Vec3& y : b.vertices) {
                try_both(x - y);
            }
            for (std::size_t j = 0; j < lines_b.size(); ++j) {
                try_both(across(x - points_b[j], lines_b[j]));
            }
        }
        try_rims(a.rims, b, lines_b);
        try_rims(b.rims, a, lines_a);
        for (const Rim& rim_a : a.rims) {
            for (const Rim& rim_b : b.rims) {
                zoom_two([&](double s, double t) { return Vec3(rim_a.tangent(s).cross(rim_b.tangent(t))); });
                zoom_two([&](double s, double t) { return Vec3(rim_a.point(s) - rim_b.point(t)); });
            }
        }
    }

    double gap = -std::numeric_limits<double>::infinity();
    Vec3 n = Vec3::Zero(); ///< from b to a

    double gap_along(const Vec3& u) const { return -a_.reach(-u) - b_.reach(u); }

    double try_one(const Vec3& u) {
        const double g = gap_along(u);
        if (g > gap) {
            gap = g;
            n = u;
        }
        return g;
    }

private:
    static Vec3 across(const Vec3& x, const Vec3& line) { return x - line * line.dot(x); }

    double try_both(const Vec3& u) {
        if (u.norm() < 1e-9) {
            return -std::numeric_limits<double>::infinity();
        }
        return std::max(try_one(u.normalized()), try_one(-u.normalized()));
    }

    /// Faces lie across two lines of one body; ends of cylinders across its axis.
    void try_faces(const std::vector<Vec3>& lines) {
        for (const Vec3& x : lines) {
            try_both(x);
            for (const Vec3& y : lines) {
                try_both(x.cross(y));
            }
        }
    }

    void try_rims(const std::vector<Rim>& rims, const Solid& other, const std::vector<Vec3>& lines) {
        for (const Rim& rim : rims) {
            for (const Vec3& line : lines) {
                zoom([&](double s) { return Vec3(rim.tangent(s).cross(line)); });
            }
            for (const Vec3& vertex : other.vertices) {
                const Vec3 towards = across(vertex - rim.centre, rim.axis);
                if (towards.norm() > 0.0) {
                    try_both(rim.centre + rim.radius * towards.normalized() - vertex);
                }
            }
        }
    }

    /// Best direction of a family with one angle.
    template <typename F>
    void zoom(const F& direction) {
        double middle = 0.0;
        double width = std::numbers::pi;
        int samples = 180;
        for (int round = 0; round < 28; ++round) {
            double best = -std::numeric_limits<double>::infinity();
            double next = middle;
            for (int k = -samples; k <= samples; ++k) {
                const double s = middle + width * k / samples;
                const double g = try_both(direction(s));
                if (g > best) {
                    best = g;
                    next = s;
                }
            }
            middle = next;
            width *= 4.0 / samples;
            samples = 12;
        }
    }

    template <typename F>
    void zoom_two(const F& direction) {
        double s0 = 0.0;
        double t0 = 0.0;
        double width = std::numbers::pi;
        int samples = 40;
        for (int round = 0; round < 34; ++round) {
            double best = -std::numeric_limits<double>::infinity();
            double s1 = s0;
            double t1 = t0;
            for (int i = -samples; i <= samples; ++i) {
                for (int j = -samples; j <= samples; ++j) {
                    const double s = s0 + width * i / samples;
                    const double t = t0 + width * j / samples;
                    const double g = try_both(direction(s, t));
                    if (g > best) {
                        best = g;
                        s1 = s;
                        t1 = t;
                    }
                }
            }
            s0 = s1;
            t0 = t1;
            width *= 2.0 / samples;
            samples = 4;
        }
    }

    const Solid& a_;
    const Solid& b_;
};

} // namespace brute
