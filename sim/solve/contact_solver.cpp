#include "sim/solve/contact_solver.h"

#include "sim/model/integrate.h"
#include "sim/solve/time_of_impact.h"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

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

/// What stands for a contact in lanes that have none.
ContactMemory no_memory;

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
    doubts_guess_ = has_doubtful_memory_;
    find_solved_bodies(bodies, pairs, joints);
    loop_.clear();
    has_two_coefficients_ = false;
    all_in_solve_ = true;
    take_pairs(bodies, pairs);
    start(bodies, pairs, 0);
}

void ContactSolver::add_contacts(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const int> added,
                                 std::span<const Velocity> at_node) {
    const std::size_t first_block = loop_.blocks.size();
    std::vector<BlockContact> taken;
    for (const int index : added) {
        const PairContacts& pair = pairs[static_cast<std::size_t>(index)];
        add_solved_body(bodies, pair.manifold.body_a);
        add_solved_body(bodies, pair.manifold.body_b);
        taken.resize(pair.manifold.contacts.size());
        taken.resize(take(bodies, pair, taken.data()));
        all_in_solve_ = all_in_solve_ && taken.size() == pair.manifold.contacts.size();
        has_two_coefficients_ = has_two_coefficients_ || pair.material.mu_s != pair.material.mu_d;
        const std::size_t first = loop_.contacts.size();
        const std::size_t place = loop_.blocks.size();
        loop_.contacts.insert(loop_.contacts.end(), taken.begin(), taken.end());
        loop_.blocks.resize(place + block_count(taken));
        loop_.split(place, first, loop_.contacts.size(), block_like(pair, index));
    }
    contact_count_ = static_cast<int>(loop_.contacts.size());
    start(bodies, pairs, first_block);
    find_late_impacts(pairs, first_block, at_node);
}

void ContactSolver::drop_contacts(const Bodies& bodies, int pair) {
    all_in_solve_ = false;
    for (Block& block : loop_.blocks) {
        if (block.count > 0 && block.pair == pair) {
            const BlockBatch& batch = loop_.batch_of(block);
            for (int k = batch.first; k < batch.first + batch.count; ++k) {
                rest_points_[static_cast<std::size_t>(k)].memory[Blocks::lane_of(block)] = &no_memory.p_n;
            }
            loop_.drop(block, bodies, velocity_);
        }
    }
}

/// The contacts of a pair that the solve holds, all but the impacts that are waited for; returns their number.
std::size_t ContactSolver::take(const Bodies& bodies, const PairContacts& pair, BlockContact* to) const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < pair.manifold.contacts.size(); ++i) {
        const Contact& contact = pair.manifold.contacts[i];
        if (!stop_at_impacts_ || !is_impact(bodies, pair.manifold, contact, settings_)) {
            to[count++] = {&contact, static_cast<int>(i)};
        }
    }
    return count;
}

/// Blocks and contacts of all pairs.
void ContactSolver::take_pairs(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    struct Size {
        std::size_t blocks = 0;
        std::size_t contacts = 0;
    };
    std::vector<Size> end(pairs.size() + 1); // before each pair, and at the end
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        std::vector<BlockContact> taken;
        for (std::size_t i = first; i < last; ++i) {
            end[i + 1] = {pairs[i].blocks, pairs[i].manifold.contacts.size()};
            if (stop_at_impacts_) {
                taken.resize(pairs[i].manifold.contacts.size());
                taken.resize(take(bodies, pairs[i], taken.data()));
                end[i + 1] = {block_count(taken), taken.size()};
            }
        }
    });
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        all_in_solve_ = all_in_solve_ && end[i + 1].contacts == pairs[i].manifold.contacts.size();
        has_two_coefficients_ = has_two_coefficients_ || pairs[i].material.mu_s != pairs[i].material.mu_d;
        end[i + 1].blocks += end[i].blocks;
        end[i + 1].contacts += end[i].contacts;
    }
    loop_.blocks.resize(end.back().blocks);
    loop_.contacts.resize(end.back().contacts);
    contact_count_ = static_cast<int>(end.back().contacts);
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            take(bodies, pairs[i], loop_.contacts.data() + end[i].contacts);
            loop_.split(end[i].blocks, end[i].contacts, end[i + 1].contacts, block_like(pairs[i], static_cast<int>(i)));
        }
    });
}

/// Bodies that are not among them move freely over the interval: to where predicted() tells from here on.
void ContactSolver::find_solved_bodies(const Bodies& bodies, std::span<const PairContacts> pairs,
                                       std::span<const Joint> joints) {
    is_solved_.assign(bodies.props.size(), 0);
    solved_bodies_.clear();
    for (const PairContacts& pair : pairs) {
        add_solved_body(bodies, pair.manifold.body_a);
        add_solved_body(bodies, pair.manifold.body_b);
    }
    for (const Joint& joint : joints) {
        add_solved_body(bodies, joint.a);
        add_solved_body(bodies, joint.b);
    }
    std::ranges::sort(solved_bodies_);
    loop_.share(bodies.props.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            if (is_solved_[i] == 0) {
                predicted_[i] = free_motion(bodies.props[i], bodies.pose[i], velocity_[i], settings_.gravity, h_);
            }
        }
    });
}

void ContactSolver::add_solved_body(const Bodies& bodies, int body) {
    const auto i = static_cast<std::size_t>(body);
    if (is_solved_[i] == 0) {
        is_solved_[i] = 1;
        solved_bodies_.push_back(i);
        radius_[i] = bodies.props[i].is_static() ? 0.0 : bodies.props[i].bounding_radius;
    }
}

/// Batches of the blocks from `first_block` on, and what their contacts start from.
void ContactSolver::start(const Bodies& bodies, std::vector<PairContacts>& pairs, std::size_t first_block) {
    if (first_block == loop_.blocks.size()) {
        return;
    }
    const std::size_t first_batch = loop_.batches.size();
    loop_.arrange(bodies, first_block, bodies.velocity);
    rest_points_.resize(loop_.points.size());
    rest_blocks_.resize(loop_.batches.size());
    loop_.share(loop_.batches.size() - first_batch, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first_batch + first; i < first_batch + last; ++i) {
            start_batch(bodies, pairs, i);
        }
    });
    for (std::size_t i = first_block; has_two_coefficients_ && i < loop_.blocks.size(); ++i) {
        Block& block = loop_.blocks[i];
        set_mark(block, loop_.batch_of(block).sticking.x[Blocks::lane_of(block)] > 0.5);
    }
    loop_.share_colours([&](std::size_t first, std::size_t last) { work_on_batches(RestPhase::apply, first, last, velocity_); },
                        first_batch);
}

void ContactSolver::start_batch(const Bodies& bodies, std::vector<PairContacts>& pairs, std::size_t i) {
    const BlockBatch& batch = loop_.batches[i];
    RestBlock& rest = rest_blocks_[i];
    rest.plain = rest.edges = rest.hit = 0;
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        RestPoint& point = rest_points_[static_cast<std::size_t>(k)];
        std::fill_n(point.memory, lane_count, &no_memory.p_n);
        point.edges = 0;
    }
    for (std::size_t lane = 0; lane < lane_count; ++lane) {
        if (batch.block[lane] >= 0) {
            const Block& block = loop_.blocks[static_cast<std::size_t>(batch.block[lane])];
            start_lane(bodies, pairs[static_cast<std::size_t>(block.pair)], i, lane);
        }
    }
    work_on_batches(RestPhase::start, i, i + 1, velocity_);
}

/// Where the contacts of a lane are remembered, and how they are measured.
void ContactSolver::start_lane(const Bodies& bodies, PairContacts& pair, std::size_t i, std::size_t lane) {
    const BlockBatch& batch = loop_.batches[i];
    RestBlock& rest = rest_blocks_[i];
    const unsigned bit = 1u << lane;
    const std::span<const BlockContact> own =
        loop_.contacts_of(loop_.blocks[static_cast<std::size_t>(batch.block[lane])]);
    const ContactFeature& first = own.front().contact->feature;
    const ContactFeature& edges = own.back().contact->feature; // the last by its id, if there are any
    const bool has_edges = edges.kind == FeatureKind::edges;
    const bool is_flat = (batch.flat & bit) != 0;
    bool is_plain = is_flat || own.size() == 1;
    for (std::size_t k = 0; k < own.size(); ++k) {
        rest_points_[static_cast<std::size_t>(batch.first) + k].memory[lane] =
            &pair.memory[static_cast<std::size_t>(own[k].index)].p_n;
        const ContactFeature& feature = own[k].contact->feature;
        const bool is_on_face = is_flat && feature.kind == first.kind && !is_curved(feature);
        is_plain = is_plain && (is_on_face || (has_edges && k + 1 == own.size()));
    }
    rest.plain |= is_plain ? bit : 0u;
    if (!is_plain || !has_edges) {
        return;
    }
    rest.edges |= bit;
    rest_points_[static_cast<std::size_t>(batch.first) + own.size() - 1].edges |= bit;
    const auto a = static_cast<std::size_t>(batch.a[lane]);
    const auto b = static_cast<std::size_t>(batch.b[lane]);
    rest.reach.x[lane] = wander_share * std::min(bodies.props[a].bounding_radius, bodies.props[b].bounding_radius);
    const Vec3 edge_a = bodies.pose[a].orientation * (edges.side * edges.direction_a);
    const Vec3 edge_b = bodies.pose[b].orientation * edges.direction_b;
    for (int axis = 0; axis < 3; ++axis) {
        rest.edge_a[axis].x[lane] = edge_a[axis];
        rest.edge_b[axis].x[lane] = edge_b[axis];
    }
}

/// The mark of eq. 6, and the coefficient that goes with it.
void ContactSolver::set_mark(Block& block, bool sticks) {
    BlockBatch& batch = loop_.batch_of(block);
    const std::size_t lane = Blocks::lane_of(block);
    batch.sticking.x[lane] = sticks ? 1.0 : 0.0;
    batch.mu.x[lane] = sticks ? block.mu_s : block.mu_d;
}

void ContactSolver::find_late_impacts(const std::vector<PairContacts>& pairs, std::size_t first_block,
                                      std::span<const Velocity> at_node) {
    const double threshold = resting_threshold(settings_);
    for (std::size_t i = first_block; i < loop_.blocks.size(); ++i) {
        const Block& block = loop_.blocks[i];
        const BlockBatch& batch = loop_.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(at_node);
        const std::vector<ContactMemory>& memory = pairs[static_cast<std::size_t>(block.pair)].memory;
        for (std::size_t k = 0; k < static_cast<std::size_t>(block.count); ++k) {
            const auto at = static_cast<std::size_t>(batch.first) + k;
            const int index = loop_.contacts[static_cast<std::size_t>(block.first) + k].index;
            const bool is_new = memory[static_cast<std::size_t>(index)].last_interval == 0.0;
            if (is_new && -LanePoint(loop_.points[at], lane).normal_velocity(twist) > threshold) {
                rest_points_[at].ahead |= 1u << lane;
                rest_points_[at].closing |= 1u << lane;
            }
        }
    }
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

/// Impulses p minimise p.A p / 2 + b.p where they converge: the share s of a guess p is best at 1 - p.r / p.A p, where r is
/// how much faster than their targets the contacts part with all of it, and p.A p twice the kinetic energy of what it changes.
void ContactSolver::scale_warm_start(const Bodies& bodies, const std::vector<PairContacts>& pairs) {
    predict(bodies);
    measure(bodies, pairs);
    double work = 0.0; // p.r [J]
    for (const Block& block : loop_.blocks) {
        const BlockBatch& batch = loop_.batch_of(block);
        const std::size_t lane = Blocks::lane_of(block);
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(velocity_);
        for (const BatchPoint& of : loop_.points_of(batch).first(static_cast<std::size_t>(block.count))) {
            const LanePoint point(of, lane);
            const Vec2 target(of.u_t_target[0].x[lane], of.u_t_target[1].x[lane]);
            work += point.p_n * (point.normal_velocity(twist) - of.u_n_target.x[lane]) +
                    point.p_t.dot(point.tangential_velocity(twist) - target);
        }
    }
    double energy = 0.0; // p.A p [J]
    for (const std::size_t i : solved_bodies_) {
        if (!bodies.props[i].is_static()) {
            const Velocity change{velocity_[i].v - bodies.velocity[i].v, velocity_[i].w - bodies.velocity[i].w};
            energy += 2.0 * kinetic_energy(bodies.props[i], bodies.pose[i].orientation, change);
        }
    }
    const double share = std::clamp(1.0 - work / energy, 0.0, 1.0);
    if (!(energy > 0.0) || share > 0.5) {
        return; // all of it is nearer than none
    }
    for (const std::size_t i : solved_bodies_) {
        velocity_[i].v = bodies.velocity[i].v + share * (velocity_[i].v - bodies.velocity[i].v);
        velocity_[i].w = bodies.velocity[i].w + share * (velocity_[i].w - bodies.velocity[i].w);
    }
    for (BatchPoint& point : loop_.points) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            point.p_n.x[lane] *= share;
            point.p_t[0].x[lane] *= share;
            point.p_t[1].x[lane] *= share;
        }
    }
}

ContactSolveReport ContactSolver::solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                        std::span<const Joint> joints) {
    ContactSolveReport report;
    if (std::exchange(doubts_guess_, false)) {
        scale_warm_start(bodies, pairs);
    }
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
