#include "sim/collide/rim_direction.h"

#include <array>

namespace sim {
namespace {

using Kind = CoreFeature::Kind;

/// Steps of Newton's method on a pair of features with a rim; the largest one [rad], the one that ends it,
/// and how far from a rim's axis it starts at least, where s(n) has a kink.
constexpr int newton_limit = 60;
constexpr double largest_step = 0.3;
constexpr double last_step = 1e-15;
constexpr double off_axis = 1e-3;

/// Directions shorter than this [-] are none.
constexpr double no_direction = 1e-9;

/// s(n) of a point of a against a point of b, both on rims or fixed: n . c - sum of r |n across the rim's
/// axis|.
struct RimPair {
    Vec3 c; ///< point or centre on a minus that on b [m]
    std::array<Vec3, 2> axis;
    std::array<double, 2> radius;

    double value(const Vec3& n) const {
        return n.dot(c) - radius[0] * axis[0].cross(n).norm() - radius[1] * axis[1].cross(n).norm();
    }

    /// Gradient (with s = n . gradient), and the Hessian of s as a homogeneous function of n.
    Vec3 gradient(const Vec3& n, Mat3& hessian) const {
        Vec3 result = c;
        hessian.setZero();
        for (std::size_t i = 0; i < 2; ++i) {
            const Vec3 across = n - axis[i] * axis[i].dot(n);
            const double length = across.norm();
            if (radius[i] > 0.0 && length > 0.0) {
                const Vec3 radial = across / length;
                const Vec3 tangent = axis[i].cross(radial);
                result -= radius[i] * radial;
                hessian -= radius[i] / length * tangent * tangent.transpose();
            }
        }
        return result;
    }
};

/// Turned a little towards c where n lies along a rim's axis.
Vec3 off_the_axes(const RimPair& pair, const Vec3& n) {
    for (std::size_t i = 0; i < 2; ++i) {
        if (pair.radius[i] > 0.0 && pair.axis[i].cross(n).norm() < 0.5 * off_axis) {
            return (n + off_axis * (pair.c - n * n.dot(pair.c)).stableNormalized()).normalized();
        }
    }
    return n;
}

/// Local maximum of a pair's s(n) from n on; of those across the unit vector `along`, as n is, unless that is
/// zero.
Vec3 climbed(const RimPair& pair, Vec3 n, const Vec3& along) {
    const bool is_bound = !along.isZero(0.0);
    n = is_bound ? n : off_the_axes(pair, n);
    for (int i = 0; i < newton_limit; ++i) {
        Mat3 hessian;
        const Vec3 gradient = pair.gradient(n, hessian);
        hessian -= n.dot(gradient) * Mat3::Identity();
        const Vec3 t = is_bound ? Vec3(along.cross(n)) : Vec3(n.unitOrthogonal());
        const Vec3 s = is_bound ? Vec3(Vec3::Zero()) : Vec3(n.cross(t));
        const double g_t = gradient.dot(t);
        const double g_s = gradient.dot(s);
        const double h_tt = t.dot(hessian * t);
        const double h_ss = is_bound ? -1.0 : s.dot(hessian * s);
        const double h_ts = t.dot(hessian * s);
        const double determinant = h_tt * h_ss - h_ts * h_ts;
        Vec3 step;
        if (h_tt < 0.0 && determinant > 0.0) {
            step =
                t * ((h_ts * g_s - h_ss * g_t) / determinant) + s * ((h_ts * g_t - h_tt * g_s) / determinant);
        } else {
            step = (t * g_t + s * g_s).stableNormalized() * (0.5 * largest_step); // uphill
        }
        double length = step.norm();
        step *= length > largest_step ? largest_step / length : 1.0;
        // Half the step as long as it leads downhill.
        const double before = n.dot(gradient);
        Vec3 next = (n + step).normalized();
        while (length >= last_step && pair.value(next) < before) {
            step *= 0.5;
            length *= 0.5;
            next = (n + step).normalized();
        }
        if (length < last_step) {
            break;
        }
        n = next;
    }
    return n;
}

/// Unit vector along what n has across the unit vector `along`; zero if it has nothing.
Vec3 made_across(const Vec3& n, const Vec3& along) {
    const Vec3 across = n - along * along.dot(n);
    return across.norm() < no_direction ? Vec3(Vec3::Zero()) : Vec3(across.normalized());
}

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

/// Of a line against a rim: that of the line's nearest point as if the line were in the rim's plane, and from
/// there uphill.
Vec3 direction_of_line(const RimPair& pair, const Vec3& axis, double radius, const Vec3& along,
                       const Vec3& near) {
    const Vec3 c = pair.c - along * along.dot(pair.c);
    const Vec3 flat = made_across(direction_of_point(c, axis, radius, near), along);
    if (std::abs(axis.dot(along)) < no_direction) {
        return flat;
    }
    Vec3 n = made_across(near, along);
    if (!flat.isZero(0.0) && (n.isZero(0.0) || pair.value(flat) > pair.value(n))) {
        n = flat;
    }
    return n.isZero(0.0) ? n : climbed(pair, n, along);
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
        const RimPair pair{c, {rim.direction, Vec3::Zero()}, {rim.radius, 0.0}};
        return direction_of_line(pair, rim.direction, rim.radius, other.direction, near);
    }
    if (rim.direction.cross(other.direction).norm() < no_direction) {
        return direction_of_point(c, rim.direction, rim.radius + other.radius, near);
    }
    return climbed({c, {fa.direction, fb.direction}, {fa.radius, fb.radius}}, near, Vec3::Zero());
}

} // namespace sim
