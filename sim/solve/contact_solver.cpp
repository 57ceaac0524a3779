#include "sim/solve/contact_solver.h"

#include "sim/block/contact_graph.h"
#include "sim/model/integrate.h"
#include "sim/solve/time_of_impact.h"

#include <atomic>
#include <cmath>
#include <limits>

namespace sim {
namespace {

/// Gaps in the soft band are closed by this share [-] of them a step; more slowly where the tolerance is loose: sweeps
/// that take away the share s of an error in velocity, from impulses that each step starts from whole, act on a heap as
/// a damper s, a spring s and the integral of a spring, s times gap_relaxation; that comes to rest only where
/// gap_relaxation < s (Routh), and the slowest motion of a tower of 20 solved by a few sweeps a step has s = 0.01 or less.
constexpr double gap_relaxation = 0.1; // at it towers come to rest with tight tolerances
constexpr double loose_gap_relaxation = 0.003;

/// Where a loose tolerance is met, sweeps go on, so many at most, until the changes are this share [-] of the first
/// one, or slower than this [m/s], a tenth of what counts as rest: a heap comes to rest over the steps, at little cost.
constexpr int settling_sweeps = 8;
constexpr double settling_share = 0.1;
constexpr double settled_change = 1e-5;

/// Blocks are passed over while their bodies changed by less than this share [-] of the iteration's tolerance, and less
/// than that share of the change of the sweep before.
constexpr double skip_share = 0.2;
constexpr double last_share = 0.05;

/// Targets that a rigid motion misses by this share [-] of the iteration's tolerance are met on average.
constexpr double slack_share = 0.1;

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

void ContactSolver::prepare(const Bodies& bodies, std::vector<PairContacts>& pairs,
                            std::span<const Joint> joints, std::span<const JointMemory> joint_memory,
                            const StepSettings& settings, double h) {
    settings_ = settings;
    stop_at_impacts_ = settings.impacts == ImpactHandling::stop;
    h_ = h;
    step_share_ = std::min(h / settings.time_step.value(), 1.0);
    iteration_tolerance_ = std::min(iteration_share * settings.tolerance / h, settings.velocity_tolerance);
    relaxation_ = gap_relaxation * std::clamp(tight_velocity_tolerance / iteration_tolerance_,
                                              loose_gap_relaxation / gap_relaxation, 1.0);
    velocity_ = bodies.velocity;
    measured_.resize(bodies.props.size());
    predicted_.resize(bodies.props.size());
    placed_.resize(bodies.props.size());
    radius_.resize(bodies.props.size());
    loop_.clear();
    joint_weight_.clear();
    for (const JointMemory& memory : joint_memory) {
        joint_weight_.push_back(node_weight(memory.last_interval, h));
    }
    joints_.prepare(bodies, joints);
    find_solved_bodies(bodies, pairs, joints);
    std::vector<Place> places(pairs.size() + 1); // of each pair and of the end
    std::atomic<bool> all_taken = true;
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        Taken taken;
        for (std::size_t pair = first; pair < last; ++pair) {
            places[pair + 1] = size_of(bodies, pairs[pair], taken);
            if (places[pair + 1].point != pairs[pair].manifold.contacts.size()) {
                all_taken = false;
            }
        }
    });
    all_in_solve_ = all_taken;
    for (std::size_t pair = 0; pair < pairs.size(); ++pair) {
        places[pair + 1].block += places[pair].block;
        places[pair + 1].point += places[pair].point;
    }
    loop_.blocks.resize(places.back().block);
    in_lanes_ = fits_lanes(pairs);
    point_count_ = places.back().point;
    if (in_lanes_) {
        start_lanes(bodies, pairs, places);
        return;
    }
    resize(places.back());
    loop_.share(pairs.size(), [&](std::size_t first, std::size_t last) {
        Taken taken;
        for (std::size_t pair = first; pair < last; ++pair) {
            take(bodies, pairs[pair], taken);
            place_contacts(bodies, pairs[pair], static_cast<int>(pair), places[pair], taken);
        }
    });
    apply_impulses(bodies, 0);
}

void ContactSolver::add_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair,
                                 std::span<const Velocity> at_node) {
    leave_lanes(bodies, pairs);
    const PairContacts& added = pairs[static_cast<std::size_t>(pair)];
    add_solved_body(bodies, added.manifold.body_a);
    add_solved_body(bodies, added.manifold.body_b);
    Taken taken;
    take(bodies, added, taken);
    all_in_solve_ = all_in_solve_ && taken.at.size() == added.manifold.contacts.size();
    const Place place{loop_.blocks.size(), loop_.points.size()};
    resize({place.block + block_count(taken.at), place.point + taken.at.size()});
    place_contacts(bodies, added, pair, place, taken);
    find_late_impacts(added, place.block, at_node);
    apply_impulses(bodies, place.block);
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

void ContactSolver::find_late_impacts(const PairContacts& pair, std::size_t first_block, std::span<const Velocity> at_node) {
    const double threshold = resting_threshold(settings_);
    for (std::size_t block = first_block; block < loop_.blocks.size(); ++block) {
        const Vec6 twist = relative_twist(loop_.blocks[block], at_node);
        for (int k = loop_.blocks[block].first; k < loop_.blocks[block].first + loop_.blocks[block].count; ++k) {
            RestingContact& contact = contacts_[static_cast<std::size_t>(k)];
            const bool is_new = pair.memory[static_cast<std::size_t>(contact.index)].last_interval == 0.0;
            if (is_new && -normal_velocity(loop_.points[static_cast<std::size_t>(k)], twist) > threshold) {
                contact.is_ahead = contact.would_close = true;
            }
        }
    }
}

/// Blocks and points that take() will hold of a pair. taken: memory.
ContactSolver::Place ContactSolver::size_of(const Bodies& bodies, const PairContacts& pair, Taken& taken) const {
    if (!stop_at_impacts_) {
        return {pair.blocks, pair.manifold.contacts.size()};
    }
    take(bodies, pair, taken);
    return {block_count(taken.at), taken.at.size()};
}

/// The contacts of a pair that the solve holds; impacts are waited for, where the step stops at them.
void ContactSolver::take(const Bodies& bodies, const PairContacts& pair, Taken& taken) const {
    taken.at.clear();
    taken.index.clear();
    for (std::size_t i = 0; i < pair.manifold.contacts.size(); ++i) {
        const Contact& contact = pair.manifold.contacts[i];
        if (!stop_at_impacts_ || !is_impact(bodies, pair.manifold, contact, settings_)) {
            taken.at.push_back(contact.at);
            taken.index.push_back(static_cast<int>(i));
        }
    }
}

void ContactSolver::resize(const Place& end) {
    loop_.blocks.resize(end.block);
    loop_.points.resize(end.point);
    contacts_.resize(end.point);
    point_count_ = end.point;
}

/// Blocks, points and contacts of a pair, from `place` on.
void ContactSolver::place_contacts(const Bodies& bodies, const PairContacts& pair, int pair_index, const Place& place,
                                   const Taken& taken) {
    for (std::size_t i = 0; i < taken.index.size(); ++i) {
        contacts_[place.point + i] = {};
        contacts_[place.point + i].pair = pair_index;
        contacts_[place.point + i].index = taken.index[i];
    }
    loop_.place(place.block, place.point, bodies, pair.manifold.body_a, pair.manifold.body_b, taken.at, pair.material);
    for (std::size_t k = 0; k < block_count(taken.at); ++k) {
        start_block(bodies, pair, loop_.blocks[place.block + k]);
    }
}

/// Gives the bodies the impulses that the blocks from `first` on start from.
void ContactSolver::apply_impulses(const Bodies& bodies, std::size_t first) {
    for (std::size_t k = first; k < loop_.blocks.size(); ++k) {
        const ContactBlock& block = loop_.blocks[k];
        apply_wrench(block, wrench_of(loop_.points_of(block)), bodies.props, bodies.inverse_inertia, velocity_);
    }
}

void ContactSolver::drop_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair) {
    leave_lanes(bodies, pairs);
    all_in_solve_ = false;
    for (ContactBlock& block : loop_.blocks) {
        if (block.count > 0 && contacts_[static_cast<std::size_t>(block.first)].pair == pair) {
            apply_wrench(block, -wrench_of(loop_.points_of(block)), bodies.props, bodies.inverse_inertia,
                         velocity_);
            block.count = 0;
        }
    }
}

/// What a block and its contacts know as the interval begins: velocities, targets, and the impulses of the
/// last step.
void ContactSolver::start_block(const Bodies& bodies, const PairContacts& pair, ContactBlock& block) {
    double last_interval = 0.0;
    bool touches = false;
    const ContactFeature& feature =
        pair.manifold.contacts[static_cast<std::size_t>(contacts_[static_cast<std::size_t>(block.first)].index)].feature;
    block.set_surface(feature);
    for (int k = block.first; k < block.first + block.count; ++k) {
        const auto i = static_cast<std::size_t>(contacts_[static_cast<std::size_t>(k)].index);
        last_interval = std::max(last_interval, pair.memory[i].last_interval);
        touches = touches || pair.manifold.contacts[i].at.gap <= settings_.tolerance;
    }
    // A block that is placed ahead of its impact takes its sliding direction after the impulse, as a
    // collision does.
    block.node_weight = touches ? node_weight(last_interval, h_) : 1.0;
    const double fall = -relative_gravity(bodies, pair.manifold, settings_).dot(block.frame.col(2));
    const double band = soft_band * settings_.tolerance;
    const double interval = impulse_interval(block.node_weight, h_);
    const Vec6 twist = relative_twist(block, bodies.velocity);
    block.twist_before = tangential_part(twist);
    for (int k = block.first; k < block.first + block.count; ++k) {
        ContactPoint& point = loop_.points[static_cast<std::size_t>(k)];
        RestingContact& resting = contacts_[static_cast<std::size_t>(k)];
        const auto& [own, at] = pair.manifold.contacts[static_cast<std::size_t>(resting.index)];
        resting.is_on_face = block.is_flat && own.kind == feature.kind && !is_curved(own);
        const ContactMemory& memory = pair.memory[static_cast<std::size_t>(resting.index)];
        resting.is_ahead = at.gap > settings_.tolerance;
        resting.u_n_before = normal_velocity(point, twist);
        const double approach = std::max(-resting.u_n_before, 0.0);
        resting.approach_speed = std::max(std::sqrt(std::max(approach * approach + 2.0 * fall * at.gap, 0.0)),
                                          memory.approach_speed);
        resting.would_close = resting.is_ahead && at.gap + h_ * (resting.u_n_before - 0.5 * h_ * fall) <= 0.0;
        if (at.gap <= band) {
            const double after_step = std::max((1.0 - relaxation_) * at.gap, -band);
            resting.gap_target = at.gap + step_share_ * (after_step - at.gap);
        }
        set_material_points(bodies, block, at, resting);
        if (block.has_friction()) {
            resting.owed = relaxation_ * step_share_ *
                           Vec2(memory.slip.dot(block.frame.col(0)), memory.slip.dot(block.frame.col(1)));
        }
        const double stretch = memory.p_n > 0.0 ? interval / memory.interval : 0.0;
        const double scale = stretch <= largest_stretch ? stretch : 0.0;
        resting.load = scale * memory.force_share * memory.p_n;
        resting.restarts = memory.p_n > 0.0 && memory.last_interval == 0.0;
        if (settings_.warm_start && memory.p_n > 0.0) {
            point.p_n = scale * memory.p_n;
            point.p_t = scale * Vec2(memory.p_t.dot(block.frame.col(0)), memory.p_t.dot(block.frame.col(1)));
            block.is_sticking = block.is_sticking || memory.is_sticking();
        }
        // A contact that begins at rest sticks if it can.
        const bool is_new = memory.p_n == 0.0 && memory.last_interval == 0.0;
        block.is_sticking = block.is_sticking || (is_new && !resting.is_ahead &&
                                                  tangential_before(block, point).norm() <= settings_.velocity_tolerance);
    }
}

/// What a part of a step may add to an error that a step may leave [m]: the same error of velocities is a smaller gap.
double ContactSolver::part_of(double tolerance) const {
    return std::min(std::max(step_share_ * tolerance, gap_rounding), tolerance);
}

/// Sweeps over joints and contacts until nothing changes by more than `tolerance` [m/s]. Returns their
/// number.
int ContactSolver::iterate(const Bodies& bodies, double tolerance, int budget, bool& converged) {
    const double joint_tolerance = part_of(settings_.joint_tolerance) / h_;
    int count = 0;
    double last = std::numeric_limits<double>::infinity();    // [m/s] change of the sweep before
    double settled = std::numeric_limits<double>::infinity(); // [m/s], once the first sweep has told
    const bool has_joints = !joints_.empty();
    const bool together = TogetherSweeps::fits(loop_);
    together    ? together_.begin(loop_, bodies)
    : in_lanes_ ? loop_.wake(bodies)
                : loop_.load_batches(bodies);
    for (converged = false; count < budget && !converged; ++count) {
        const double missing = has_joints ? joints_.solve(velocity_) : 0.0;
        const double skip =
            has_joints ? -1.0 : std::min(skip_share * tolerance, std::max(settled_change, last_share * last));
        const double change = loop_.empty() ? 0.0
                              : together    ? together_.sweep(loop_, bodies, velocity_)
                                            : loop_.sweep(velocity_, skip, slack_share * tolerance,
                                                          projections_in(count, last, tolerance));
        last = change;
        settled = count == 0 ? std::max(settling_share * change, settled_change) : settled;
        converged = change <= tolerance && (change <= settled || settling_++ >= settling_sweeps);
        converged = converged && (loop_.empty() || !has_joints || (count > 0 && missing <= joint_tolerance));
    }
    if (!together && !in_lanes_) {
        loop_.store_impulses();
    }
    return count;
}

/// Eq. 6 on converged sums. A marked block that is at its limit and slips loses its mark; a sliding one that
/// the step would reverse has stopped within it, and sticks if static friction can hold it. Returns true if
/// the iteration has to go on for it: with mu_s = mu_d a mark changes nothing.
bool ContactSolver::update_marks(const std::vector<PairContacts>& pairs) {
    if (in_lanes_) {
        return false;
    }
    const double slip_tolerance = iteration_share * settings_.tolerance / h_;
    bool changed = false;
    for (ContactBlock& block : loop_.blocks) {
        if (block.mu_d == block.mu_s) {
            continue;
        }
        const Vec6 twist = relative_twist(block, velocity_);
        bool slips = false;
        bool at_limit = false;
        double reversal = 0.0;
        for (int k = block.first; k < block.first + block.count; ++k) {
            const ContactPoint& point = loop_.points[static_cast<std::size_t>(k)];
            if (point.p_n == 0.0) {
                continue;
            }
            const RestingContact& contact = contacts_[static_cast<std::size_t>(k)];
            const Vec2 slip = tangential_velocity(point, twist) - point.u_t_target;
            slips = slips || slip.norm() > slip_tolerance;
            at_limit = at_limit || is_at_limit(point, block.mu_s);
            const Vec3& sliding = pairs[static_cast<std::size_t>(contact.pair)]
                                      .memory[static_cast<std::size_t>(contact.index)]
                                      .sliding;
            reversal += point.p_n * (slip.x() * sliding.dot(block.frame.col(0)) +
                                     slip.y() * sliding.dot(block.frame.col(1)));
        }
        const bool lost = block.is_sticking && slips && at_limit;
        const bool stopped = !block.is_sticking && slips && reversal < 0.0;
        if (lost || stopped) {
            block.is_sticking = stopped;
            changed = true;
        }
    }
    return changed;
}

ContactSolveReport ContactSolver::solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                        std::span<const Joint> joints) {
    ContactSolveReport report;
    if (!TogetherSweeps::fits(loop_) && !in_lanes_) {
        loop_.arrange(bodies);
    }
    predict(bodies);
    settling_ = 0;
    const double gap_tolerance = part_of(settings_.tolerance);
    const double joint_tolerance = part_of(settings_.joint_tolerance);
    for (int outer = 0; outer < outer_limit && !(loop_.empty() && joints_.empty()); ++outer) {
        const double residual_before = report.residual;
        const bool in_batches = !TogetherSweeps::fits(loop_) && !settings_.shock_propagation;
        report.residual = outer == 0   ? measure(bodies, pairs)
                          : in_batches ? measure_batches_again(bodies, pairs)
                                       : measure_again(bodies, pairs);
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
        const int budget =
            settings_.shock_propagation ? std::min(left, settings_.shock_propagation_after) : left;
        bool converged = false;
        report.iterations += iterate(bodies, iteration_tolerance_, budget, converged);
        for (int round = 0; round < mark_rounds && converged && update_marks(pairs); ++round) {
            report.iterations += iterate(
                bodies, iteration_tolerance_, std::max(settings_.iteration_limit - report.iterations, 1), converged);
        }
        if (settings_.shock_propagation && !converged) {
            shock_propagation(bodies);
        }
        predict(bodies);
    }
    report.converged =
        report.residual <= gap_tolerance && report.joint_residual <= joint_tolerance;
    return report;
}

/// Guendelman et al. 2003: level by level from the static bodies upward, each level's bodies then count as
/// immovable.
void ContactSolver::shock_propagation(const Bodies& bodies) {
    const std::vector<int> level = contact_levels(loop_.blocks, bodies.props);
    const int top = *std::ranges::max_element(level);
    std::vector<BlockResponse> responses;
    for (const ContactBlock& block : loop_.blocks) {
        const int level_a = level[static_cast<std::size_t>(block.a)];
        const int level_b = level[static_cast<std::size_t>(block.b)];
        responses.push_back(
            block_response(block, loop_.points_of(block), bodies, level_a < level_b, level_b < level_a));
    }
    for (int current = 1; current <= top; ++current) {
        double change = std::numeric_limits<double>::infinity();
        for (int i = 0; i < settings_.shock_propagation_after && change > settings_.velocity_tolerance; ++i) {
            change = 0.0;
            for (std::size_t k = 0; k < loop_.blocks.size(); ++k) {
                const ContactBlock& block = loop_.blocks[k];
                const int level_a = level[static_cast<std::size_t>(block.a)];
                const int level_b = level[static_cast<std::size_t>(block.b)];
                if (std::max(level_a, level_b) == current) {
                    change =
                        std::max(change, solve_block(block, responses[k], loop_.points_of(block), bodies, velocity_,
                                                     most_projections, level_a < current, level_b < current));
                }
            }
        }
    }
}

} // namespace sim
