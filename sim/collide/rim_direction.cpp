#include "sim/collide/rim_direction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

namespace sim {
namespace {

using Kind = CoreFeature::Kind;

/// Steps of Newton's method on a pair of features with a rim; the largest one [rad], the one after which the
/// error is its square, and how far from a rim's axis it starts at least, where s(n) has a kink.
constexpr int newton_limit = 60;
constexpr double largest_step = 0.3;
constexpr double last_step = 1e-8;
constexpr double off_axis = 1e-3;

/// Slopes that are nearer to 0 than this [-] count as of either sign: where the arc of an edge's normals ends because the rim faces
/// away beyond, the disc is widest, and its slope there is nothing but rounding.
constexpr double flat_slope = 1e-9;

/// Directions shorter than this [-] are none.
constexpr double no_direction = 1e-9;

/// s(n) of two rims: n . c - sum of r |n across the rim's axis|.
struct RimPair {
    Vec3 c; ///< centre of the one on a minus that of the one on b [m]
    std::array<Vec3, 2> axis;
    std::array<double, 2> radius;

    double value(const Vec3& n) const {
        return n.dot(c) - radius[0] * axis[0].cross(n).norm() - radius[1] * axis[1].cross(n).norm();
    }

    /// With s(n) = n . gradient.
    Vec3 gradient(const Vec3& n) const {
        Vec3 result = c;
        for (std::size_t i = 0; i < 2; ++i) {
            const Vec3 across = n - axis[i] * axis[i].dot(n);
            const double length = across.norm();
            result -= length > 0.0 ? Vec3(radius[i] / length * across) : Vec3::Zero();
        }
        return result;
    }

    /// Towards a maximum by Newton's method; uphill, where there is none.
    Vec3 step(const Vec3& n) const {
        const Vec3 t = n.unitOrthogonal();
        const Vec3 s = n.cross(t);
        // Slope and curvature along t and s, on the sphere.
        double g_t = c.dot(t);
        double g_s = c.dot(s);
        double h_tt = -value(n);
        double h_ss = h_tt;
        double h_ts = 0.0;
        for (std::size_t i = 0; i < 2; ++i) {
            const double a_t = axis[i].dot(t);
            const double a_s = axis[i].dot(s);
            const double square = a_t * a_t + a_s * a_s;
            const double per_square = square > 0.0 ? 1.0 / square : 0.0; // along the axis nothing pulls away from it
            const double pull = radius[i] * std::sqrt(per_square);
            const double along = pull * axis[i].dot(n);
            g_t += along * a_t;
            g_s += along * a_s;
            const double bend = pull * per_square;
            h_tt -= bend * a_s * a_s;
            h_ss -= bend * a_t * a_t;
            h_ts += bend * a_t * a_s;
        }
        const double determinant = h_tt * h_ss - h_ts * h_ts;
        if (h_tt < 0.0 && determinant > 0.0) {
            return t * ((h_ts * g_s - h_ss * g_t) / determinant) + s * ((h_ts * g_t - h_tt * g_s) / determinant);
        }
        return (t * g_t + s * g_s).stableNormalized() * (0.5 * largest_step);
    }
};

/// Turned a little towards c, by less than off_axis, where n lies along a rim's axis.
Vec3 off_the_axes(const RimPair& pair, const Vec3& n) {
    for (std::size_t i = 0; i < 2; ++i) {
        if (pair.axis[i].cross(n).norm() < 0.5 * off_axis) {
            return (n + off_axis * (pair.c - n * n.dot(pair.c)).stableNormalized()).normalized();
        }
    }
    return n;
}

/// The axis of a rim near a direction: s(n) has a kink there.
struct Kink {
    Vec3 axis;
    Vec3 pull;     ///< slope of s(n) across the axis, but for what the rim takes away [m]
    double radius; ///< [m] of the rim: what it takes away in each direction

    bool is_peak() const { return pull.norm() <= radius; }

    /// n, or, where s(n) falls from the axis to n, the place beside the axis to where it rises.
    Vec3 uphill(const RimPair& pair, const Vec3& n) const {
        const Vec3 across = n - axis * axis.dot(n);
        if (pull.dot(across) > radius * across.norm()) {
            return n;
        }
        for (double off = off_axis; off > last_step; off *= 0.5) {
            const Vec3 next = (axis + off * pull.normalized()).normalized();
            if (pair.value(next) > pair.value(n)) {
                return next;
            }
        }
        return n;
    }
};

/// The nearest.
std::optional<Kink> kink_near(const RimPair& pair, const Vec3& n) {
    const std::array<double, 2> sine{pair.axis[0].cross(n).norm(), pair.axis[1].cross(n).norm()};
    const std::size_t i = sine[0] <= sine[1] ? 0 : 1;
    if (sine[i] >= off_axis) {
        return std::nullopt;
    }
    const Vec3 axis = std::copysign(1.0, pair.axis[i].dot(n)) * pair.axis[i];
    RimPair rest = pair;
    rest.radius[i] = 0.0;
    const Vec3 pull = rest.gradient(axis);
    return Kink{axis, pull - axis * axis.dot(pull), pair.radius[i]};
}

/// Of two rims: local maximum of s(n) from n on.
Vec3 climbed(const RimPair& pair, Vec3 n) {
    n = off_the_axes(pair, n);
    double length = largest_step;
    for (int i = 0; i < newton_limit && length >= last_step; ++i) {
        if (const std::optional<Kink> kink = kink_near(pair, n)) {
            if (kink->is_peak()) {
                return kink->axis;
            }
            n = kink->uphill(pair, n);
        }
        Vec3 step = pair.step(n);
        length = step.norm();
        step *= length > largest_step ? largest_step / length : 1.0;
        // Half the step as long as it leads downhill.
        const double before = pair.value(n);
        Vec3 next = (n + step).normalized();
        for (; pair.value(next) < before && length >= last_step; length *= 0.5) {
            step *= 0.5;
            next = (n + step).normalized();
        }
        n = pair.value(next) >= before ? next : n;
    }
    return n;
}

/// s(n) of a rim against a line, for n = x e1 + y e2 across the line; of all such e1 is the nearest to the rim's axis.
struct RimOnLine {
    double c1, c2; ///< of the place of a from b [m]
    double radius; ///< [m]
    double lean2;  ///< of the sine between axis and e1 the square [-]

    double value(double x, double y) const {
        return c1 * x + c2 * y - radius * std::sqrt(lean2 * x * x + y * y);
    }

    /// To the local maximum from a unit (x, y) on.
    void climb(double& x, double& y) const {
        double length = largest_step;
        for (int i = 0; i < newton_limit && length >= last_step; ++i) {
            const double across2 = lean2 * x * x + y * y;
            const double pull = radius * (1.0 - lean2) / std::sqrt(across2);
            const double before = value(x, y);
            const double slope = c2 * x - c1 * y - pull * x * y;
            const double curve =
                -(c1 * x + c2 * y) - pull * (x * x - y * y - (1.0 - lean2) * x * x * y * y / across2);
            double step = curve < 0.0 ? -slope / curve : std::copysign(0.5 * largest_step, slope);
            step = std::clamp(step, -largest_step, largest_step);
            const auto next = [&] {
                const double per = 1.0 / std::sqrt(1.0 + step * step);
                return std::pair((x - y * step) * per, (y + x * step) * per);
            };
            auto [next_x, next_y] = next();
            // Half the step as long as it leads downhill.
            while (value(next_x, next_y) < before && std::abs(step) >= last_step) {
                step *= 0.5;
                std::tie(next_x, next_y) = next();
            }
            length = std::abs(step);
            if (value(next_x, next_y) >= before) {
                x = next_x;
                y = next_y;
            }
        }
    }
};

/// Of a point against a rim, c its place from the rim's centre or the other way round: from the nearest point
/// of the disc, seen from the side of `near`. Of a point inside the cylinder s(n) is convex between face and
/// side: one of them is nearest.
Vec3 direction_of_point(const Vec3& c, const Vec3& axis, double radius, const Vec3& near) {
    const Vec3 up = axis.dot(near) < 0.0 ? Vec3(-axis) : axis;
    const double height = up.dot(c);
    const Vec3 across = c - height * up;
    const double distance = across.norm();
    const double beyond = distance - radius;
    if (beyond > 0.0) {
        return (height * up + beyond / distance * across).stableNormalized();
    }
    return distance > 0.0 && height < beyond ? Vec3(across / distance) : up;
}

/// Of a line against a rim: from `near` uphill, or, where that is higher, from the solution of a line in the
/// rim's plane.
Vec3 direction_of_line(const Vec3& c, const CoreFeature& rim, const Vec3& along, const Vec3& near) {
    const double lean = rim.direction.dot(along);
    const Vec3 upright = rim.direction - lean * along;
    const double upright2 = upright.squaredNorm();
    const Vec3 e1 = upright2 > no_direction * no_direction ? Vec3(upright / std::sqrt(upright2))
                                                           : Vec3(along.unitOrthogonal());
    const Vec3 e2 = along.cross(e1);
    const RimOnLine on{c.dot(e1), c.dot(e2), rim.radius, lean * lean};
    const Vec3 flat = direction_of_point(c - along * along.dot(c), e1, rim.radius, near);
    double x = flat.dot(e1);
    double y = flat.dot(e2);
    if (std::abs(lean) > no_direction) {
        const Eigen::Vector2d from(near.dot(e1), near.dot(e2));
        const double length = from.norm();
        if (length > no_direction && on.value(from.x() / length, from.y() / length) > on.value(x, y)) {
            x = from.x() / length;
            y = from.y() / length;
        }
        on.climb(x, y);
    }
    return x * e1 + y * e2;
}

} // namespace

Vec3 rim_direction(const CoreFeature& fa, const CoreFeature& fb, const Vec3& near) {
    const Vec3 c = fa.point - fb.point;
    const CoreFeature& rim = fa.kind == Kind::rim ? fa : fb;
    const CoreFeature& other = fa.kind == Kind::rim ? fb : fa;
    if (other.kind == Kind::vertex) {
        return direction_of_point(c, rim.direction, rim.radius, near);
    }
    if (other.kind == Kind::edge) {
        return direction_of_line(c, rim, other.direction, near);
    }
    if (rim.direction.cross(other.direction).norm() < no_direction) {
        return direction_of_point(c, rim.direction, rim.radius + other.radius, near);
    }
    return climbed({c, {fa.direction, fb.direction}, {fa.radius, fb.radius}}, near);
}

bool may_be_between(const CoreFeature& rim, const CoreFeature& edge, Vec3 left, Vec3 right, double least) {
    const Vec3 inwards = rim.index == 0 ? Vec3(-rim.direction) : rim.direction;
    const double facing_left = inwards.dot(left);
    const double facing_right = inwards.dot(right);
    if (facing_left < 0.0 && facing_right < 0.0) {
        return false;
    }
    if (facing_left < 0.0 || facing_right < 0.0) {
        const Vec3 upright = (std::abs(facing_right) * left + std::abs(facing_left) * right).stableNormalized();
        (facing_left < 0.0 ? left : right) = upright;
    }
    // Along the arc, s = h - r w: height of the rim's centre over the edge, and width of the disc of radius 1.
    Vec3 c = rim.point - edge.point;
    c -= edge.direction * edge.direction.dot(c);
    const double farthest = c.norm();
    const double lean = std::abs(rim.direction.dot(edge.direction));
    const Vec3 turn = edge.direction.cross(left).dot(right) < 0.0 ? Vec3(-edge.direction) : edge.direction;
    struct End {
        double h, h_slope, w, w_slope;
    };
    const auto end = [&](const Vec3& u) {
        const Vec3 onwards = turn.cross(u);
        const double along = rim.direction.dot(u);
        const double w = (u - along * rim.direction).norm();
        return End{u.dot(c), onwards.dot(c), w, w > 0.0 ? -rim.direction.dot(onwards) * along / w : 0.0};
    };
    const End l = end(left);
    const End r = end(right);
    const double highest = l.h_slope > -flat_slope * farthest && r.h_slope < flat_slope * farthest ? farthest : std::max(l.h, r.h);
    const double narrowest = l.w_slope < flat_slope && r.w_slope > -flat_slope ? lean : std::min(l.w, r.w);
    if (highest - rim.radius * narrowest < least) {
        return false;
    }
    // Nor is there a maximum where s only rises or only falls.
    const double h_falls = l.h > 0.0 && r.h < 0.0 ? -farthest : std::min(l.h_slope, r.h_slope);
    const double h_rises = l.h < 0.0 && r.h > 0.0 ? farthest : std::max(l.h_slope, r.h_slope);
    const double w_falls = std::min(l.w_slope, r.w_slope) < flat_slope ? lean - 1.0 : std::min(l.w_slope, r.w_slope);
    const double w_rises = std::max(l.w_slope, r.w_slope) > -flat_slope ? 1.0 - lean : std::max(l.w_slope, r.w_slope);
    return h_falls <= rim.radius * w_rises && h_rises >= rim.radius * w_falls;
}

bool is_within_disc(const CoreFeature& rim, const CoreFeature& edge, const Vec3& n, double radius) {
    const double cosine = std::abs(rim.direction.dot(edge.direction));
    const double along = edge.direction.dot(lowest_rim_point(rim.point, rim.direction, rim.radius, n) - edge.point);
    return edge.kind == CoreFeature::Kind::edge && radius <= rim.radius * cosine * cosine && // the ellipse's least radius of curvature
           cosine * (edge.length - std::abs(along) - radius) >= 2.0 * radius;
}

} // namespace sim
