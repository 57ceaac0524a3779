#include "sim/world/state.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Pairs are searched for as far as bodies get in this many steps at their present speed, and this share [-] of
/// their size: the search then serves several steps.
constexpr double search_steps = 10.0;
constexpr double search_share = 0.01;

/// A body whose box was made for so many times [-] its present reach is searched for again, too.
constexpr double wide_box = 3.0;

/// Where no more than this share [-] of the bodies came near the ends of the boxes they were given, others keep theirs.
constexpr double few_escaped = 0.25;

/// Pairs are searched for in a frame that moves with the bodies where that makes their speeds less than this share [-].
constexpr double frame_share = 0.5;

/// How many times [-] as fast a body may turn by its inertia alone: its energy is kept.
double spin_growth(const BodyProps& props) {
    return props.inertia_kind == InertiaKind::spherical
               ? 1.0
               : std::sqrt(props.principal_inertia.maxCoeff() / props.principal_inertia.minCoeff());
}

/// Middle value of each component of the dynamic bodies' velocities [m/s]; zero if that is not far nearer to them.
Vec3 common_velocity(std::span<const BodyProps> props, std::span<const Velocity> velocity) {
    Vec3 middle = Vec3::Zero();
    std::vector<double> values;
    for (int axis = 0; axis < 3; ++axis) {
        values.clear();
        for (std::size_t i = 0; i < props.size(); ++i) {
            if (!props[i].is_static()) {
                values.push_back(velocity[i].v[axis]);
            }
        }
        if (values.empty()) {
            return middle;
        }
        const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
        std::ranges::nth_element(values, at);
        middle[axis] = *at;
    }
    double from_middle = 0.0;
    double from_rest = 0.0;
    for (std::size_t i = 0; i < props.size(); ++i) {
        from_middle += (velocity[i].v - middle).norm();
        from_rest += velocity[i].v.norm();
    }
    return from_middle < frame_share * from_rest ? middle : Vec3(Vec3::Zero());
}

} // namespace

double moved_by(const BodyProps& props, const Pose& from, const Pose& to, const Vec3& drift) {
    if (props.is_static()) {
        return drift.norm();
    }
    const double turn = 2.0 * (to.orientation * from.orientation.conjugate()).vec().norm();
    return (to.position - from.position - drift).norm() + turn * props.bounding_radius;
}

/// How far the frame of the search falls in t [s]; at rest it stays [m].
Vec3 WorldState::search_drift_in(double t) const {
    return search_frame.isZero(0.0) ? Vec3(Vec3::Zero()) : Vec3(t * search_frame + 0.5 * t * t * settings.gravity);
}

/// How far each body may move in the step, in the frame of the search.
void WorldState::find_reach() {
    reach.resize(reported_count);
    rim_speed.resize(reported_count);
    for (std::size_t i = 0; i < reported_count; ++i) {
        const BodyProps& props = bodies.props[i];
        const Velocity& velocity = bodies.velocity[i];
        rim_speed[i] = props.is_static() ? 0.0 : velocity.w.norm() * props.bounding_radius;
        const double spin = props.is_static() ? 0.0 : spin_growth(props) * rim_speed[i];
        reach[i] = h * ((velocity.v - search_frame).norm() + spin + h * settings.gravity.norm());
    }
}

/// May body i leave the box it was given, by its `reach`?
bool WorldState::has_escaped(std::size_t i) const {
    return moved_by(bodies.props[i], searched_pose[i], bodies.pose[i], search_drift) + reach[i] > searched_reach[i];
}

/// Pairs of bodies that may touch while each moves by up to its `reach` from its present pose: the last search still
/// tells those of bodies that are not escaped.
void WorldState::find_candidates() {
    const bool is_first = searched_pose.size() != reported_count;
    escaped.clear();
    for (std::size_t i = 0; !is_first && i < reported_count; ++i) {
        if (has_escaped(i) || searched_reach[i] > wide_box * search_reach(i)) {
            escaped.push_back(static_cast<int>(i));
        }
    }
    if (is_first || have_many_escaped() || searched_again > reported_count) {
        search_frame = common_velocity(std::span(bodies.props).first(reported_count), bodies.velocity);
        find_reach();
        find_all_candidates();
    } else {
        find_candidates_of_escaped();
    }
}

bool WorldState::have_many_escaped() const {
    return static_cast<double>(escaped.size()) > few_escaped * static_cast<double>(reported_count);
}

/// How far body i may move before its pairs are searched for again [m].
double WorldState::search_reach(std::size_t i) const {
    return search_steps * reach[i] +
           (bodies.props[i].is_static() ? 0.0 : search_share * bodies.props[i].bounding_radius);
}

/// Where body i may get to until then: a box in the frame of the search.
void WorldState::set_search_box(std::size_t i) {
    searched_reach[i] = search_reach(i);
    searched_pose[i] = bodies.pose[i];
    searched_pose[i].position -= search_drift;
    boxes[i] = searched_box(i);
}

/// By where it was searched for.
Bounds WorldState::searched_box(std::size_t i) const {
    Bounds box = bounds(bodies.props[i].shape, searched_pose[i]);
    const Vec3 margin = Vec3::Constant(searched_reach[i] + 0.5 * margin_tolerances * settings.tolerance);
    box.lower -= margin;
    box.upper += margin;
    return box;
}

void WorldState::find_all_candidates() {
    search_drift.setZero();
    searched_pose.resize(reported_count);
    searched_reach.resize(reported_count);
    boxes.resize(reported_count);
    for (std::size_t i = 0; i < reported_count; ++i) {
        set_search_box(i);
    }
    searched_again = 0;
    search();
}

/// All pairs whose search boxes overlap become candidates.
void WorldState::search() {
    broad_phase.find_pairs(boxes, found_pairs);
    is_unseen.assign(reported_count, 1);
    candidates.clear();
    free_slots.clear();
    axes.clear();
    separations.clear();
    add_candidates();
}

void WorldState::find_candidates_of_escaped() {
    if (escaped.empty()) {
        return;
    }
    searched_again += escaped.size();
    std::vector<char> has_moved_on(reported_count, 0);
    for (const int i : escaped) {
        set_search_box(static_cast<std::size_t>(i));
        is_unseen[static_cast<std::size_t>(i)] = has_moved_on[static_cast<std::size_t>(i)] = 1;
    }
    std::erase_if(candidates, [&](const Candidate& candidate) {
        const auto& [pair, slot] = candidate;
        const bool is_old =
            has_moved_on[static_cast<std::size_t>(pair.a)] != 0 || has_moved_on[static_cast<std::size_t>(pair.b)] != 0;
        if (is_old) {
            free_slots.push_back(slot);
        }
        return is_old;
    });
    broad_phase.find_pairs_of(escaped, boxes, found_pairs);
    add_candidates();
}

/// The pairs found, none of which is a candidate, become candidates.
void WorldState::add_candidates() {
    const auto others = static_cast<std::ptrdiff_t>(candidates.size());
    for (const BodyPair& pair : found_pairs) {
        if (free_slots.empty()) {
            free_slots.push_back(axes.size());
            axes.emplace_back();
            separations.emplace_back();
        }
        separations[free_slots.back()] = {};
        candidates.push_back({pair, free_slots.back()});
        free_slots.pop_back();
    }
    pair_penetration.resize(axes.size());
    std::ranges::inplace_merge(candidates, candidates.begin() + others, {}, &Candidate::bodies);
    std::vector<char> is_in(reported_count, 0);
    for (const auto& [pair, slot] : candidates) {
        is_in[static_cast<std::size_t>(pair.a)] = is_in[static_cast<std::size_t>(pair.b)] = 1;
    }
    candidate_bodies.clear();
    for (std::size_t i = 0; i < reported_count; ++i) {
        if (is_in[i] != 0) {
            candidate_bodies.push_back(i);
        }
    }
}

/// Do two bodies whose search boxes overlap count as candidates? Not those that a joint connects, and none beyond a
/// plane, whose box tells nothing.
bool WorldState::may_touch(const BodyPair& pair) const {
    if (std::ranges::binary_search(jointed, pair)) {
        return false;
    }
    auto plane = static_cast<std::size_t>(pair.a);
    auto other = static_cast<std::size_t>(pair.b);
    if (!std::holds_alternative<Plane>(bodies.props[plane].shape)) {
        std::swap(plane, other);
    }
    if (!std::holds_alternative<Plane>(bodies.props[plane].shape)) {
        return true;
    }
    const Vec3 normal = searched_pose[plane].orientation * Vec3::UnitZ();
    const double height = normal.dot(searched_pose[other].position - searched_pose[plane].position);
    return height <= bodies.props[other].bounding_radius + searched_reach[plane] + searched_reach[other] +
                         margin_tolerances * settings.tolerance;
}

} // namespace sim
