#include "sim/solve/gap_measure.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace sim {
namespace {

/// As wander_share, of the lowest point of a rim that falls flat or circles, as a share [-] of the rim's radius: a step
/// turns what rolls by less. The far side is then held by the points fixed to the rim.
constexpr double rim_wander_share = 0.5;

/// Has the touch left the material points that touched as the interval began, so far that they have to stand for it?
/// point_a, point_b: where these are now; size [m]: of the smaller body.
bool wanders(const ContactFeature& feature, const ContactGeometry& at, const Vec3& point_a, const Vec3& point_b,
             double size) {
    switch (feature.kind) {
    case FeatureKind::edges:
        return (at.a - point_a).norm() > wander_share * size;
    case FeatureKind::rim_on_face_a:
        return (at.b() - point_b).norm() > rim_wander_share * feature.radius_b;
    case FeatureKind::rim_on_face_b:
        return (at.a - point_a).norm() > rim_wander_share * feature.radius_a;
    default:
        return false;
    }
}

/// How a body moves over the interval.
struct BodyMotion {
    const Pose& from;
    const Pose& to; ///< predicted
    PlacedBody placed; ///< the same
    Vec3 turn;         ///< [rad] about its axis; of a ball that spins fast more than once round
    double size;       ///< [m] of the body

    BodyMotion(const BodyProps& props, const Pose& begin, const Pose& end, const Vec3& turn_of_ball)
        : from(begin), to(end), placed(end), turn(turn_of_ball), size(props.bounding_radius) {
        if (props.is_static() || props.inertia_kind != InertiaKind::spherical) {
            const Quat between = to.orientation * from.orientation.conjugate();
            const double sine = between.vec().norm(); // of half the angle
            turn = sine > 0.0 ? Vec3(between.vec() * (2.0 * std::atan(sine / between.w()) / sine)) : Vec3(Vec3::Zero());
        }
    }

    /// Where a point of the body is at the end that was there at the start.
    Vec3 moved(const Vec3& point) const { return placed * (from.orientation.conjugate() * (point - from.position)); }

    /// What its surface moves [m] where it touches, while the point of contact wanders over it: the body's mean motion at the mean
    /// arm. touch: points of contact at both ends.
    Vec3 rolled(const Vec3& touch_from, const Vec3& touch_to) const {
        const Vec3 arm = 0.5 * (touch_from - from.position + touch_to - to.position);
        return to.position - from.position + turn.cross(arm);
    }
};

struct Displacement {
    double gap = 0.0; ///< [m] at the predicted poses
    Vec2 d_t;         ///< [m] tangential, over the interval; along the block's tangents
    bool has_wandered = false; ///< the touch, too far
};

/// What the interval does to a contact. frame: the block's t_1, t_2, n; has_wandered: the touch, by the poses that were predicted
/// before.
Displacement displacement(const BodyMotion& a, const BodyMotion& b, const FoundContact& contact, const Mat3& frame,
                          bool has_wandered) {
    const Eigen::Matrix<double, 3, 2> tangents = frame.leftCols<2>();
    const Vec3 n = frame.col(2);
    const ContactGeometry& start = contact.at;
    const ContactFeature& feature = contact.feature;
    const ContactGeometry at = contact_geometry(feature, a.placed, b.placed);
    const auto rolled = [&](const Vec3& end_a, const Vec3& end_b) {
        return Vec2(tangents.transpose() * (a.rolled(start.a, end_a) - b.rolled(start.b(), end_b)));
    };
    if (is_curved(feature) && !is_rim(feature.kind) && feature.kind != FeatureKind::edges) {
        return {at.gap, rolled(at.a, at.b())}; // a point fixed to a turning ball leaves the surface
    }
    const Vec3 point_a = a.moved(start.a);
    const Vec3 point_b = b.moved(start.b());
    const Vec3 d = point_a - point_b;
    const bool is_left = has_wandered || wanders(feature, at, point_a, point_b, std::min(a.size, b.size));
    const double gap = is_left ? n.dot(d) : at.gap;
    if (is_curved(feature)) {
        return {gap, is_left ? rolled(point_a, point_b) : rolled(at.a, at.b()), is_left};
    }
    const Vec3& across = is_left ? n : at.n;
    return {gap, tangents.transpose() * (d - d.dot(across) * across), is_left};
}

} // namespace

double GapMeasure::measure() const {
    Blocks& loop = contacts.loop;
    std::atomic<double> worst = 0.0;
    loop.share_batches([&](std::size_t first, std::size_t last) {
        raise_to(worst, contacts.work(RestPhase::measure, first, last, to.velocity));
        for (std::size_t i = first; i < last; ++i) {
            raise_to(worst, measure_others(i));
        }
    });
    return worst;
}

/// The same for the lanes of batch i that the kernel leaves.
double GapMeasure::measure_others(std::size_t i) const {
    const BlockBatch& batch = contacts.loop.batches[i];
    double worst = 0.0;
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (batch.block[lane] >= 0 && (contacts.rest_blocks[i].plain >> lane & 1u) == 0) {
            worst = std::max(worst, measure_lane(batch, lane));
        }
    }
    return worst;
}

/// The same for a block of any features.
double GapMeasure::measure_lane(const BlockBatch& batch, std::size_t lane) const {
    Blocks& loop = contacts.loop;
    const Block& block = loop.blocks[static_cast<std::size_t>(batch.block[lane])];
    const LaneFrame frame(batch, lane);
    const auto a = static_cast<std::size_t>(block.a);
    const auto b = static_cast<std::size_t>(block.b);
    const Manifold& manifold = pairs[static_cast<std::size_t>(block.pair)].manifold;
    const BodyMotion of_a(bodies.props[a], bodies.pose[a], to.pose[a], to.h * to.velocity[a].w);
    const BodyMotion of_b(bodies.props[b], bodies.pose[b], to.pose[b], to.h * to.velocity[b].w);
    const Vec6 twist = frame.relative_twist(to.velocity);
    double worst = 0.0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(block.count); ++k) {
        const auto at = static_cast<std::size_t>(batch.first) + k;
        BatchPoint& in_lanes = loop.points[at];
        const LanePoint point(in_lanes, lane);
        const Contact& contact = *loop.contacts[static_cast<std::size_t>(block.first) + k];
        const Displacement moved =
            displacement(of_a, of_b, manifold.found(contact, of_a.from, of_b.from), frame.frame,
                         (in_lanes.wandered >> lane & 1u) != 0);
        in_lanes.wandered |= static_cast<unsigned>(moved.has_wandered) << lane;
        const double missing = contacts.rest_points[at].gap_target.x[lane] - moved.gap;
        in_lanes.u_n_target.x[lane] = point.normal_velocity(twist) + missing / to.h;
        const Vec2 target = point.tangential_velocity(twist) - moved.d_t / to.h;
        in_lanes.u_t_target[0].x[lane] = target.x();
        in_lanes.u_t_target[1].x[lane] = target.y();
        worst = std::max(worst, point.p_n > 0.0 ? std::abs(missing) : missing);
    }
    return worst;
}

} // namespace sim
