#include "sim/solve/contact_solver.h"

#include "sim/model/integrate.h"
#include "sim/solve/time_of_impact.h"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>

namespace sim {
namespace {

static_assert(offsetof(ContactMemory, slip) - offsetof(ContactMemory, p_n) == 8 * sizeof(double) &&
                  offsetof(ContactMemory, mark) - offsetof(ContactMemory, p_n) == 15 * sizeof(double),
              "rest_kernel.cpp reads and writes two rows");

/// Within this share [-] of the tolerance a gap is not closed at once but by a share of it a step: closing an error of d
/// in one step needs the velocity d / h, which the next step has to take away again.
constexpr double soft_band = 0.5;

/// The impulses of an interval are no guess at those of one so many times [-] as long: next to an impact they stop what
/// approaches slowly, rather than carry a load.
constexpr double largest_stretch = 100.0;

/// Next to a speculative impact, just after an impact, or where there was a force, an impulse that exceeds this many times
/// [-] the last step's force, and the weight, answers an impact and is no force.
constexpr double largest_growth = 2.0;

/// Gaps in the soft band are closed by this share [-] of them a step; more slowly where the tolerance is loose: sweeps
/// that take away the share s of an error in velocity, from impulses that each step starts from whole, act on a heap as
/// a damper s, a spring s and the integral of a spring, s times gap_relaxation; that comes to rest only where
/// gap_relaxation < s (Routh), and the slowest motion of a tower of 20 solved by a few sweeps a step has s = 0.01 or less.
constexpr double gap_relaxation = 0.1; // at it towers come to rest with tight tolerances
constexpr double loose_gap_relaxation = 0.003;
constexpr double tight_velocity_tolerance = 5e-5; ///< [m/s] up to here a tolerance is not loose

/// Where a loose tolerance is met, sweeps go on, so many at most, until the changes are this share [-] of the first
/// one, or slower than this [m/s], a tenth of what counts as rest: a heap comes to rest over the steps, at little cost.
constexpr int settling_sweeps = 8;
constexpr double settling_share = 0.1;
constexpr double settled_change = 1e-5;

/// And less than this share [-] of the change of the sweep before; see skip_share.
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
    stop_at_impacts_ = settings.impacts == ImpactHandling::stop;
    h_ = h;
    step_share_ = std::min(h / settings.time_step.value(), 1.0);
    iteration_tolerance_ = std::min(iteration_share * settings.tolerance / h, settings.velocity_tolerance);
    const double relaxation = gap_relaxation * std::clamp(tight_velocity_tolerance / iteration_tolerance_,
                                                          loose_gap_relaxation / gap_relaxation, 1.0);
    const Vec3& gravity = settings.gravity;
    rules_ = {.h = h,
              .tolerance = settings.tolerance,
              .band = soft_band * settings.tolerance,
              .relaxation = relaxation,
              .step_share = step_share_,
              .velocity_tolerance = settings.velocity_tolerance,
              .largest_stretch = largest_stretch,
              .largest_growth = largest_growth,
              .limit = 1.0 - limit_rounding,
              .slip_tolerance = iteration_share * settings.tolerance,
              .gravity = {gravity.x(), gravity.y(), gravity.z()},
              .weight = gravity.norm(),
              .warm_start = settings.warm_start,
              .is_doubtful = has_doubtful_memory_};
}

void ContactSolver::prepare(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                            std::span<const JointMemory> joint_memory, const StepSettings& settings, double h) {
    set_rules(settings, h);
    velocity_ = bodies.velocity;
    before_ = bodies.velocity.front().v.data();
    measured_.resize(bodies.props.size());
    predicted_.resize(bodies.props.size());
    placed_.resize(bodies.props.size());
    radius_.resize(bodies.props.size());
    end_.resize(bodies.props.size());
    joint_weight_.clear();
    for (const JointMemory& memory : joint_memory) {
        joint_weight_.push_back(node_weight(memory.last_interval, h));
    }
    joints_.prepare(bodies, joints);
    find_solved_bodies(bodies, pairs, joints);
    loop_.clear();
    has_two_coefficients_ = false;
    all_in_solve_ = true;
    take_pairs(bodies, pairs);
    start(bodies, pairs, 0);
    if (rules_.is_doubtful) {
        scale_warm_start(bodies, pairs);
    }
}

/// The mark of eq. 6, and the coefficient that goes with it.
void ContactSolver::set_mark(Block& block, bool sticks) {
    BlockBatch& batch = loop_.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    batch.sticking.x[lane] = sticks ? 1.0 : 0.0;
    batch.mu.x[lane] = sticks ? block.mu_s : block.mu_d;
}

double ContactSolver::work_on_batches(RestPhase phase, std::size_t first, std::size_t last, std::span<Velocity> velocity,
                                      const unsigned* only) {
    return work_on_rest({.phase = phase,
                         .batches = loop_.batches.data() + first,
                         .batch_count = last - first,
                         .blocks = rest_blocks_.data() + first,
                         .points = loop_.points.data(),
                         .rest = rest_points_.data(),
                         .end = end_.data(),
                         .before = before_,
                         .velocity = velocity.front().v.data(),
                         .only = only,
                         .rules = &rules_});
}

/// What a part of a step may add to an error that a step may leave [m]: the same error of velocities is a smaller gap.
double ContactSolver::part_of(double tolerance) const {
    return std::min(std::max(step_share_ * tolerance, gap_rounding), tolerance);
}

/// Sweeps over joints and contacts (projected Gauss-Seidel) until nothing changes by more than `tolerance` [m/s]. Returns
/// their number.
int ContactSolver::iterate(double tolerance, int budget, bool& converged) {
    const double joint_tolerance = part_of(settings_.joint_tolerance) / h_;
    const bool has_joints = !joints_.empty();
    int count = 0;
    double last = std::numeric_limits<double>::infinity();    // [m/s] change of the sweep before
    double settled = std::numeric_limits<double>::infinity(); // [m/s], once the first sweep has told
    loop_.wake();
    for (converged = false; count < budget && !converged; ++count) {
        const double missing = has_joints ? joints_.solve(velocity_) : 0.0;
        const double skip =
            has_joints ? -1.0 : std::min(skip_share * tolerance, std::max(settled_change, last_share * last));
        last = loop_.sweep(velocity_, skip, slack_share * tolerance);
        settled = count == 0 ? std::max(settling_share * last, settled_change) : settled;
        converged = last <= tolerance;
        if (converged && last > settled && settling_ < settling_sweeps) {
            ++settling_;
            converged = false;
        }
        converged = converged || (loop_.stalls() && last <= stall_share * settings_.tolerance / h_);
        converged = converged && (loop_.empty() || !has_joints || (count > 0 && missing <= joint_tolerance));
    }
    return count;
}

/// Eq. 6 on converged sums. Returns true if the iteration has to go on for it: with mu_s = mu_d a mark changes nothing.
bool ContactSolver::update_marks(const std::vector<PairContacts>& pairs) {
    bool changed = false;
    for (std::size_t i = 0; has_two_coefficients_ && i < loop_.blocks.size(); ++i) {
        Block& block = loop_.blocks[i];
        changed = (block.count > 0 && block.mu_d != block.mu_s && update_mark(pairs, block)) || changed;
    }
    return changed;
}

/// A marked block that is at its limit and slips loses its mark; a sliding one that the step would reverse has stopped
/// within it, and sticks if static friction can hold it.
bool ContactSolver::update_mark(const std::vector<PairContacts>& pairs, Block& block) {
    const double slip_tolerance = iteration_share * settings_.tolerance / h_;
    const BlockBatch& batch = loop_.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    const LaneFrame frame(batch, lane);
    const Vec6 twist = frame.relative_twist(velocity_);
    const bool is_sticking = batch.sticking.x[lane] > 0.5;
    bool slips = false;
    bool at_limit = false;
    double reversal = 0.0;
    for (int k = 0; k < block.count; ++k) {
        const BatchPoint& in_lanes = loop_.points[static_cast<std::size_t>(batch.first + k)];
        const LanePoint point(in_lanes, lane);
        if (point.p_n == 0.0) {
            continue;
        }
        const Vec2 target(in_lanes.u_t_target[0].x[lane], in_lanes.u_t_target[1].x[lane]);
        const Vec2 slip = point.tangential_velocity(twist) - target;
        slips = slips || slip.norm() > slip_tolerance;
        at_limit = at_limit || point.p_t.norm() >= (1.0 - limit_rounding) * block.mu_s * point.p_n;
        const int index = loop_.contacts[static_cast<std::size_t>(block.first + k)].index;
        const Vec3& sliding =
            pairs[static_cast<std::size_t>(block.pair)].memory[static_cast<std::size_t>(index)].sliding;
        reversal += point.p_n * slip.dot(frame.frame.leftCols<2>().transpose() * sliding);
    }
    const bool lost = is_sticking && slips && at_limit;
    const bool stopped = !is_sticking && slips && reversal < 0.0;
    if (lost || stopped) {
        set_mark(block, stopped);
    }
    return lost || stopped;
}

ContactSolveReport ContactSolver::solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                        std::span<const Joint> joints) {
    ContactSolveReport report;
    predict(bodies);
    settling_ = 0;
    const double gap_tolerance = part_of(settings_.tolerance);
    const double joint_tolerance = part_of(settings_.joint_tolerance);
    for (int outer = 0; outer < outer_limit && !(loop_.empty() && joints_.empty()); ++outer) {
        const double residual_before = report.residual;
        report.residual = outer == 0 ? measure(bodies, pairs) : measure_again(bodies, pairs);
        report.joint_residual =
            joints_.empty() ? 0.0 : joints_.target_closed(joints, predicted_, velocity_, h_, step_share_);
        if (outer > 0 && report.residual <= accepted_share * gap_tolerance &&
            report.joint_residual <= joint_tolerance) {
            break;
        }
        if (outer == 0) {
            for (const std::size_t i : solved_bodies_) {
                measured_[i] = velocity_[i];
            }
        }
        const int left = settings_.iteration_limit - report.iterations;
        // Where bodies turn so far that another linear solve makes it worse, only a shorter interval helps.
        if (left <= 0 || (outer > 1 && report.residual > std::max(residual_before, gap_tolerance))) {
            break;
        }
        bool converged = false;
        report.iterations += iterate(iteration_tolerance_, left, converged);
        for (int round = 0; round < mark_rounds && converged && update_marks(pairs); ++round) {
            report.iterations +=
                iterate(iteration_tolerance_, std::max(settings_.iteration_limit - report.iterations, 1), converged);
        }
        predict(bodies);
    }
    report.converged =
        report.residual <= gap_tolerance && report.joint_residual <= joint_tolerance;
    converged_ = report.converged;
    return report;
}

} // namespace sim
