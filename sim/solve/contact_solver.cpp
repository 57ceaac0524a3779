#include "sim/solve/contact_solver.h"

#include "sim/base/disjoint_sets.h"
#include "sim/model/integrate.h"
#include "sim/solve/gap_measure.h"
#include "sim/solve/half_kicks.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace sim {
namespace {

/// Share [-] of the tolerance that each of these may leave: a change that ends the sweeps (over h; or the velocity tolerance,
/// whichever is smaller; more than it over h is visited again where sweeps go on); the gap errors of one linear solve before it
/// is repeated at the predicted poses; and a gap as it is, for closing it would need a velocity, which the next step has to take
/// away again, and no tower rests on such. And of what ends the sweeps, what overlaps that cannot part are asked for.
constexpr double left_share = 0.5;

/// Share [-] of the impulses at t0 that acts before it, when the velocities were last exact `last_interval`
/// [s] ago.
double node_weight(double last_interval, double h) {
    return last_interval / (last_interval + h);
}

/// An impact is passed on by contacts whose impulse exceeds this many times [-] the last step's force, and the weight.
/// What the bodies that it reaches feel beyond these answers it and is no force. Elsewhere all impulses are: of a load that only
/// moves from one contact to another, what counts and what does not must balance, or bodies at rest would be told to approach.
constexpr double largest_growth = 2.0;

/// Sweeps end within the tolerance, and where they change at most this share [-] of what the interval's first one did: what each
/// step leaves adds up, and towers bounce. By trial with towers of 20 to 60 cubes and the funnel, as settled_change.
constexpr double solved_share = 0.25;

/// Changes [m/s] that a solve may leave to those of the next steps: where it finds more it leaves a share of that only. What is left
/// adds up from step to step, until one is swept on and takes it away. That is a force too much in the next step, which may leave a
/// share of this only: were it left, it would have to be taken away again in every second step.
constexpr double settled_change = 3e-6;

} // namespace

void ContactSolver::set_rules(const StepSettings& settings, double h) {
    settings_ = settings;
    const double step_share = std::min(h / settings.time_step.value(), 1.0);
    iteration_tolerance_ = std::min(left_share * settings.tolerance / h, settings.velocity_tolerance);
    const Vec3& gravity = settings.gravity;
    rules_ = {.h = h,
              .tolerance = settings.tolerance,
              .band = left_share * settings.tolerance,
              .step_share = step_share,
              .velocity_tolerance = settings.velocity_tolerance,
              .largest_growth = largest_growth,
              .limit = 1.0 - same_share,
              .slip_tolerance = left_share * settings.tolerance,
              .gravity = {gravity.x(), gravity.y(), gravity.z()},
              .weight = gravity.norm(),
              .warm_start = settings.warm_start,
              .is_stretched = h > memory_interval_};
}

void ContactSolver::prepare(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                            const StepSettings& settings, double h) {
    set_rules(settings, h);
    joint_weight_.clear();
    for (const Joint& joint : joints) {
        joint_weight_.push_back(node_weight(joint.memory.last_interval, h));
    }
    joints_.begin_solve(joints);
    to_.begin(bodies, settings.gravity, h);
    for (const PairContacts& pair : pairs) {
        to_.add(pair.manifold.body_a);
        to_.add(pair.manifold.body_b);
    }
    for (const Joint& joint : joints) {
        to_.add(joint.a);
        to_.add(joint.b);
    }
    to_.move_others(bodies, workers_);
    change_.resize(bodies.props.size());
    guessed_.resize(bodies.props.size());
    groups_.form(bodies, pairs, joints_, to_.solved, workers_);
}

/// Begins with a guess, without what is uncertain of it: g, the impulses that answered an impact; all of them, from a shorter
/// interval or an unconverged solve. The gaps are measured without it: those of bodies that all of g may turn by a radian tell
/// nothing. Nor does the rest of the guess where joints hold against it, or their motors: alone, either turns a light body as far,
/// and what is missed there of gaps and slips, with the square of it, no motion gives that the joints have. Sweeps then come to no
/// end, but push contacts and joints ever harder against each other. Joints and contacts are measured before any impulse.
/// Of overlaps that could not part in the last interval half is the guess: impulses that hold against each other move nothing, would be
/// handed from step to step, and what each adds to them would grow until it does work.
void ContactSolver::begin_group(const Bodies& bodies, const std::vector<PairContacts>& pairs, ContactGroup& group) {
    for (const std::size_t i : group.bodies) {
        change_[i] = {};
        guessed_[i] = to_.velocity[i];
    }
    group.enough = 0.0;
    const BlockBodies& known = groups_.block_bodies();
    const bool was_swept = std::ranges::any_of(group.bodies, [&](std::size_t i) { return known.swept[i]; });
    group.settled = (was_swept ? solved_share : 1.0) * std::min(iteration_tolerance_, settled_change);
    group.sweeps = 0;
    group.contacts.loop.may_give_way = may_give_way;
    group.contacts.loop.joints = group.assemblies.empty() ? nullptr : &joints_;
    RestRules rules = rules_;
    rules.is_wedged = std::ranges::any_of(group.bodies, [&](std::size_t i) { return known.wedged[i]; });
    group.contacts.follow(settings_, rules);
    group.contacts.begin(bodies, pairs, group.pairs, to_, change_);
    take_uncertain(group);
    if (!group.assemblies.empty()) {
        for (const std::size_t i : group.bodies) {
            std::swap(to_.velocity[i], guessed_[i]);
        }
    }
}

/// Once the targets are set.
void ContactSolver::give_guess(const Bodies& bodies, ContactGroup& group) {
    if (!group.assemblies.empty() && !group.contacts.loop.empty()) {
        for (const std::size_t i : group.bodies) {
            to_.velocity[i] = guessed_[i];
        }
        joints_.solve(group.assemblies, to_.velocity);
    }
    give_uncertain(bodies, group);
}

/// Takes what they changed, change_, out of the velocities of its bodies.
void ContactSolver::take_uncertain(ContactGroup& group) {
    group.changed.clear();
    for (const std::size_t i : group.bodies) {
        if (change_[i].v.isZero(0.0) && change_[i].w.isZero(0.0)) {
            continue;
        }
        group.changed.push_back(i);
        to_.velocity[i].v -= change_[i].v;
        to_.velocity[i].w -= change_[i].w;
    }
}

/// Impulses p minimise p.A p / 2 + b.p where they converge. Of a guess f + g the share s of g is best at -g.r / g.A g, where r
/// is how much faster than their targets the contacts part with f alone, and g.A g twice the kinetic energy of what g changes.
/// All of it is given back where that is nearer than none. The targets stay those of f alone until the next measurement.
void ContactSolver::give_uncertain(const Bodies& bodies, ContactGroup& group) {
    double energy = 0.0; // g.A g [J]
    for (const std::size_t i : group.changed) {
        energy += 2.0 * kinetic_energy(bodies.props[i], bodies.pose[i].orientation, change_[i]);
    }
    if (energy == 0.0) {
        return;
    }
    const double best = std::clamp(-group.contacts.uncertain_work(to_.velocity) / energy, 0.0, 1.0);
    const double share = best > 0.5 ? 1.0 : best;
    for (const std::size_t i : group.changed) {
        to_.velocity[i].v += share * change_[i].v;
        to_.velocity[i].w += share * change_[i].w;
    }
    group.contacts.scale_uncertain(share);
}

/// What a part of a step may add to an error that a step may leave [m]: the same error of velocities is a smaller gap.
double ContactSolver::part_of(double tolerance) const {
    return std::min(std::max(rules_.step_share * tolerance, gap_rounding), tolerance);
}

/// Sweeps over joints and contacts (projected Gauss-Seidel) until neither changes by more than what is enough; the joints are closed
/// then. Returns what that has cost, in sweeps.
int ContactSolver::iterate(ContactGroup& group, int budget, bool& converged) {
    Blocks& loop = group.contacts.loop;
    const double tolerance = iteration_tolerance_;
    const auto is_enough = [&](double change) {
        return change <= std::max(group.enough, loop.let_pass() * settings_.tolerance / rules_.h);
    };
    bool is_held = false;
    double last = std::numeric_limits<double>::infinity(); // [m/s] change of the sweep before
    double missing = 0.0; // [m/s] of the joints, before the last sweep's visits
    const bool has_joints = !group.assemblies.empty();
    std::function<void()> close_joints;
    if (has_joints) {
        close_joints = [&] { missing = std::max(missing, joints_.solve(group.assemblies, to_.velocity)); };
    }
    loop.wake(budget);
    for (converged = false; loop.spent() < budget && !converged;) {
        const double skip = skip_share * std::min(tolerance, last);
        missing = 0.0;
        last = loop.sweep(to_.velocity, skip, tolerance, rules_.band / rules_.h, close_joints);
        if (group.enough == 0.0) {
            group.enough = std::min(tolerance, std::max(solved_share * last, group.settled));
        }
        converged = is_enough(last);
        // A row that is wedged between two walls cannot leave both: asked to, it would push harder in every sweep.
        if (loop.stalls() && !converged && !std::exchange(is_held, true)) {
            group.is_wedged = group.contacts.hold_overlaps(left_share * group.enough) > 0.0 || group.is_wedged;
        }
        converged = converged && (loop.empty() || !has_joints || (loop.sweeps() > 1 && is_enough(missing)));
    }
    group.sweeps += loop.sweeps();
    if (has_joints && !loop.empty()) {
        joints_.solve(group.assemblies, to_.velocity);
    }
    return loop.spent();
}

ContactSolveReport ContactSolver::solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                        std::span<const Joint> joints) {
    const auto is_due = [](const ContactGroup& group) { return group.is_due; };
    groups_.for_each(workers_, is_due, [&](ContactGroup& group) { solve_group(bodies, pairs, joints, group); });
    ContactSolveReport report;
    for (ContactGroup& group : groups_) {
        if (std::exchange(group.is_due, false)) {
            report.iterations = std::max(report.iterations, group.report.iterations);
        }
        report.residual = std::max(report.residual, group.report.residual);
        report.joint_residual = std::max(report.joint_residual, group.report.joint_residual);
        report.work = std::max(report.work, group.report.work);
        report.converged = report.converged && group.report.converged;
    }
    converged_ = report.converged;
    return report;
}

void ContactSolver::solve_group(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                                ContactGroup& group) {
    RestingContacts& contacts = group.contacts;
    Workers* const workers = contacts.loop.workers;
    const bool is_guess = !std::exchange(group.is_begun, true);
    if (is_guess) {
        begin_group(bodies, pairs, group);
    }
    ContactSolveReport& report = group.report;
    report = {};
    const GapMeasure gaps{bodies, pairs, to_, contacts};
    to_.update(bodies, group.bodies, workers);
    const double gap_tolerance = part_of(settings_.tolerance);
    const double joint_tolerance = part_of(settings_.joint_tolerance);
    for (int outer = 0; !contacts.loop.empty() || !group.assemblies.empty(); ++outer) {
        const auto [contacts_before, joints_before] = std::pair(report.residual, report.joint_residual);
        report.residual = gaps.measure();
        if (!group.assemblies.empty()) {
            report.joint_residual = joints_.target_closed(group.assemblies, joints, to_, rules_.step_share);
        }
        if (outer == 0 && is_guess) {
            give_guess(bodies, group);
        }
        const bool are_closed = outer > 0 && report.residual <= left_share * gap_tolerance; // the contacts' gaps
        if (are_closed && report.joint_residual <= joint_tolerance) {
            break;
        }
        const int left = settings_.iteration_limit - report.iterations;
        // Where bodies turn so far that another linear solve makes it worse, only a shorter interval helps.
        const bool diverges = outer > 1 && (report.residual > std::max(contacts_before, gap_tolerance) ||
                                            report.joint_residual > std::max(joints_before, joint_tolerance));
        if (left <= 0 || outer == most_rounds || diverges) {
            break;
        }
        if (are_closed) { // what the joints still miss is far less than gaps may be wrong, and sweeps would open them again
            joints_.solve(group.assemblies, to_.velocity);
            to_.update(bodies, group.bodies, workers);
            continue;
        }
        bool converged = false;
        report.iterations += iterate(group, left, converged);
        for (int round = 0; round < most_rounds && converged && contacts.update_marks(bodies, pairs, to_.velocity); ++round) {
            report.iterations += iterate(group, std::max(settings_.iteration_limit - report.iterations, 1), converged);
        }
        group.given_way = std::max(group.given_way, contacts.give_way(to_.velocity));
        to_.update(bodies, group.bodies, workers);
    }
    report.work = is_driven(group) ? 0.0 : contacts.impulse_work(to_.velocity);
    report.converged = report.residual <= gap_tolerance && report.joint_residual <= joint_tolerance;
}

/// Impulses that do not converge may be anything, but give no energy: bodies that they make faster as a whole become as slow as they
/// were, so gaps stay between what they are and what they would become. Something that stands has to bear them: their momentum
/// goes. Not where what bears them moves, or springs and motors act, which give energy. What has become slow together is `held`
/// together.
void ContactSolver::slow_down(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                              std::vector<int>& held) {
    for (const ContactGroup& group : groups_) {
        bool stands = false; // what it bears on
        bool moves = false;
        for (const int pair : group.pairs) {
            const Manifold& manifold = pairs[static_cast<std::size_t>(pair)].manifold;
            for (const int body : {manifold.body_a, manifold.body_b}) {
                const auto i = static_cast<std::size_t>(body);
                const bool is_at_rest = bodies.velocity[i].v.isZero(0.0) && bodies.velocity[i].w.isZero(0.0);
                (is_at_rest ? stands : moves) |= bodies.props[i].is_static();
            }
        }
        if (is_driven(group) || !stands || moves) {
            continue;
        }
        const auto energy = [&](std::span<const Velocity> velocity) {
            double sum = 0.0; // [J]
            for (const std::size_t i : group.bodies) {
                sum += kinetic_energy(bodies.props[i], bodies.pose[i].orientation, velocity[i]);
            }
            return sum;
        };
        const double before = energy(bodies.velocity);
        const double after = energy(to_.velocity);
        if (after <= before) {
            continue;
        }
        const double share = std::sqrt(before / after);
        for (const std::size_t i : group.bodies) {
            to_.velocity[i].v *= share;
            to_.velocity[i].w *= share;
            unite(held, static_cast<int>(group.bodies.front()), static_cast<int>(i));
        }
        to_.update(bodies, group.bodies, workers_);
        joints_.target_closed(group.assemblies, joints, to_, rules_.step_share); // how far they are open now
    }
}

/// Do half kicks give the group more energy than its springs and motors do by theirs, and than all impulses of the instant? A spring
/// that is stiff for the step gives all of its impulse after the instant; a light body that it holds against a load would be thrown.
bool ContactSolver::is_told_more(const Bodies& bodies, const ContactGroup& group) const {
    double told = 0.0, by_all = 0.0, by_drives = 0.0; // [J]
    for (const std::size_t i : group.bodies) {
        const auto energy = [&](const Velocity& of) { return kinetic_energy(bodies.props[i], bodies.pose[i].orientation, of); };
        const double before = energy(bodies.velocity[i]);
        told += energy(at_node_[i]) - before;
        by_all += energy(to_.velocity[i]) - before;
    }
    for (const int assembly : group.assemblies) {
        by_drives += joints_.half_kick_work(assembly, bodies.velocity, at_node_);
    }
    return told > std::max({by_all, by_drives, 0.0});
}

/// Not known where joints' springs and motors, or keys, give energy too.
void ContactSolver::find_energy_lost(const Bodies& bodies) {
    lost_.clear();
    for (const ContactGroup& group : groups_) {
        const bool is_known = !is_driven(group) && bodies.kinematic.empty();
        for (const std::size_t i : group.bodies) {
            if (to_.is_reached[i] != 0) {
                const auto energy = [&](const Velocity& of) {
                    return kinetic_energy(bodies.props[i], bodies.pose[i].orientation, of);
                };
                lost_.push_back({i, is_known ? energy(bodies.velocity[i]) - energy(to_.velocity[i])
                                             : std::numeric_limits<double>::infinity()});
            }
        }
    }
    std::ranges::sort(lost_, {}, &EnergyLoss::body);
}

std::vector<int> ContactSolver::store_impulses(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                                               std::span<Joint> joints, bool falls_short) {
    memory_interval_ = converged_ ? rules_.h : 0.0;
    at_node_ = bodies.velocity;
    const auto has_pairs = [](const ContactGroup& group) { return !group.pairs.empty(); };
    groups_.for_each(workers_, has_pairs, [&](ContactGroup& group) {
        std::vector<std::span<const int>> held;
        for (const int assembly : group.assemblies) {
            held.push_back(joints_.bodies_of(assembly));
        }
        group.contacts.store(pairs, group.pairs, held, to_, at_node_);
    });
    groups_.count_sweeps();
    if (!joints.empty()) {
        joints_.store(joints, joint_weight_);
        joints_.add_before(joints_.assemblies(), joint_weight_, at_node_);
    }
    std::vector<int> connected = sets_of_one(at_node_.size());
    std::vector<std::size_t> loaded; // joints alone give no energy
    for (const ContactGroup& group : groups_) {
        group.contacts.unite_loaded(connected);
        if (has_pairs(group) && (!is_driven(group) || is_told_more(bodies, group))) {
            loaded.insert(loaded.end(), group.bodies.begin(), group.bodies.end());
        }
    }
    joints_.unite_bodies(connected);
    find_firsts(connected);
    std::vector<int> held = connected;
    if (falls_short) {
        slow_down(bodies, pairs, joints, held);
        find_firsts(held);
    }
    for (const ContactGroup& group : groups_) { // what bears a spring is told of its own: the spring gives no half of what it bears
        for (std::size_t i = 0; is_driven(group) && i < group.bodies.size(); ++i) {
            held[group.bodies[i]] = static_cast<int>(group.bodies[i]);
        }
    }
    if (cut_half_kicks(bodies, loaded, held, to_.velocity, at_node_)) {
        joints_.close_again(at_node_);
    }
    find_energy_lost(bodies);
    for (Joint& joint : joints) {
        joint.memory.last_interval = rules_.h;
    }
    return connected;
}

double ContactSolver::given_way() const {
    return std::ranges::max_element(groups_, {}, &ContactGroup::given_way)->given_way;
}

double ContactSolver::given_way(int pair) const {
    const auto holds = [&](const ContactGroup& group) {
        return group.given_way > 0.0 && std::ranges::find(group.pairs, pair) != group.pairs.end();
    };
    const auto found = std::ranges::find_if(groups_, holds);
    return found == groups_.end() ? 0.0 : found->given_way;
}

int ContactSolver::contact_count() const {
    std::size_t count = 0;
    for (const ContactGroup& group : groups_) {
        count += group.contacts.loop.contacts.size();
    }
    return static_cast<int>(count);
}

/// Of the group whose gaps miss their tolerance by most. Its joints are to blame where its contacts' gaps do not.
Unsettled ContactSolver::least_settled() {
    Unsettled found;
    double worst = -1.0;
    for (ContactGroup& group : groups_) {
        const double of_contacts = group.report.residual / part_of(settings_.tolerance);
        const double of_joints = group.report.joint_residual / part_of(settings_.joint_tolerance);
        const bool are_joints = of_contacts <= 1.0 && of_joints > 1.0;
        const double missed = are_joints ? of_joints : of_contacts;
        if (missed <= worst || (group.contacts.loop.empty() && !are_joints)) {
            continue;
        }
        worst = missed;
        if (are_joints) {
            const JointSolver::Opening widest = joints_.widest(group.assemblies);
            found = {.joint = widest.joint, .error = widest.gap};
        } else {
            found = group.contacts.loop.least_settled();
            found.error = group.report.residual;
        }
    }
    return found;
}

DriveWork ContactSolver::drive_work(const Bodies& bodies) {
    const std::vector<Velocity> velocity = kinematic_velocity(bodies);
    DriveWork work;
    for (const ContactGroup& group : groups_) {
        const DriveWork of_group = group.contacts.work_by(velocity);
        work.all += of_group.all;
        work.ahead += of_group.ahead;
    }
    const JointSolver::Kick kick{bodies.velocity, at_node_, to_.velocity};
    const DriveWork of_joints = joints_.work(velocity, joints_.has_motors() ? &kick : nullptr);
    work.all += of_joints.all;
    work.ahead += of_joints.ahead;
    return work;
}

double ContactSolver::joint_rate(const Bodies& bodies) {
    std::vector<double> interval;
    for (const double weight : joint_weight_) {
        interval.push_back(impulse_interval(weight, rules_.h));
    }
    const std::vector<double> rates = joints_.fastest_rates(bodies, interval);
    double fastest = 0.0;
    for (const ContactGroup& group : groups_) {
        for (const int assembly : group.assemblies) {
            fastest = std::max(fastest, (group.contacts.loop.empty() ? 1.0 : 2.0) * rates[static_cast<std::size_t>(assembly)]);
        }
    }
    return fastest;
}

} // namespace sim
