#include "sim/solve/contact_solver.h"

#include "sim/model/integrate.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace sim {
namespace {

/// Flat contacts are not measured again where that changes gaps by less than this share [-] of the tolerance.
constexpr double linear_share = 0.02;

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
        return (at.b - point_b).norm() > rim_wander_share * feature.rim_radius;
    case FeatureKind::rim_on_face_b:
        return (at.a - point_a).norm() > rim_wander_share * feature.rim_radius;
    default:
        return false;
    }
}

/// What a body's surface moves [m] where it touches, while the point of contact wanders over it: the body's mean
/// motion at the mean arm. from, to: poses at both ends of the interval; touch: points of contact there.
Vec3 rolled(const Pose& from, const Pose& to, const Vec3& touch_from, const Vec3& touch_to) {
    const Quat turn = to.orientation * from.orientation.conjugate();
    const double sine = turn.vec().norm(); // of half the angle
    const Vec3 angle = sine > 0.0 ? Vec3(turn.vec() * (2.0 * std::atan(sine / turn.w()) / sine)) : Vec3(Vec3::Zero());
    const Vec3 arm = 0.5 * (touch_from - from.position + touch_to - to.position);
    return to.position - from.position + angle.cross(arm);
}

} // namespace

void ContactSolver::predict(const Bodies& bodies) {
    loop_.share(solved_bodies_.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            const std::size_t i = solved_bodies_[k];
            predicted_[i] = free_motion(bodies.props[i], bodies.pose[i], velocity_[i], settings_.gravity, h_);
            placed_[i] = PlacedBody(predicted_[i]);
            if (in_lanes_) {
                const Mat3 turn = (predicted_[i].orientation * bodies.pose[i].orientation.conjugate()).toRotationMatrix();
                const Vec3& position = predicted_[i].position;
                end_[i] = {{turn(0, 0), turn(0, 1), turn(0, 2), turn(1, 0), turn(1, 1), turn(1, 2), turn(2, 0), turn(2, 1),
                            turn(2, 2), position.x(), position.y(), position.z()}};
            }
        }
    });
}

/// How far the gaps between two flat features may be from linear in the velocity changes since they were measured [m]:
/// turning and moving between two predicted poses, to second order.
double ContactSolver::curvature_bound(const Bodies& bodies, int a, int b) const {
    double bound = 0.0;
    double turn = 0.0;
    for (const int body : {a, b}) {
        const auto i = static_cast<std::size_t>(body);
        if (bodies.props[i].is_static()) {
            continue;
        }
        const double w = std::max(velocity_[i].w.norm(), measured_[i].w.norm());
        bound += (velocity_[i].w - measured_[i].w).norm() * w * bodies.props[i].bounding_radius;
        turn += w;
    }
    const Vec3 moved = velocity_[static_cast<std::size_t>(a)].v - measured_[static_cast<std::size_t>(a)].v -
                       velocity_[static_cast<std::size_t>(b)].v + measured_[static_cast<std::size_t>(b)].v;
    return h_ * h_ * (bound + turn * moved.norm());
}

/// Gaps and displacements after the velocities changed: from the measurement before, where they are linear in the
/// change to well within the tolerance, else measured again. Returns the largest error [m] of a gap.
double ContactSolver::measure_again(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    double worst = 0.0;
    for (const ContactBlock& block : loop_.blocks) {
        if (block.count == 0) {
            continue;
        }
        if (!block.is_flat || curvature_bound(bodies, block.a, block.b) > linear_share * settings_.tolerance) {
            worst = std::max(worst, measure_block(bodies, pairs, block));
            continue;
        }
        const Vec6 twist = relative_twist(block, velocity_);
        for (int k = block.first; k < block.first + block.count; ++k) {
            const ContactPoint& point = loop_.points[static_cast<std::size_t>(k)];
            const double missing = h_ * (point.u_n_target - normal_velocity(point, twist));
            worst = std::max(worst, point.p_n > 0.0 ? std::abs(missing) : missing);
        }
    }
    return worst;
}

/// The same, eight blocks at a time.
double ContactSolver::measure_batches_again(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    unsure_.resize(loop_.batches.size());
    std::atomic<double> worst = 0.0;
    loop_.share(loop_.batches.size(), [&](std::size_t first, std::size_t last) {
        raise_to(worst, check_batches({.batches = loop_.batches.data() + first,
                                       .batch_count = last - first,
                                       .points = loop_.batch_points.data(),
                                       .velocity = velocity_.front().v.data(),
                                       .measured = measured_.front().v.data(),
                                       .radius = radius_.data(),
                                       .h = h_,
                                       .bend = linear_share * settings_.tolerance,
                                       .unsure = unsure_.data() + first}));
        for (std::size_t i = first; i < last; ++i) {
            if (in_lanes_) {
                raise_to(worst, unsure_[i] != 0 ? measure_lanes(bodies, pairs, i, i + 1, &unsure_[i]) : 0.0);
                continue;
            }
            for (std::size_t lane = 0; unsure_[i] >> lane != 0; ++lane) {
                if ((unsure_[i] >> lane & 1u) != 0) {
                    const int block = loop_.batches[i].block[lane];
                    raise_to(worst, measure_block(bodies, pairs, loop_.blocks[static_cast<std::size_t>(block)]));
                }
            }
        }
    });
    return worst;
}

/// Gaps and displacements at the predicted poses, and the targets that close them (eq. 8: the velocity change
/// d_n / h). Returns the largest error [m] of a gap, two-sided where the contact carries load.
double ContactSolver::measure(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    std::atomic<double> worst = 0.0;
    if (in_lanes_) {
        loop_.share(loop_.batches.size(), [&](std::size_t first, std::size_t last) {
            raise_to(worst, measure_lanes(bodies, pairs, first, last, nullptr));
        });
        return worst;
    }
    loop_.share(loop_.blocks.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            raise_to(worst, measure_block(bodies, pairs, loop_.blocks[k]));
        }
    });
    return worst;
}

/// Normal of a flat block at the predicted poses; of others as the interval begins.
Vec3 ContactSolver::predicted_normal(const Bodies& bodies, const ContactBlock& block) const {
    const Vec3 n = block.frame.col(2);
    if (!block.is_flat) {
        return n;
    }
    const auto face = static_cast<std::size_t>(block.is_face_of_a ? block.a : block.b);
    return placed_[face].rotation * (bodies.pose[face].orientation.conjugate() * n);
}

double ContactSolver::measure_block(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                    const ContactBlock& block) {
    double worst = 0.0;
    const Vec6 twist = relative_twist(block, velocity_);
    const Vec3 n = predicted_normal(bodies, block);
    for (int k = block.first; k < block.first + block.count; ++k) {
        const RestingContact& contact = contacts_[static_cast<std::size_t>(k)];
        worst = std::max(worst, measure_point(bodies, pairs[static_cast<std::size_t>(contact.pair)], {block, twist, n, contact},
                                              loop_.points[static_cast<std::size_t>(k)]));
    }
    return worst;
}

/// Sets the targets of a point; returns the error of its gap.
double ContactSolver::measure_point(const Bodies& bodies, const PairContacts& pair, const Measured& of,
                                    ContactPoint& point) const {
    const auto& [block, twist, n, contact] = of;
    Displacement moved;
    if (contact.is_on_face) {
        const Vec3 d = placed_[static_cast<std::size_t>(block.a)] * contact.point_a -
                       placed_[static_cast<std::size_t>(block.b)] * contact.point_b;
        moved.gap = n.dot(d);
        moved.d_t = block.frame.leftCols<2>().transpose() * (d - moved.gap * n);
    } else {
        moved = displacement(bodies, pair, of, point);
    }
    const double missing = contact.gap_target - moved.gap;
    point.u_n_target = normal_velocity(point, twist) + missing / h_;
    if (block.has_friction()) {
        point.u_t_target = tangential_velocity(point, twist) - (moved.d_t + contact.owed) / h_;
    }
    return point.p_n > 0.0 ? std::abs(missing) : missing;
}

/// Of a point of the block, whatever touches there.
ContactSolver::Displacement ContactSolver::displacement(const Bodies& bodies, const PairContacts& pair, const Measured& of,
                                                        const ContactPoint& point) const {
    const ContactBlock& block = of.block;
    const RestingContact& contact = of.contact;
    const auto a = static_cast<std::size_t>(block.a);
    const auto b = static_cast<std::size_t>(block.b);
    const PlacedBody& pose_a = placed_[a];
    const PlacedBody& pose_b = placed_[b];
    const auto& [feature, start] = pair.manifold.contacts[static_cast<std::size_t>(contact.index)];
    const Vec3 point_a = pose_a * contact.point_a;
    const Vec3 point_b = pose_b * contact.point_b;
    const Vec3 d = point_a - point_b;
    ContactGeometry at = contact_geometry(feature, pose_a, pose_b);
    if (wanders(feature, at, point_a, point_b,
                std::min(bodies.props[a].bounding_radius, bodies.props[b].bounding_radius))) {
        at.n = block.frame.col(2);
        at.a = point_a;
        at.b = point_b;
        at.gap = at.n.dot(d);
    }
    const Eigen::Matrix<double, 3, 2> tangents = block.frame.leftCols<2>();
    if (!block.has_friction()) {
        return {at.gap};
    }
    if (feature.rim_radius > 0.0) {
        return {at.gap, tangents.transpose() * (rolled(bodies.pose[a], predicted_[a], start.a, at.a) -
                                                rolled(bodies.pose[b], predicted_[b], start.b, at.b))};
    }
    if (is_curved(feature)) {
        // A point fixed to a turning ball leaves the surface: rolling is measured by the velocity at mid-step.
        const Vec3 fall = 0.5 * h_ * relative_gravity(bodies, pair.manifold, settings_);
        return {at.gap, h_ * (tangential_velocity(point, of.twist) + tangents.transpose() * fall)};
    }
    return {at.gap, tangents.transpose() * (d - d.dot(at.n) * at.n)};
}

} // namespace sim
