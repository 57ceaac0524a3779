#include "sim/solve/collision_solver.h"

#include "sim/base/sort_once.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace sim {
namespace {

/// In a dense heap a contact may collide again and again within one instant. From this pass on what touches the bodies
/// that collide is held in the same pass, and passes soon end; elastic contacts are not: a row of n equal balls needs n
/// passes.
constexpr int first_held_pass = 8;

/// velocity_of(i): of body i.
template <typename VelocityOf>
double kinetic_energy_by(const Bodies& bodies, std::span<const std::size_t> included, VelocityOf&& velocity_of) {
    double energy = 0.0;
    for (const std::size_t i : included) {
        if (!bodies.props[i].is_static()) {
            energy += sim::kinetic_energy(bodies.props[i], bodies.pose[i].orientation, velocity_of(i));
        }
    }
    return energy;
}

double kinetic_energy(const Bodies& bodies, std::span<const Velocity> velocity, std::span<const std::size_t> included) {
    return kinetic_energy_by(bodies, included, [&](std::size_t i) { return velocity[i]; });
}

/// How fast a contact approaches [m/s]: now, and as it does in this pass: 0 if it is no collision.
struct Approach {
    double now = 0.0;
    double in_pass = 0.0;
};

/// How a pair's body a moves as seen from b, which tells how each of their contacts approaches.
class PairApproach {
public:
    PairApproach(const Bodies& bodies, int body_a, int body_b, std::span<const Velocity> velocity, const Pass& pass)
        : pass_(pass) {
        const auto a = static_cast<std::size_t>(body_a);
        const auto b = static_cast<std::size_t>(body_b);
        centre_ = bodies.pose[a].position;
        radius_ = bodies.props[a].bounding_radius;
        relative_.v = velocity[a].v - velocity[b].at(centre_ - bodies.pose[b].position);
        relative_.w = velocity[a].w - velocity[b].w;
    }

    /// No contact approaches faster than this [m/s]; of a plane, which has no radius, it may be no number.
    double fastest() const { return relative_.v.norm() + relative_.w.norm() * radius_; }

    Approach of(const Contact& contact) const {
        const double now = -relative_.at(contact.at.a - centre_).dot(contact.at.n);
        const double approach = pass_.number == 0 ? std::max(now, contact.memory.approach_speed) : now;
        const bool is_apart = contact.at.gap > std::max(pass_.reach, now * pass_.soon);
        return {now, is_apart || approach <= pass_.threshold ? 0.0 : approach};
    }

private:
    const Pass& pass_;
    Vec3 centre_;   ///< of a
    double radius_; ///< of a [m]
    Velocity relative_;
};

/// Does a contact of the pair collide?
bool collides(const PairContacts& pair, const PairApproach& approach) {
    return std::ranges::any_of(pair.manifold.contacts,
                               [&](const Contact& contact) { return approach.of(contact).in_pass > 0.0; });
}

} // namespace

/// Blocks of this pass. Returns false if no contact is a collision.
bool CollisionSolver::collect(const Bodies& bodies, std::span<const PairContacts> pairs,
                              const StepSettings& settings, std::span<const Velocity> velocity, int pass) {
    const Pass now{.number = pass,
                   .threshold = resting_threshold(settings),
                   .reach = std::max(touch_gap(settings), simultaneous_gap),
                   .soon = settings.impacts == ImpactHandling::stop ? shortest_interval(settings) : 0.0};
    loop_.clear();
    targets_.clear();
    energy_taken_ = 0.0;
    if (pass == 0) {
        near_.clear();
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            const PairContacts& pair = pairs[k];
            if (pair.least_gap <= now.reach || now.soon > 0.0) {
                near_.push_back({pair.manifold.body_a, pair.manifold.body_b, static_cast<int>(k), pair.was_ahead});
            }
        }
    }
    const auto approach_of = [&](const NearPair& pair) { return PairApproach(bodies, pair.a, pair.b, velocity, now); };
    const auto may_collide = [&](const NearPair& pair) {
        if (pass > 0) {
            return is_changed(pair);
        }
        return pair.was_ahead || !(approach_of(pair).fastest() <= now.threshold);
    };
    collides_.resize(near_.size());
    loop_.share(near_.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first; k < last; ++k) {
            collides_[k] = may_collide(near_[k]);
        }
        for (std::size_t k = first; k < last; ++k) {
            collides_[k] = collides_[k] != 0 && collides(near(pairs, k), approach_of(near_[k]));
        }
    });
    if (pass >= first_held_pass) {
        hold_neighbours(bodies, pairs, now);
    }
    for (std::size_t k = 0; k < near_.size(); ++k) {
        if (collides_[k] != 0) {
            add_pair(bodies, near(pairs, k), near_[k].pair, velocity, now);
        }
    }
    loop_.arrange(bodies, 0, velocity);
    for (const Block& block : loop_.blocks) {
        const std::size_t lane = Blocks::lane_of(block);
        const std::span<BatchPoint> points = loop_.points_of(loop_.batch_of(block));
        for (std::size_t i = 0; i < static_cast<std::size_t>(block.count); ++i) {
            points[i].u_n_target.x[lane] = targets_[static_cast<std::size_t>(block.first) + i].u_n;
        }
    }
    return !loop_.empty();
}

/// Bodies that collide push what they touch in the same pass.
void CollisionSolver::hold_neighbours(const Bodies& bodies, std::span<const PairContacts> pairs, const Pass& now) {
    is_changed_.assign(bodies.props.size(), 0);
    for (std::size_t k = 0; k < near_.size(); ++k) {
        if (collides_[k] != 0) {
            for (const int body : {near_[k].a, near_[k].b}) {
                const auto i = static_cast<std::size_t>(body);
                is_changed_[i] = !bodies.props[i].is_static();
            }
        }
    }
    for (std::size_t k = 0; k < near_.size(); ++k) {
        const PairContacts& pair = near(pairs, k);
        if (is_changed(near_[k]) && pair.least_gap <= now.reach && pair.material.restitution < 1.0) {
            collides_[k] = 1;
        }
    }
}

/// Blocks of the pair's contacts that collide, or are held, in this pass.
void CollisionSolver::add_pair(const Bodies& bodies, const PairContacts& pair, int index,
                               std::span<const Velocity> velocity, const Pass& now) {
    const bool holds = now.number >= first_held_pass && pair.material.restitution < 1.0;
    const PairApproach of_pair(bodies, pair.manifold.body_a, pair.manifold.body_b, velocity, now);
    const std::size_t first = loop_.contacts.size();
    for (const Contact& contact : pair.manifold.contacts) {
        const Approach approach = of_pair.of(contact);
        const bool is_held = holds && contact.at.gap <= now.reach;
        if (approach.in_pass == 0.0 && !is_held) {
            continue;
        }
        if (now.number == 0) {
            energy_taken_ += contact.memory.energy_taken();
        }
        loop_.contacts.push_back(&contact);
        // Newton's law: it leaves with e times the speed of its approach.
        targets_.push_back({pair.material.restitution * approach.in_pass, approach.now});
    }
    loop_.add(first, block_like(pair, index));
}

void CollisionSolver::iterate(std::vector<Velocity>& velocity, const StepSettings& settings, bool& converged) {
    const double skip = skip_share * settings.velocity_tolerance;
    const auto is_enough = [&](double x) {
        return x <= std::max(settings.velocity_tolerance, loop_.let_pass() * settings.tolerance / settings.time_step.value());
    };
    loop_.may_give_way = may_give_way;
    loop_.joints = assemblies_.empty() ? nullptr : &joints_;
    loop_.wake(settings.iteration_limit);
    constexpr double infinity = std::numeric_limits<double>::infinity();
    double change = infinity; // [m/s] by the last sweep
    double missing = 0.0;     // [m/s] of the joints, before its visits
    std::function<void()> close_joints;
    if (!assemblies_.empty()) {
        close_joints = [&] { missing = std::max(missing, joints_.solve(assemblies_, velocity)); };
    }
    for (converged = false; loop_.spent() < settings.iteration_limit && !converged;) {
        missing = 0.0;
        change = loop_.sweep(velocity, skip, settings.velocity_tolerance, infinity, close_joints);
        converged = is_enough(change) && (assemblies_.empty() || (loop_.sweeps() > 1 && is_enough(missing)));
    }
    converged = converged && !loop_.gives_way();
    joints_.solve(assemblies_, velocity);
    sweeps_ += loop_.spent();
}

/// What contacts placed ahead of the impact took is given back [J], but no more than the bodies lost: other contacts may have
/// pushed them meanwhile.
double CollisionSolver::energy_owed() const {
    double lost_by_all = 0.0;
    auto next = lost.begin();
    for (const std::size_t i : in_pass_) {
        next = std::ranges::lower_bound(next, lost.end(), i, {}, &EnergyLoss::body);
        lost_by_all += next != lost.end() && next->body == i ? next->energy : 0.0;
    }
    return std::min(energy_taken_, std::max(lost_by_all, 0.0));
}

/// Work [J] that kinematic bodies do by the impulses since this was last asked.
double CollisionSolver::work_of_pass() {
    if (kinematic_.empty()) {
        return 0.0;
    }
    const double before = std::exchange(joint_work_, joints_.work(kinematic_, nullptr).all);
    double work = joint_work_ - before;
    for (const Block& block : loop_.blocks) {
        const std::size_t lane = Blocks::lane_of(block);
        const BlockBatch& batch = loop_.batch_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(kinematic_);
        for (std::size_t i = 0; i < static_cast<std::size_t>(block.count); ++i) {
            const LanePoint point(loop_.points_of(batch)[i], lane);
            work -= point.p_n * point.normal_velocity(twist) + point.p_t.dot(point.tangential_velocity(twist));
        }
    }
    return work;
}

/// If the pass added energy, beside what kinematic bodies did, goes back along the line to its plastic solution as far as
/// needed. The kinetic energy is a quadratic on that line and the plastic end has lost energy, so the crossing is unique;
/// friction stays inside its cone, which is convex. Where the pass came to no end, the plastic solution is taken: a row that is
/// wedged between two walls cannot leave both. Returns the energy taken away [J]. converged: of the pass, then of what is taken.
double CollisionSolver::keep_energy(const Bodies& bodies, std::vector<Velocity>& velocity,
                                    const StepSettings& settings, bool& converged) {
    const double start = kinetic_energy(bodies, before_, in_pass_) + energy_owed();
    work_ = work_of_pass();
    const double elastic = kinetic_energy(bodies, velocity, in_pass_) - work_;
    if (converged && elastic <= start * (1.0 + rounding_share)) {
        return 0.0;
    }
    if (impacts != nullptr) {
        elastic_ = loop_.points;
    }
    for (BatchPoint& point : loop_.points) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            const bool is_there = (point.there >> lane & 1u) != 0;
            point.u_n_target.x[lane] = is_there ? 0.0 : no_point;
            point.p_n.x[lane] = point.p_t[0].x[lane] = point.p_t[1].x[lane] = 0.0;
        }
    }
    plastic_.resize(velocity.size());
    for (const std::size_t i : in_pass_) {
        plastic_[i] = before_[i];
    }
    const bool is_solved = std::exchange(converged, true);
    iterate(plastic_, settings, converged);
    const double plastic_work = work_of_pass();
    const double e0 = kinetic_energy(bodies, plastic_, in_pass_) - plastic_work;
    const auto half_way = [&](std::size_t i) { return between(plastic_[i], velocity[i], 0.5); };
    const double e_half = kinetic_energy_by(bodies, in_pass_, half_way) - 0.5 * (plastic_work + work_);
    const double curvature = 2.0 * (elastic + e0 - 2.0 * e_half);
    const double slope = elastic - e0 - curvature;
    const double missing = start - e0;
    double s = 0.0;
    if (is_solved && missing > 0.0) {
        const double root = std::sqrt(std::max(slope * slope + 4.0 * curvature * missing, 0.0));
        s = slope + root > 0.0 ? std::clamp(2.0 * missing / (slope + root), 0.0, 1.0) : 0.0;
    }
    for (const std::size_t i : in_pass_) {
        velocity[i] = between(plastic_[i], velocity[i], s);
    }
    work_ = plastic_work + s * (work_ - plastic_work);
    for (std::size_t i = 0; impacts != nullptr && i < elastic_.size(); ++i) {
        BatchPoint& point = loop_.points[i];
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            point.p_n.x[lane] += s * (elastic_[i].p_n.x[lane] - point.p_n.x[lane]);
            for (const int t : {0, 1}) {
                point.p_t[t].x[lane] += s * (elastic_[i].p_t[t].x[lane] - point.p_t[t].x[lane]);
            }
        }
    }
    return std::max(elastic - start, 0.0);
}

/// Impulses of the pass, with those that held a contact ahead of its impact in the last step.
void CollisionSolver::report_impacts(int pass) {
    for (const Block& block : loop_.blocks) {
        const std::size_t lane = Blocks::lane_of(block);
        const BlockBatch& batch = loop_.batch_of(block);
        const LaneFrame frame(batch, lane);
        for (std::size_t i = 0; i < static_cast<std::size_t>(block.count); ++i) {
            const LanePoint point(loop_.points_of(batch)[i], lane);
            const Contact* contact = loop_.contacts[static_cast<std::size_t>(block.first) + i];
            const ContactMemory& memory = contact->memory;
            Vec3 impulse(point.p_t.x(), point.p_t.y(), point.p_n); // in the block's frame
            if (pass == 0 && memory.approach_speed > 0.0) {
                // That impulse took the speed from approach_speed to about what is left of it: its work over their
                // mean.
                const double approach = targets_[static_cast<std::size_t>(block.first) + i].approach;
                impulse.z() += 2.0 * memory.energy_taken() / (memory.approach_speed + std::max(approach, 0.0));
            }
            const Vec3 middle = contact->at.middle();
            impacts->push_back({{block.a, block.b},
                                middle.cast<float>(),
                                contact->at.n.cast<float>(),
                                (frame.frame * impulse).cast<float>(),
                                (batch.sticking >> lane & 1u) != 0});
        }
    }
}

/// The bodies whose velocities this pass may change, and these velocities, for which joints are closed.
void CollisionSolver::begin_pass(const Bodies& bodies, std::vector<Velocity>& velocity) {
    in_pass_.clear();
    for (const Block& block : loop_.blocks) {
        in_pass_.push_back(static_cast<std::size_t>(block.a));
        in_pass_.push_back(static_cast<std::size_t>(block.b));
    }
    assemblies_ = joints_.empty() ? std::vector<int>{} : joints_.assemblies_with(in_pass_);
    for (const int assembly : assemblies_) {
        in_pass_.insert(in_pass_.end(), joints_.bodies_of(assembly).begin(), joints_.bodies_of(assembly).end());
    }
    sort_once(in_pass_);
    if (!assemblies_.empty()) {
        loop_.add_rows(bodies, in_pass_);
    }
    joints_.solve(assemblies_, velocity);
    before_.resize(velocity.size());
    for (const std::size_t i : in_pass_) {
        before_[i] = velocity[i];
    }
}

/// Of the contacts that a pass would take up, the fastest.
Unsettled CollisionSolver::fastest_left() {
    Unsettled found;
    const Block* fastest = nullptr;
    for (const Block& block : loop_.blocks) {
        for (int i = block.first; i < block.first + block.count; ++i) {
            const double approach = targets_[static_cast<std::size_t>(i)].approach;
            if (fastest == nullptr || approach > found.change) {
                found = {.a = block.a, .b = block.b, .change = approach};
                fastest = &block;
            }
        }
    }
    found.island = fastest == nullptr ? 0 : loop_.island_size(*fastest);
    return found;
}

CollisionReport CollisionSolver::resolve(const Bodies& bodies, std::span<const PairContacts> pairs,
                                         const StepSettings& settings, std::vector<Velocity>& velocity) {
    CollisionReport report;
    std::vector<char>& touched = report.touched;
    touched.assign(velocity.size(), 0);
    sweeps_ = 0;
    while (collect(bodies, pairs, settings, velocity, report.passes)) {
        if (sweeps_ + sweeps_to_arrange * report.passes >= most_sweeps) {
            report.converged = false; // what still approaches is left to the resting solve
            report.unsettled = fastest_left();
            break;
        }
        if (report.passes == 0) {
            joints_.target_rest();
            kinematic_ = bodies.kinematic.empty() ? std::vector<Velocity>{} : kinematic_velocity(bodies);
            joint_work_ = 0.0;
        }
        begin_pass(bodies, velocity);
        bool converged = true;
        iterate(velocity, settings, converged);
        report.energy_removed += keep_energy(bodies, velocity, settings, converged);
        report.drive_work += work_;
        if (impacts != nullptr) {
            report_impacts(report.passes);
        }
        report.converged = converged;
        report.unsettled = converged ? Unsettled{} : loop_.least_settled();
        report.collisions += static_cast<int>(loop_.contacts.size());
        ++report.passes;
        is_changed_.assign(velocity.size(), 0);
        for (const std::size_t i : in_pass_) {
            is_changed_[i] = !bodies.props[i].is_static();
            touched[i] = touched[i] | is_changed_[i];
        }
        if (loop_.gives_way()) {
            break; // no velocities part all that collide: what still approaches is left to the resting solve
        }
    }
    report.iterations = sweeps_;
    return report;
}

} // namespace sim
