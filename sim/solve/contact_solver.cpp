#include "sim/solve/contact_solver.h"

#include "sim/model/integrate.h"
#include "sim/solve/gap_measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sim {
namespace {

/// The iteration stops when no contact changed by more than this share [-] of the tolerance over h, or by the
/// velocity tolerance, whichever is smaller.
constexpr double iteration_share = 0.5;

/// Share [-] of the impulses at t0 that acts before it, when the velocities were last exact `last_interval`
/// [s] ago.
double node_weight(double last_interval, double h) {
    return last_interval / (last_interval + h);
}

/// Friction within this share [-] of mu p_n is at its limit: projected there, it differs by rounding only.
constexpr double limit_rounding = 1e-9;

/// Within this share [-] of the tolerance a gap is left as it is: closing it would need a velocity, which the next step has to
/// take away again, and no tower rests on such.
constexpr double soft_band = 0.5;

/// A speculative impact is passed on by contacts whose impulse exceeds this many times [-] the last step's force, and the weight.
/// What the bodies that it reaches feel beyond these answers it and is no force. Elsewhere all impulses are: of a load that only
/// moves from one contact to another, what counts and what does not must balance, or bodies at rest would be told to approach.
constexpr double largest_growth = 2.0;

/// Blocks are passed over whose bodies changed by less than skip_share of the tolerance, but by no more than this [m/s], a tenth
/// of what counts as rest, or this share [-] of the change of the sweep before.
constexpr double settled_change = 1e-5;
constexpr double last_share = 0.05;

/// The gap errors left by one linear solve may be this share [-] of the tolerance before it is repeated at
/// the predicted poses.
constexpr double accepted_share = 0.5;

/// Gap errors [m] that rounding leaves.
constexpr double gap_rounding = 1e-13;

/// Changes of marks within one linear solve.
constexpr int mark_rounds = 10;

/// Linear solves of one step before it counts as not converged.
constexpr int outer_limit = 12;

} // namespace

void ContactSolver::set_rules(const StepSettings& settings, double h) {
    settings_ = settings;
    const double step_share = std::min(h / settings.time_step.value(), 1.0);
    iteration_tolerance_ = std::min(iteration_share * settings.tolerance / h, settings.velocity_tolerance);
    const Vec3& gravity = settings.gravity;
    rules_ = {.h = h,
              .tolerance = settings.tolerance,
              .band = soft_band * settings.tolerance,
              .step_share = step_share,
              .velocity_tolerance = settings.velocity_tolerance,
              .largest_growth = largest_growth,
              .limit = 1.0 - limit_rounding,
              .slip_tolerance = iteration_share * settings.tolerance,
              .gravity = {gravity.x(), gravity.y(), gravity.z()},
              .weight = gravity.norm(),
              .warm_start = settings.warm_start,
              .is_doubtful = memory_interval_ == 0.0};
}

void ContactSolver::prepare(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                            const StepSettings& settings, double h) {
    set_rules(settings, h);
    joint_weight_.clear();
    for (const Joint& joint : joints) {
        joint_weight_.push_back(node_weight(joint.memory.last_interval, h));
    }
    joints_.prepare(bodies, joints);
    to_.begin(bodies, settings.gravity, h);
    for (const PairContacts& pair : pairs) {
        to_.add(bodies, pair.manifold.body_a);
        to_.add(bodies, pair.manifold.body_b);
    }
    for (const Joint& joint : joints) {
        to_.add(bodies, joint.a);
        to_.add(bodies, joint.b);
    }
    std::ranges::sort(to_.solved);
    to_.move_others(bodies, contacts_.loop.workers);
    contacts_.begin(bodies, pairs, settings, rules_, to_);
    is_stretched_ = h > memory_interval_;
}

/// Impulses p minimise p.A p / 2 + b.p where they converge: the share s of a guess p is best at 1 - p.r / p.A p, where r is
/// how much faster than their targets the contacts part with all of it, and p.A p twice the kinetic energy of what it changes.
/// Returns whether less than all was nearer.
bool ContactSolver::scale_warm_start(const Bodies& bodies) {
    double work = 0.0; // p.r [J]
    for (const Block& block : contacts_.loop.blocks) {
        const BlockBatch& batch = contacts_.loop.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(to_.velocity);
        for (const BatchPoint& of : contacts_.loop.points_of(batch).first(static_cast<std::size_t>(block.count))) {
            const LanePoint point(of, lane);
            const Vec2 target(of.u_t_target[0].x[lane], of.u_t_target[1].x[lane]);
            work += point.p_n * (point.normal_velocity(twist) - of.u_n_target.x[lane]) +
                    point.p_t.dot(point.tangential_velocity(twist) - target);
        }
    }
    double energy = 0.0; // p.A p [J]
    for (const std::size_t i : to_.solved) {
        if (!bodies.props[i].is_static()) {
            const Velocity change{to_.velocity[i].v - bodies.velocity[i].v, to_.velocity[i].w - bodies.velocity[i].w};
            energy += 2.0 * kinetic_energy(bodies.props[i], bodies.pose[i].orientation, change);
        }
    }
    const double share = std::clamp(1.0 - work / energy, 0.0, 1.0);
    if (!(energy > 0.0) || share > 0.5) {
        return false; // all of it is nearer than none
    }
    for (const std::size_t i : to_.solved) {
        to_.velocity[i].v = bodies.velocity[i].v + share * (to_.velocity[i].v - bodies.velocity[i].v);
        to_.velocity[i].w = bodies.velocity[i].w + share * (to_.velocity[i].w - bodies.velocity[i].w);
    }
    contacts_.scale(share);
    to_.update(bodies, contacts_.loop.workers);
    return true;
}

/// What a part of a step may add to an error that a step may leave [m]: the same error of velocities is a smaller gap.
double ContactSolver::part_of(double tolerance) const {
    return std::min(std::max(rules_.step_share * tolerance, gap_rounding), tolerance);
}

/// Sweeps over joints and contacts (projected Gauss-Seidel) until nothing changes by more than the tolerance. Returns
/// their number.
int ContactSolver::iterate(int budget, bool& converged) {
    const double tolerance = iteration_tolerance_;
    const double joint_tolerance = part_of(settings_.joint_tolerance) / rules_.h;
    const bool has_joints = !joints_.empty();
    int count = 0;
    double last = std::numeric_limits<double>::infinity(); // [m/s] change of the sweep before
    contacts_.loop.wake();
    for (converged = false; count < budget && !converged; ++count) {
        const double missing = has_joints ? joints_.solve(to_.velocity) : 0.0;
        const double skip =
            has_joints ? -1.0 : std::min(skip_share * tolerance, std::max(settled_change, last_share * last));
        last = contacts_.loop.sweep(to_.velocity, skip, slack_share * tolerance);
        converged = last <= tolerance || (contacts_.loop.stalls() && last <= stall_share * settings_.tolerance / rules_.h);
        converged = converged && (contacts_.loop.empty() || !has_joints || (count > 0 && missing <= joint_tolerance));
    }
    return count;
}

ContactSolveReport ContactSolver::solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                        std::span<const Joint> joints) {
    ContactSolveReport report;
    to_.update(bodies, contacts_.loop.workers);
    const GapMeasure measure{bodies, pairs, settings_, to_, contacts_};
    const double gap_tolerance = part_of(settings_.tolerance);
    const double joint_tolerance = part_of(settings_.joint_tolerance);
    for (int outer = 0; outer < outer_limit && !(contacts_.loop.empty() && joints_.empty()); ++outer) {
        const double residual_before = report.residual;
        report.residual = outer == 0 ? measure.all() : measure.again(measured_);
        if (std::exchange(is_stretched_, false) && report.residual > gap_tolerance && scale_warm_start(bodies)) {
            report.residual = measure.all();
        }
        report.joint_residual =
            joints_.empty() ? 0.0 : joints_.target_closed(joints, to_.pose, to_.velocity, rules_.h, rules_.step_share);
        if (outer > 0 && report.residual <= accepted_share * gap_tolerance &&
            report.joint_residual <= joint_tolerance) {
            break;
        }
        if (outer == 0) {
            measured_ = to_.velocity;
        }
        const int left = settings_.iteration_limit - report.iterations;
        // Where bodies turn so far that another linear solve makes it worse, only a shorter interval helps.
        if (left <= 0 || (outer > 1 && report.residual > std::max(residual_before, gap_tolerance))) {
            break;
        }
        bool converged = false;
        report.iterations += iterate(left, converged);
        for (int round = 0; round < mark_rounds && converged && contacts_.update_marks(pairs, to_.velocity); ++round) {
            report.iterations +=
                iterate(std::max(settings_.iteration_limit - report.iterations, 1), converged);
        }
        to_.update(bodies, contacts_.loop.workers);
    }
    report.converged =
        report.residual <= gap_tolerance && report.joint_residual <= joint_tolerance;
    converged_ = report.converged;
    return report;
}

void ContactSolver::store_impulses(const Bodies& bodies, std::vector<PairContacts>& pairs,
                                   std::span<Joint> joints) {
    memory_interval_ = converged_ ? rules_.h : 0.0;
    contacts_.store(bodies, pairs, to_.velocity);
    joint_before_ = joint_weight_;
    const auto is_hit = [&](const Joint& joint) { return contacts_.is_hit(joint.a) || contacts_.is_hit(joint.b); };
    const bool are_hit = std::ranges::any_of(joints, is_hit);
    const std::vector<double> sizes = joints_.impulse_sizes(joints.size());
    joints_.store_impulses(joints);
    for (std::size_t i = 0; i < joints.size(); ++i) {
        JointMemory& memory = joints[i].memory;
        const double interval = impulse_interval(joint_weight_[i], rules_.h);
        // What answers a speculative impact is no force, as for contacts: see RestingContacts::find_hit_bodies().
        const double force = sizes[i] / interval;
        const double share = are_hit && force > memory.force ? memory.force / force : 1.0;
        joint_before_[i] *= share;
        memory.force = share * force;
        memory.owed = share * 0.5 * rules_.h / interval;
        memory.last_interval = rules_.h;
    }
}

std::span<const Velocity> ContactSolver::find_velocity_at_node(const Bodies& bodies) {
    at_node_ = bodies.velocity;
    joints_.add_weighted(joint_before_, at_node_);
    contacts_.apply_half_kicks(at_node_);
    return at_node_;
}

DriveWork ContactSolver::drive_work(const Bodies& bodies) {
    const std::vector<Velocity> velocity = kinematic_velocity(bodies);
    DriveWork work = contacts_.work_by(velocity);
    JointSolver::Kick kick{bodies.velocity, {}, to_.velocity};
    if (joints_.has_motors()) {
        kick.at_node = find_velocity_at_node(bodies);
    }
    const DriveWork of_joints = joints_.work(velocity, joints_.has_motors() ? &kick : nullptr, joint_before_);
    work.all += of_joints.all;
    work.ahead += of_joints.ahead;
    return work;
}

double ContactSolver::joint_rate(const Bodies& bodies) {
    std::vector<double> interval;
    for (const double weight : joint_weight_) {
        interval.push_back(impulse_interval(weight, rules_.h));
    }
    return joints_.fastest_rate(bodies, interval);
}

} // namespace sim
