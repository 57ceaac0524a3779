#include "sim/collide/separating_direction.h"

#include "sim/collide/ccd_bridge.h"
#include "sim/model/polytope.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace sim {
namespace {

/// Gaps that differ by less than this share [-] of the cores' size are equal, by rounding: a face is preferred to other
/// features then, and a face of a to one of b.
constexpr double preference = 1e-11;

/// Edges whose cross product is shorter than this [-] are parallel.
constexpr double parallel_directions = 1e-9;

/// Passes of the ascent; each moves to a neighbouring pair of features.
constexpr int pass_limit = 60;

/// Steps of Newton's method on a pair of features with a rim; the largest one [rad], the one that ends it, and how
/// far from a rim's axis it starts at least, where s(n) has a kink.
constexpr int newton_limit = 60;
constexpr double largest_step = 0.3;
constexpr double last_step = 1e-15;
constexpr double off_axis = 1e-3;

using Kind = CoreFeature::Kind;

/// s(n) of a point of a against a point of b, both on rims or fixed: n . c - sum of r |n across the rim's axis|.
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
            return n + off_axis * (pair.c - n * n.dot(pair.c)).stableNormalized();
        }
    }
    return n;
}

/// Local maximum of a pair's s(n) from n on; across the unit vector `along` unless that is zero.
Vec3 rim_direction(const RimPair& pair, Vec3 n, const Vec3& along) {
    const bool is_bound = !along.isZero(0.0);
    n = off_the_axes(pair, n);
    if (is_bound) {
        n -= along * along.dot(n);
    }
    if (n.norm() < parallel_directions) {
        return Vec3::Zero();
    }
    n.normalize();
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
            step = t * ((h_ts * g_s - h_ss * g_t) / determinant) + s * ((h_ts * g_t - h_tt * g_s) / determinant);
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

class Ascent {
public:
    Ascent(const Convex& a, const Convex& b, double enough)
        : a_(a), b_(b), between_(a.world_from_part.position - b.world_from_part.position), enough_(enough),
          slack_(preference * std::max(a.size, b.size)) {}

    double gap(const Vec3& n) const {
        return n.dot(between_) - support_height(a_, -n) - support_height(b_, n);
    }

    /// Moves uphill from n until no pair of neighbouring features is better.
    Separation climb(const Vec3& n) {
        Separation result;
        result.best.n = n;
        result.best.core_gap = gap(n);
        for (int pass = 0; pass < pass_limit; ++pass) {
            result.is_beyond = result.best.core_gap > enough_;
            if (result.is_beyond) {
                return result;
            }
            find_candidates(result.best.n);
            if (pass > 0 && !(lead_.core_gap > result.best.core_gap + slack_)) {
                break;
            }
            result.best = lead_;
        }
        if (top_.core_gap + slack_ >= result.best.core_gap) {
            result.best = top_;
        }
        result.best_face = face_a_.core_gap + slack_ >= face_b_.core_gap ? face_a_ : face_b_;
        if (result.best_face.core_gap + slack_ >= result.best.core_gap && result.best_face.is_face()) {
            result.best = result.best_face;
        }
        return result;
    }

private:
    static constexpr double none = -std::numeric_limits<double>::infinity();

    static void take(SeparatingDirection& best, const SeparatingDirection& found) {
        if (found.core_gap > best.core_gap) {
            best = found;
        }
    }

    /// The best of the directions that the features near n define.
    void find_candidates(const Vec3& n) {
        n_ = n;
        near_features(a_, -n, features_a_);
        near_features(b_, n, features_b_);
        find_edge_normals(a_, features_a_, normals_a_);
        find_edge_normals(b_, features_b_, normals_b_);
        top_ = face_a_ = face_b_ = {};
        top_.core_gap = face_a_.core_gap = face_b_.core_gap = none;
        for (const CoreFeature& f : features_a_) {
            if (f.kind == Kind::face) {
                take(face_a_, {-f.direction, gap(-f.direction), true, false, f, {}});
            }
        }
        for (const CoreFeature& f : features_b_) {
            if (f.kind == Kind::face) {
                take(face_b_, {f.direction, gap(f.direction), false, true, {}, f});
            }
        }
        take(top_, face_a_);
        take(top_, face_b_);
        lead_ = top_;
        for (std::size_t i = 0; i < features_a_.size(); ++i) {
            for (std::size_t j = 0; j < features_b_.size(); ++j) {
                if (features_a_[i].kind != Kind::face && features_b_[j].kind != Kind::face) {
                    try_pair(i, j);
                }
            }
        }
    }

    void try_pair(std::size_t i, std::size_t j) {
        const CoreFeature& fa = features_a_[i];
        const CoreFeature& fb = features_b_[j];
        Vec3 n = Vec3::Zero();
        if (fa.kind == Kind::rim || fb.kind == Kind::rim) {
            n = direction_of_rims(fa, fb);
        } else if (fa.kind == Kind::edge && fb.kind == Kind::edge) {
            n = direction_of_edges(fa, fb, normals_a_[i], normals_b_[j]);
        } else {
            n = direction_of_vertex(fa, fb);
        }
        // What any two points of the cores are apart along n is no less than the gap.
        if (n.isZero(0.0) || n.dot(fa.point - fb.point) < top_.core_gap) {
            return;
        }
        const SeparatingDirection found{n, gap(n), false, false, fa, fb};
        take(lead_, found);
        if (n.dot(fa.point - fb.point) - reach(fa, n) - reach(fb, n) <= found.core_gap + slack_) {
            take(top_, found);
        }
    }

    /// How far a feature reaches beyond its point along n or against it [m].
    static double reach(const CoreFeature& f, const Vec3& n) {
        return f.kind == Kind::rim ? f.radius * f.direction.cross(n).norm() : f.radius;
    }

    /// Outward normals of the faces that an edge of a polytope joins, their sum and their cross product; world.
    struct EdgeNormals {
        Vec3 left = Vec3::Zero();
        Vec3 right = Vec3::Zero();
        Vec3 sum = Vec3::Zero();
        Vec3 across = Vec3::Zero();
    };

    static void find_edge_normals(const Convex& convex, const std::vector<CoreFeature>& features,
                                  std::vector<EdgeNormals>& normals) {
        normals.assign(features.size(), {});
        for (std::size_t i = 0; convex.kind == CoreKind::polytope && i < features.size(); ++i) {
            if (features[i].kind == Kind::edge) {
                const Polytope::Edge& edge = convex.polytope->edges[static_cast<std::size_t>(features[i].index)];
                const Vec3& left = convex.polytope->faces[static_cast<std::size_t>(edge.left)].normal;
                const Vec3& right = convex.polytope->faces[static_cast<std::size_t>(edge.right)].normal;
                const Quat& turn = convex.world_from_part.orientation;
                normals[i] = {turn * left, turn * right, turn * Vec3(left + right), {}};
                normals[i].across = normals[i].left.cross(normals[i].right);
            }
        }
    }

    /// Across both edges, where the arcs of their outward normals cross.
    Vec3 direction_of_edges(const CoreFeature& fa, const CoreFeature& fb, const EdgeNormals& of_a,
                            const EdgeNormals& of_b) const {
        const Vec3 cross = fa.direction.cross(fb.direction);
        const Vec3 between = fa.point - fb.point;
        const double length = cross.norm();
        if (length < parallel_directions) {
            return direction_across(fa.direction, between);
        }
        const Vec3 n = cross / length;
        const Vec3 outward = of_b.sum - of_a.sum;
        if (a_.kind == CoreKind::polytope && b_.kind == CoreKind::polytope && !arcs_cross(of_a, of_b)) {
            return Vec3::Zero();
        }
        const double side = outward.isZero(0.0) ? n.dot(between) : n.dot(outward);
        return side >= 0.0 ? n : Vec3(-n);
    }

    /// Unit vector of what `between` has across the unit vector `along`; any, if it has nothing.
    static Vec3 direction_across(const Vec3& along, const Vec3& between) {
        const Vec3 across = between - along * along.dot(between);
        return across.norm() > 0.0 ? Vec3(across.stableNormalized()) : Vec3(along.unitOrthogonal());
    }

    /// Do the arc of the normals of an edge of a, turned round, and that of an edge of b meet on the unit sphere?
    static bool arcs_cross(const EdgeNormals& of_a, const EdgeNormals& of_b) {
        const double b_left = of_a.across.dot(of_b.left);
        const double b_right = of_a.across.dot(of_b.right);
        const double a_left = -of_b.across.dot(of_a.left);
        const double a_right = -of_b.across.dot(of_a.right);
        return b_left * b_right <= parallel_directions && a_left * a_right <= parallel_directions &&
               (of_a.left + of_a.right).dot(of_b.left + of_b.right) < 1.0;
    }

    /// From the nearest point of b to that of a, at least one of them a vertex. Beyond an edge's end it leads to that end,
    /// a corner that need not be near n.
    static Vec3 direction_of_vertex(const CoreFeature& fa, const CoreFeature& fb) {
        Vec3 between = fa.point - fb.point;
        for (const CoreFeature* f : {&fa, &fb}) {
            if (f->kind == Kind::edge) {
                const double along = f->direction.dot(between);
                between -= std::clamp(along, -f->length, f->length) * f->direction;
                if (between.norm() == 0.0) {
                    return f->direction.unitOrthogonal();
                }
            }
        }
        return between.norm() > 0.0 ? Vec3(between.stableNormalized()) : Vec3::UnitZ();
    }

    Vec3 direction_of_rims(const CoreFeature& fa, const CoreFeature& fb) const {
        RimPair pair{fa.point - fb.point, {Vec3::Zero(), Vec3::Zero()}, {0.0, 0.0}};
        Vec3 along = Vec3::Zero();
        std::size_t i = 0;
        for (const CoreFeature* f : {&fa, &fb}) {
            if (f->kind == Kind::rim) {
                pair.axis[i] = f->direction;
                pair.radius[i] = f->radius;
            } else if (f->kind == Kind::edge) {
                along = f->direction;
            }
            ++i;
        }
        return rim_direction(pair, n_, along);
    }

    const Convex& a_;
    const Convex& b_;
    Vec3 between_; ///< part's origin of a minus that of b
    double enough_;
    double slack_; ///< [m]
    Vec3 n_ = Vec3::UnitZ();
    std::vector<CoreFeature> features_a_;
    std::vector<CoreFeature> features_b_;
    std::vector<EdgeNormals> normals_a_; ///< [features_a_]
    std::vector<EdgeNormals> normals_b_;
    SeparatingDirection lead_; ///< best direction near n_
    SeparatingDirection top_;  ///< the same of those whose features are the lowest along it
    SeparatingDirection face_a_;
    SeparatingDirection face_b_;
};

} // namespace

Separation find_separation(const Convex& a, const Convex& b, double enough) {
    Ascent ascent(a, b, enough);
    const Vec3 between = a.world_from_part * Vec3::Zero() - b.world_from_part * Vec3::Zero();
    Separation result = ascent.climb(between.norm() > 0.0 ? Vec3(between.stableNormalized()) : Vec3::UnitZ());
    // Where the cores are apart there is one local maximum. Where they overlap there may be several, and libccd
    // tells which is the highest.
    if (result.best.core_gap < 0.0) {
        if (const std::optional<Vec3> n = penetration_direction(a, b)) {
            const Separation other = ascent.climb(*n);
            if (other.best.core_gap > result.best.core_gap + preference * std::max(a.size, b.size)) {
                result = other;
            }
        }
    }
    return result;
}

} // namespace sim
