#include "sim/world/candidates.h"

#include "sim/base/grow.h"

#include <algorithm>
#include <cmath>

namespace sim {
namespace {

/// Pairs are searched for by this share [-] of the bodies' size farther than they move in the step: so the search serves several.
constexpr double search_share = 0.1;

/// Pairs are searched for in a frame that moves with the bodies where that makes their speeds less than this share [-].
constexpr double frame_share = 0.25;

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
    if (props.is_fixed()) {
        return drift.norm();
    }
    const double turn = 2.0 * (to.orientation * from.orientation.conjugate()).vec().norm();
    return (to.position - from.position - drift).norm() + turn * props.bounding_radius;
}

Candidates::Candidates(const Bodies& bodies, std::size_t count, const StepSettings& settings, std::vector<BodyPair> jointed)
    : bodies_(bodies), settings_(settings), count_(count), jointed_(std::move(jointed)),
      broad_phase_(std::span(bodies.props).first(count), [this](const BodyPair& pair) { return may_touch(pair); }) {}

void Candidates::move(double interval) {
    drift_ += drift_in(interval);
    frame_ += frame_.isZero(0.0) ? Vec3(Vec3::Zero()) : Vec3(interval * settings_.gravity);
}

double Candidates::margin_of(const BodyPair& pair) const {
    const auto a = static_cast<std::size_t>(pair.a);
    const auto b = static_cast<std::size_t>(pair.b);
    const double approach = (bodies_.velocity[a].v - bodies_.velocity[b].v).norm() + rim_speed_[a] + rim_speed_[b];
    return h_ * (approach + fall_) + settings_.tolerance;
}

double Candidates::farthest(const BodyPair& pair) const {
    return reach_[static_cast<std::size_t>(pair.a)] + reach_[static_cast<std::size_t>(pair.b)] +
           settings_.tolerance;
}

/// How far the frame of the search falls in t [s]; at rest it stays [m].
Vec3 Candidates::drift_in(double t) const {
    return frame_.isZero(0.0) ? Vec3(Vec3::Zero()) : Vec3(t * frame_ + 0.5 * t * t * settings_.gravity);
}

/// How far each body may move in the step, in the frame of the search.
void Candidates::find_reach() {
    h_ = settings_.time_step.value();
    fall_ = h_ * settings_.gravity.norm();
    reach_.resize(count_);
    rim_speed_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
        const BodyProps& props = bodies_.props[i];
        const Velocity& velocity = bodies_.velocity[i];
        rim_speed_[i] = rim_speed(props, velocity);
        const double spin = props.is_fixed() ? 0.0 : spin_growth(props) * rim_speed_[i];
        reach_[i] = h_ * ((velocity.v - frame_).norm() + spin + fall_);
    }
}

/// May body i leave the box it was given, by its `reach`?
bool Candidates::has_escaped(std::size_t i) const {
    const BodyProps& props = bodies_.props[i];
    return !props.is_waiting && moved_by(props, searched_pose_[i], bodies_.pose[i], drift_) + reach_[i] > searched_reach_[i];
}

/// Pairs of bodies that may touch while each moves by up to its `reach` from its present pose: the last search still
/// tells those of bodies that are not escaped_.
void Candidates::find() {
    find_reach();
    const bool is_first = searched_pose_.size() != count_;
    escaped_.clear();
    for (std::size_t i = 0; !is_first && i < count_; ++i) {
        if (has_escaped(i)) {
            escaped_.push_back(static_cast<int>(i));
        }
    }
    if (is_first || have_many_escaped()) {
        frame_ = common_velocity(std::span(bodies_.props).first(count_), bodies_.velocity);
        find_reach();
        search_all();
    } else {
        search_escaped();
    }
}

void Candidates::release(std::size_t body) {
    searched_reach_[body] = -1.0; // it has no box yet: whatever it does, it escapes
}

void Candidates::find_thrown(std::span<const std::size_t> solved, std::span<const Pose> planned, double interval) {
    const Vec3 drift = drift_in(interval);
    escaped_.clear();
    for (const std::size_t i : solved) {
        if (i >= count_) {
            continue;
        }
        const double throw_of = moved_by(bodies_.props[i], bodies_.pose[i], planned[i], drift);
        if (throw_of > reach_[i]) {
            reach_[i] = throw_of;
            if (has_escaped(i)) {
                escaped_.push_back(static_cast<int>(i));
            }
        }
    }
    have_many_escaped() ? search_all() : search_escaped();
}

bool Candidates::have_many_escaped() const {
    return searched_again_ + escaped_.size() > count_;
}

/// How far body i may move before its pairs are searched for again [m].
double Candidates::search_reach(std::size_t i) const {
    const double size = bodies_.props[i].is_fixed() ? 0.0 : bodies_.props[i].bounding_radius;
    return reach_[i] + search_share * size;
}

/// Where body i may get to until then: a box in the frame of the search.
void Candidates::set_box(std::size_t i) {
    searched_reach_[i] = search_reach(i);
    searched_pose_[i] = bodies_.pose[i];
    searched_pose_[i].position -= drift_;
    boxes_[i] = searched_box(i);
}

/// By where it was searched for; none of a body that waits.
Bounds Candidates::searched_box(std::size_t i) const {
    if (bodies_.props[i].is_waiting) {
        return no_bounds;
    }
    Bounds box = bounds(bodies_.props[i].shape, searched_pose_[i]);
    const Vec3 margin = Vec3::Constant(searched_reach_[i] + 0.5 * settings_.tolerance);
    box.lower -= margin;
    box.upper += margin;
    return box;
}

void Candidates::search_all() {
    drift_.setZero();
    searched_pose_.resize(count_);
    searched_reach_.resize(count_);
    boxes_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
        set_box(i);
    }
    searched_again_ = 0;
    search();
}

/// All pairs whose search boxes overlap become candidates.
void Candidates::search() {
    broad_phase_.find_pairs(boxes_, found_);
    all_.clear();
    slots_ = {};
    add_found();
}

void Candidates::search_escaped() {
    if (escaped_.empty()) {
        return;
    }
    searched_again_ += escaped_.size();
    std::vector<char> has_moved_on(count_, 0);
    for (const int i : escaped_) {
        set_box(static_cast<std::size_t>(i));
        has_moved_on[static_cast<std::size_t>(i)] = 1;
    }
    std::erase_if(all_, [&](const Candidate& candidate) {
        const auto [a, b] = candidate.bodies;
        const bool is_old = has_moved_on[static_cast<std::size_t>(a)] != 0 || has_moved_on[static_cast<std::size_t>(b)] != 0;
        if (is_old) {
            slots_[candidate.are_boxes].free.push_back(candidate.slot);
        }
        return is_old;
    });
    broad_phase_.find_pairs_of(escaped_, boxes_, found_);
    add_found();
}

/// The pairs found, none of which is a candidate, become candidates.
void Candidates::add_found() {
    const auto is_box = [&](int body) {
        return std::holds_alternative<Box>(bodies_.props[static_cast<std::size_t>(body)].shape);
    };
    const auto others = static_cast<std::ptrdiff_t>(all_.size());
    make_room(all_, all_.size() + found_.size());
    for (const BodyPair& pair : found_) {
        const bool are_boxes = is_box(pair.a) && is_box(pair.b);
        Slots& slots = slots_[are_boxes];
        if (slots.free.empty()) {
            slots.free.push_back(static_cast<std::uint32_t>(slots.count++));
        }
        all_.push_back({pair, slots.free.back(), are_boxes});
        slots.free.pop_back();
    }
    std::ranges::inplace_merge(all_, all_.begin() + others, {}, &Candidate::bodies);
    std::vector<char> is_in(count_, 0);
    for (const Candidate& candidate : all_) {
        const auto [a, b] = candidate.bodies;
        is_in[static_cast<std::size_t>(a)] = is_in[static_cast<std::size_t>(b)] = 1;
    }
    members_.clear();
    for (std::size_t i = 0; i < count_; ++i) {
        if (is_in[i] != 0) {
            members_.push_back(i);
        }
    }
}

/// Do two bodies whose search boxes overlap count as candidates? Not those that a joint connects, and none beyond a
/// plane, whose box tells nothing.
bool Candidates::may_touch(const BodyPair& pair) const {
    if (std::ranges::binary_search(jointed_, pair)) {
        return false;
    }
    auto plane = static_cast<std::size_t>(pair.a);
    auto other = static_cast<std::size_t>(pair.b);
    if (!std::holds_alternative<Plane>(bodies_.props[plane].shape)) {
        std::swap(plane, other);
    }
    if (!std::holds_alternative<Plane>(bodies_.props[plane].shape)) {
        return true;
    }
    const Vec3 normal = searched_pose_[plane].orientation * Vec3::UnitZ();
    const double height = normal.dot(searched_pose_[other].position - searched_pose_[plane].position);
    return height <= bodies_.props[other].bounding_radius + searched_reach_[plane] + searched_reach_[other] +
                         settings_.tolerance;
}

void Candidates::resume() {
    for (std::size_t i = 0; i < count_; ++i) {
        boxes_.push_back(searched_box(i));
    }
    search();
}

} // namespace sim
