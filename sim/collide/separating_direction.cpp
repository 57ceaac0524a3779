#include "sim/collide/separating_direction.h"

#include "sim/collide/ccd_bridge.h"
#include "sim/collide/edge_direction.h"
#include "sim/collide/rim_direction.h"
#include "sim/model/polytope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sim {
namespace {

/// Gaps that differ by less than this share [-] of the cores' size are equal, by rounding: a face is preferred to other
/// features then, and a face of a to one of b.
constexpr double preference = 1e-11;

/// Steps towards a direction along which the cores are apart: at first, which saves passes of the ascent; and at most.
constexpr int first_steps = 3;
constexpr int most_steps = 32;

/// Passes of the ascent; each moves to a neighbouring pair of features.
constexpr int pass_limit = 60;

/// No better direction is searched for than one that may be beaten by this share [-] of the size: of bodies that lie flat on each other,
/// but for rounding, many are as good.
constexpr double nearly_best = 1e-6;

/// Two points are told to be the nearest ones of the cores where they are this many times the rounding apart.
constexpr double proof = 1e3;

using Kind = CoreFeature::Kind;

/// How far inside a face's boundary x lies, seen along its normal [m]; negative outside.
double inside_of(const Convex& convex, const CoreFeature& face, const Vec3& x) {
    if (convex.kind == CoreKind::cylinder) {
        return face.radius - (x - face.point).cross(face.direction).norm();
    }
    double least = std::numeric_limits<double>::infinity();
    const std::vector<int>& loop = convex.polytope->faces[static_cast<std::size_t>(face.index)].loop;
    Vec3 from = convex.vertex(loop.back());
    for (const int v : loop) {
        const Vec3 to = convex.vertex(v);
        least = std::min(least, (from - to).cross(face.direction).dot(x - from) / (from - to).norm());
        from = to;
    }
    return least;
}

/// A vertex and another feature.
struct VertexPair {
    Vec3 n;
    double distance; ///< of the features' points along n [m]
    std::size_t i;   ///< [features_a]
    std::size_t j;   ///< [features_b]
};

/// Of a search, kept for the next one.
struct AscentMemory {
    std::vector<CoreFeature> features_a;
    std::vector<CoreFeature> features_b;
    std::vector<EdgeNormals> normals_a; ///< [features_a]
    std::vector<EdgeNormals> normals_b;
    std::vector<VertexPair> vertex_pairs;
};
thread_local AscentMemory ascent_memory;

class Ascent {
public:
    Ascent(const Convex& a, const Convex& b, double enough)
        : a_(a), b_(b), enough_(enough), slack_(preference * std::max(a.size, b.size)) {}

    double gap(const Vec3& n) const { return core_gap(a_, b_, n); }

    /// Moves uphill from n until no pair of neighbouring features is better; false where the gap is known to exceed
    /// `enough` before.
    bool climb(const Vec3& n) {
        best = {};
        best.n = n;
        best.core_gap = gap(n);
        for (int pass = 0; pass < pass_limit; ++pass) {
            if (best.core_gap > enough_) {
                return false;
            }
            find_candidates(best.n, best.core_gap - slack_);
            if (lead_.core_gap == none) {
                find_candidates(best.n, none); // n is the direction itself, within rounding
            }
            if (is_proven_ || (pass > 0 && !(lead_.core_gap > best.core_gap + slack_))) {
                break;
            }
            best = lead_;
        }
        if (top_.core_gap + slack_ >= best.core_gap) {
            best = top_;
        }
        return best.core_gap <= enough_;
    }

    /// Is a direction near n that two features define known to be the best of all? Then it is `best`.
    bool ends_near(const Vec3& n) {
        begin_pass(none, &n);
        n_.setZero(); // of what meets along n faces only
        faces_along(a_, -n, nearly_flat, features_a_);
        faces_along(b_, n, nearly_flat, features_b_);
        for_each_face([&](const CoreFeature& face, bool is_of_a, const Vec3& along) {
            if (!is_proven_) {
                try_face(along_face(face, is_of_a, along));
            }
        });
        if (!is_proven_) {
            look_along(n);
            const double most_along = std::sqrt(1.0 - nearly_flat * nearly_flat);
            const auto leans = [&](const CoreFeature& f) { return f.kind == Kind::edge && std::abs(f.direction.dot(n)) > most_along; };
            std::erase_if(features_a_, leans);
            std::erase_if(features_b_, leans);
            try_vertices();
            try_edges_and_rims();
        }
        best = is_proven_ ? top_ : best;
        return is_proven_;
    }

    /// The best direction of a face near `best`, or no worse than it; of a, if one of it is as good as those of b.
    SeparatingDirection face_near_best() {
        if (best.is_face_of_a) {
            return best;
        }
        if (n_ != best.n) {
            look_along(best.n, false);
        }
        SeparatingDirection of_a;
        SeparatingDirection of_b;
        of_a.core_gap = of_b.core_gap = none;
        for_each_face([&](const CoreFeature& face, bool is_of_a, const Vec3& n) {
            if (n.dot(best.n) > nearly_flat || bound(face, is_of_a) + slack_ >= best.core_gap) {
                take(is_of_a ? of_a : of_b, along_face(face, is_of_a, n));
            }
        });
        return of_a.core_gap + slack_ >= of_b.core_gap ? of_a : of_b;
    }

    /// Of cores that overlap, is the local maximum `best` known to be the largest of all, but for nearly_best? It is where the ball about
    /// the origin that touches the surface of their difference, in the direction of `best`, lies within the difference.
    bool is_least_depth() {
        const Vec3& n = best.n;
        const double slack = nearly_best * std::max(a_.size, b_.size);
        const SeparatingDirection face = best.is_face() ? best : face_near_best();
        if (face.is_face() && face.core_gap + slack >= best.core_gap &&
            is_within_cone(face.n, face.core_gap + slack, inside_of_face(face, slack))) {
            return true;
        }
        if (best.is_face() || n.dot(best.a.point - best.b.point) - reach(best.a, n) - reach(best.b, n) > best.core_gap + slack_) {
            return false;
        }
        if (has_rim(best.a, best.b)) {
            return best.a.kind == Kind::rim ? is_within_disc(best.a, best.b, n, -best.core_gap)
                                            : is_within_disc(best.b, best.a, -n, -best.core_gap);
        }
        return are_edges(best.a, best.b) && is_within_cone(n, best.core_gap, inside_of_ends(best.a, best.b));
    }

    SeparatingDirection best;

private:
    static constexpr double none = -std::numeric_limits<double>::infinity();

    /// Of equal gaps that without a rim: a rim has the direction of the side that it ends, too, but what touches the side need not
    /// touch it there.
    void take(SeparatingDirection& kept, const SeparatingDirection& found) const {
        const int more_rims = int{has_rim(found.a, found.b)} - int{has_rim(kept.a, kept.b)};
        if (found.core_gap > kept.core_gap + more_rims * slack_) {
            kept = found;
        }
    }

    void look_along(const Vec3& n, bool with_edges = true) {
        n_ = n;
        near_features(a_, -n, features_a_, with_edges);
        near_features(b_, n, features_b_, with_edges);
    }

    /// What any two points of the cores are apart along n is no less than the gap [m].
    double bound(const CoreFeature& face, bool is_of_a) const {
        return is_of_a ? -face.direction.dot(face.point - features_b_.front().point)
                       : face.direction.dot(features_a_.front().point - face.point);
    }

    SeparatingDirection along_face(const CoreFeature& face, bool is_of_a, const Vec3& n) const {
        return is_of_a ? SeparatingDirection{n, gap(n), true, false, face, {}} : SeparatingDirection{n, gap(n), false, true, {}, face};
    }

    /// f(face, is it of a?, n).
    template <typename F>
    void for_each_face(F&& f) const {
        for (const CoreFeature& face : features_a_) {
            if (face.kind == Kind::face) {
                f(face, true, Vec3(-face.direction));
            }
        }
        for (const CoreFeature& face : features_b_) {
            if (face.kind == Kind::face) {
                f(face, false, face.direction);
            }
        }
    }

    /// lead_: the best of the directions that the features near n define, of those that may be better than `least` [m].
    /// top_: the best of those whose features are the lowest along it. Where two points of the cores are found that are as far
    /// apart as the cores along their direction, it is the largest gap of all, and the search is at its end: is_proven_.
    void find_candidates(const Vec3& n, double least) {
        look_along(n);
        begin_pass(least, nullptr);
        for_each_face([&](const CoreFeature& face, bool is_of_a, const Vec3& along) {
            if (!is_proven_ && is_worthwhile(bound(face, is_of_a))) {
                try_face(along_face(face, is_of_a, along));
            }
        });
        try_edges_and_rims();
        try_vertices();
    }

    /// near: if not null, no directions are tried but those near it.
    void begin_pass(double least, const Vec3* near) {
        top_ = lead_ = {};
        top_.core_gap = lead_.core_gap = none;
        least_ = least;
        near_ = near;
        is_proven_ = false;
    }

    double worthwhile() const { return std::max(least_, top_.core_gap); }
    bool is_worthwhile(double bound) const { return bound >= worthwhile(); }

    void try_face(const SeparatingDirection& face) {
        take(lead_, face);
        take(top_, face);
        const double inside = inside_of_face(face, same_gap * std::max(a_.size, b_.size));
        is_proven_ = inside >= 0.0 && (face.core_gap > proof * slack_ || is_within_cone(face.n, face.core_gap, inside));
    }

    /// How far inside the face's boundary what the other core has nearest to it, within `slack` [m], lies [m]; negative outside.
    double inside_of_face(const SeparatingDirection& face, double slack) const {
        return face.is_face_of_a ? inside_of(a_, face.a, support_middle(b_, face.n, slack))
                                 : inside_of(b_, face.b, support_middle(a_, -face.n, slack));
    }

    /// Where the surface of the cores' difference is flat, as far as `disc` [m] about its point nearest to the origin: does the cone
    /// from there to the middle of the difference hold the ball about the origin that touches it there? gap: along n [m].
    bool is_within_cone(const Vec3& n, double gap, double disc) const {
        const double depth = std::max(-gap, 0.0);
        const Vec3 centre = a_.centre() - b_.centre();
        const double height = n.dot(centre) + depth;
        const double aside = disc + (centre - n * n.dot(centre)).norm();
        return disc > 0.0 && height * disc - depth * aside >= depth * std::hypot(height, aside);
    }

    void try_edges_and_rims() {
        if (is_proven_) {
            return;
        }
        find_edge_normals(a_, features_a_, normals_a_);
        find_edge_normals(b_, features_b_, normals_b_);
        for_each_pair([&](std::size_t i, std::size_t j) {
            const CoreFeature& fa = features_a_[i];
            const CoreFeature& fb = features_b_[j];
            if (has_rim(fa, fb)) {
                if (may_be_between_faces(fa, fb, i, j)) {
                    try_direction(rim_direction(fa, fb, n_), fa, fb);
                }
            } else if (are_edges(fa, fb)) {
                try_direction(edge_direction(fa, fb, normals_a_[i], normals_b_[j]), fa, fb);
            }
        });
    }

    /// A vertex and another feature, no rim: the two nearest first, which end the search where they are the nearest of all.
    void try_vertices() {
        if (is_proven_) {
            return;
        }
        vertex_pairs_.clear();
        for_each_pair([&](std::size_t i, std::size_t j) {
            const CoreFeature& fa = features_a_[i];
            const CoreFeature& fb = features_b_[j];
            if (!has_rim(fa, fb) && !are_edges(fa, fb)) {
                const Vec3 n = direction_of_vertex(fa, fb);
                vertex_pairs_.push_back({n, n.dot(fa.point - fb.point), i, j});
            }
        });
        std::ranges::sort(vertex_pairs_, {}, &VertexPair::distance);
        for (const VertexPair& pair : vertex_pairs_) {
            try_direction(pair.n, features_a_[pair.i], features_b_[pair.j]);
        }
    }

    /// f(i, j) for features that are no faces.
    template <typename F>
    void for_each_pair(F&& f) const {
        for (std::size_t i = 0; i < features_a_.size(); ++i) {
            for (std::size_t j = 0; features_a_[i].kind != Kind::face && j < features_b_.size(); ++j) {
                if (features_b_[j].kind != Kind::face) {
                    f(i, j);
                }
            }
        }
    }

    static bool has_rim(const CoreFeature& fa, const CoreFeature& fb) { return fa.kind == Kind::rim || fb.kind == Kind::rim; }
    static bool are_edges(const CoreFeature& fa, const CoreFeature& fb) {
        return fa.kind == Kind::edge && fb.kind == Kind::edge;
    }

    void try_direction(const Vec3& n, const CoreFeature& fa, const CoreFeature& fb) {
        if (near_ != nullptr && !(n.dot(*near_) > nearly_flat)) {
            return;
        }
        const double apart = n.dot(fa.point - fb.point);
        if (is_proven_ || n.isZero(0.0) || !is_worthwhile(apart)) {
            return;
        }
        const SeparatingDirection found{n, gap(n), false, false, fa, fb};
        take(lead_, found);
        const double round = reach(fa, n) + reach(fb, n);
        if (apart - round <= found.core_gap + slack_) {
            take(top_, found);
            is_proven_ = found.core_gap > proof * slack_
                             ? are_nearest(found)
                             : are_edges(fa, fb) && is_within_cone(n, found.core_gap, inside_of_ends(fa, fb));
        }
    }

    /// Do two points of features that are the lowest along n lie along it?
    bool are_nearest(const SeparatingDirection& found) const {
        const auto& [n, gap, of_a, of_b, fa, fb] = found;
        if (are_edges(fa, fb)) {
            return inside_of_ends(fa, fb) >= 0.0;
        }
        if (!has_rim(fa, fb)) {
            const Vec3 between = fa.point - fb.point; // one of them a vertex, without direction and length
            return std::abs(fa.direction.dot(between)) <= fa.length && std::abs(fb.direction.dot(between)) <= fb.length;
        }
        const bool is_a = fa.kind == Kind::rim;
        const CoreFeature& rim = is_a ? fa : fb;
        const CoreFeature& other = is_a ? fb : fa;
        const Vec3 u = is_a ? n : Vec3(-n); // into the rim's body
        const Vec3 x = lowest_rim_point(rim.point, rim.direction, rim.radius, u);
        Vec3 y = other.point;
        if (other.kind == Kind::rim) {
            y = lowest_rim_point(y, other.direction, other.radius, -u);
        } else if (other.kind == Kind::edge) {
            y += std::clamp(other.direction.dot(x - y), -other.length, other.length) * other.direction + other.radius * u;
        }
        return (x - y).norm() <= gap + slack_;
    }

    /// How far a feature reaches beyond its point along n or against it [m].
    static double reach(const CoreFeature& f, const Vec3& n) {
        return f.kind == Kind::rim ? f.radius * f.direction.cross(n).norm() : f.radius;
    }

    /// Of a rim and an edge of a polytope: else one of the faces that it joins is as good.
    bool may_be_between_faces(const CoreFeature& fa, const CoreFeature& fb, std::size_t i, std::size_t j) const {
        if (fa.kind == Kind::edge && a_.kind == CoreKind::polytope) {
            return may_be_between(fb, fa, normals_a_[i].left, normals_a_[i].right, worthwhile());
        }
        return fb.kind != Kind::edge || b_.kind != CoreKind::polytope ||
               may_be_between(fa, fb, normals_b_[j].left, normals_b_[j].right, worthwhile());
    }

    /// From the nearest point of b to that of a, at least one of them a vertex, of an edge also beyond its ends: of all directions
    /// along which the edge is the lowest it is the best, and uphill from n. That to the end need not be.
    static Vec3 direction_of_vertex(const CoreFeature& fa, const CoreFeature& fb) {
        Vec3 between = fa.point - fb.point;
        for (const CoreFeature* f : {&fa, &fb}) {
            if (f->kind == Kind::edge) {
                between -= f->direction.dot(between) * f->direction;
                if (between.norm() == 0.0) {
                    return f->direction.unitOrthogonal();
                }
            }
        }
        return between.norm() > 0.0 ? Vec3(between.stableNormalized()) : Vec3::UnitZ();
    }

    const Convex& a_;
    const Convex& b_;
    double enough_;
    double slack_; ///< [m]
    Vec3 n_ = Vec3::UnitZ();
    std::vector<CoreFeature>& features_a_ = ascent_memory.features_a;
    std::vector<CoreFeature>& features_b_ = ascent_memory.features_b;
    std::vector<EdgeNormals>& normals_a_ = ascent_memory.normals_a;
    std::vector<EdgeNormals>& normals_b_ = ascent_memory.normals_b;
    std::vector<VertexPair>& vertex_pairs_ = ascent_memory.vertex_pairs;
    double least_ = none;
    const Vec3* near_ = nullptr;
    SeparatingDirection lead_;
    SeparatingDirection top_;
    bool is_proven_ = false;
};

Vec3 of_centres(const Convex& a, const Convex& b) {
    const Vec3 between = a.centre() - b.centre();
    return between.norm() > 0.0 ? Vec3(between.stableNormalized()) : Vec3::UnitZ();
}

/// A direction along which the cores are apart, if they are: the nearest point to the origin in the difference of the cores,
/// by so many steps at most towards one support point after the other (Gilbert 1966).
std::optional<Vec3> direction_apart(const Convex& a, const Convex& b, int steps) {
    Vec3 nearest = a.centre() - b.centre();
    for (; steps > 0 && nearest.norm() > 0.0; --steps) {
        const Vec3 n = nearest.stableNormalized();
        const Vec3 lowest = support_point(a, -n) - support_point(b, n);
        if (n.dot(lowest) > 0.0) {
            return n;
        }
        const Vec3 on = lowest - nearest;
        nearest -= std::clamp(nearest.dot(on) / on.squaredNorm(), -1.0, 0.0) * on;
    }
    return std::nullopt;
}

/// Against a face of a or along one of b: that along which the cores are farthest apart.
std::optional<Vec3> direction_of_faces(const Ascent& ascent, const Convex& a, const Convex& b) {
    std::optional<Vec3> best;
    double largest = -std::numeric_limits<double>::infinity();
    const auto try_faces_of = [&](const Convex& convex, double sign) {
        if (convex.kind != CoreKind::polytope) {
            return;
        }
        for (const Polytope::Face& face : convex.polytope->faces) {
            const Vec3 n = sign * convex.turned(face.normal);
            if (const double gap = ascent.gap(n); gap > largest) {
                largest = gap;
                best = n;
            }
        }
    };
    try_faces_of(a, -1.0);
    try_faces_of(b, 1.0);
    return best;
}

/// Where the cores are apart there is one local maximum with s(n) > 0, but others may be below: where an ascent ends in
/// one of them, it begins anew where they are apart, at a face, and where libccd says. False where the gap exceeds `enough`.
bool find_best(Ascent& ascent, const Convex& a, const Convex& b) {
    bool is_within = ascent.climb(direction_apart(a, b, first_steps).value_or(of_centres(a, b)));
    const auto climb_from = [&](const std::optional<Vec3>& n) {
        const SeparatingDirection first = ascent.best;
        is_within = !n || ascent.climb(*n);
        if (!(ascent.best.core_gap > first.core_gap + preference * std::max(a.size, b.size))) {
            ascent.best = first;
        }
    };
    if (ascent.best.core_gap >= 0.0 || ascent.is_least_depth()) {
        return is_within;
    }
    climb_from(direction_apart(a, b, most_steps));
    if (ascent.best.core_gap < 0.0) {
        climb_from(direction_of_faces(ascent, a, b));
    }
    if (ascent.best.core_gap < 0.0) {
        climb_from(penetration_direction(a, b));
    }
    return is_within;
}

} // namespace

double core_gap(const Convex& a, const Convex& b, const Vec3& n) {
    return n.dot(a.world_from_part.position - b.world_from_part.position) - support_height(a, -n) - support_height(b, n);
}

Separation find_separation(const Convex& a, const Convex& b, double enough, const Vec3* near) {
    Ascent ascent(a, b, enough);
    Separation result;
    result.is_beyond = near != nullptr && ascent.ends_near(*near) ? ascent.best.core_gap > enough : !find_best(ascent, a, b);
    result.best = ascent.best;
    if (!result.is_beyond) {
        result.best_face = ascent.face_near_best();
        if (result.best_face.is_face() &&
            result.best_face.core_gap + same_gap * std::max(a.size, b.size) >= result.best.core_gap) {
            result.best = result.best_face;
        }
    }
    return result;
}

Vec3 find_direction(const Convex& a, const Convex& b, double enough) {
    Ascent ascent(a, b, enough);
    find_best(ascent, a, b);
    return ascent.best.n;
}

} // namespace sim
