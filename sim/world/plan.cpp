/// Stage 4 of a step: how long the next interval is, and the impulses that carry the bodies over it.
#include "sim/base/error.h"
#include "sim/scene/bounds.h"
#include "sim/world/state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sim {
namespace {

/// Times the step may be divided by two when its contacts do not converge: down to h / 2^6.
constexpr int division_limit = 6;

/// By at most this angle [rad] bodies in contact or in a joint turn in one interval, and joints vibrate, in islands with contacts by
/// half of it; the step is divided for it.
constexpr double largest_turn = 0.2;

} // namespace

/// Finds the impulses of the next interval: the rest of the step, or all of the next one; shorter if an
/// impact stops it, if its contacts do not converge, or if a body is to turn too far.
void WorldState::plan(StepReport& report) {
    const StageClock clock(report, Stage::contacts);
    interval = progress < 1.0 ? interval_left() : h;
    const double parts = std::ceil(interval * std::max(intervals_for_spin(), intervals_for_joints()));
    if (parts > 1.0) {
        interval /= parts;
        ++report.divisions;
    }
    const double whole = interval;
    int division = progress < 1.0 ? std::max(divided - 1, 0) : 0; // within a step intervals grow by about twice at most
    interval /= std::exp2(division);
    bool good = false;
    while (true) {
        stopped_at_impact = false;
        good = plan_interval(report);
        if (stops_at_impacts()) {
            stop_at_impact(report, good);
        }
        joint_rate = joints.empty() ? 0.0 : contact_solver.joint_rate(bodies);
        const bool may_divide = division < division_limit && work_left() > 0;
        const double parts_for_joints = parts_of_plan_for_joints(division_limit - division);
        if (good && !(may_divide && parts_for_joints > 1.0)) {
            break;
        }
        if (may_divide) {
            ++division;
            ++report.divisions;
            interval /= good ? parts_for_joints : 2.0;
        } else if (bodies.kinematic.empty() || std::exchange(contact_solver.may_give_way, true)) {
            fall_short(report, contact_solver.least_settled());
            break;
        } else { // no motion gives what hands ask for: one solve more
            division = 0;
            interval = whole;
            work_done -= settings.iteration_limit;
        }
    }
    divided = division;
    gives_way = gives_way || contact_solver.given_way() > 0.0;
    if (repair.pressed) {
        fall_short(report, *repair.pressed);
    }
    if (stopped_at_impact) {
        ++report.impacts_stopped_at;
    }
    connected = contact_solver.store_impulses(bodies, search.pairs, joints, !good);
    if (!good) {
        report.joint_gap = contact_solver.joint_gap();
        check_joints();
    }
    if (has_drives) {
        energy.plan_work(contact_solver.drive_work(bodies));
    }
}

/// Throws Error(stopped) where the plan tears a joint open by more than the bodies reach that it holds.
void WorldState::check_joints() const {
    const auto name_of = [&](std::size_t i) { return i < names.size() ? fmt::format("'{}'", names[i]) : "the world"; };
    const std::span<const Pose> planned = contact_solver.predicted();
    for (const Joint& joint : joints) {
        const auto a = static_cast<std::size_t>(joint.a);
        const auto b = static_cast<std::size_t>(joint.b);
        double reach = 0.0; // [m]
        for (const std::size_t i : {a, b}) {
            reach = std::max(reach, bodies.props[i].is_static() ? 0.0 : bodies.props[i].bounding_radius);
        }
        if (const double opening = joint_opening(joint, planned[a], planned[b]); opening > reach) {
            throw Error(ExitCode::stopped,
                        fmt::format("the joint of {} and {} is torn open by {:.3g} m in step {}, expected at most {:.3g} m, as far "
                                    "as they reach (contacts)",
                                    name_of(a), name_of(b), opening, step_index, reach));
        }
    }
}

/// Intervals a second that the fastest rotation asks for [1/s]: of bodies in joints, and of those near contact whose contact points
/// move in the body as it turns, or whose w turns, that is all but balls of equal moments. Throws Error(stopped) beyond
/// `largest_turn_in_step`.
double WorldState::intervals_for_spin() {
    std::size_t fastest = 0;
    double rate = 0.0; // [rad/s]
    const auto look_at = [&](std::size_t i) {
        if (const double of_body = bodies.velocity[i].w.norm(); of_body > rate) {
            fastest = i;
            rate = of_body;
        }
    };
    if (std::ranges::all_of(bodies.velocity, [&](const Velocity& of) { return of.w.norm() * h <= largest_turn; })) {
        return 0.0; // one does, whatever is in contact
    }
    for (const PairContacts& pair : search.pairs) {
        for (const int body : {pair.manifold.body_a, pair.manifold.body_b}) {
            const auto i = static_cast<std::size_t>(body);
            const bool is_ball = std::holds_alternative<Sphere>(bodies.props[i].shape) &&
                                 bodies.props[i].inertia_kind == InertiaKind::spherical;
            if (!is_ball) {
                look_at(i);
            }
        }
    }
    for (const Joint& joint : joints) {
        look_at(static_cast<std::size_t>(joint.a));
        look_at(static_cast<std::size_t>(joint.b));
    }
    if (rate * h > largest_turn_in_step) {
        throw Error(ExitCode::stopped,
                    fmt::format("body '{}' spins at {:.3g} rad/s in contact or in a joint in step {}, expected "
                                "at most {:.3g} rad/s: {:g} rad a step (contacts)",
                                names[fastest], rate, step_index, largest_turn_in_step / h, largest_turn_in_step));
    }
    return rate / largest_turn;
}

/// The same for the vibration of joints under the load of the last interval: from 2 rad an interval on Verlet's scheme is
/// unstable, and gains energy. Where joints are about to lock, their load has no bound, and where a step's work is spent, they are
/// left as they are.
double WorldState::intervals_for_joints() const {
    return work_left() == 0 ? 0.0 : std::min(joint_rate, largest_turn_in_step / h) / largest_turn;
}

/// Parts [-] that the interval planned is to be taken in, as its joints vibrate so far that its half would be too long. Impacts give
/// loads of which the last interval had none. Where not even so many divisions help, as of joints that are torn, 1.
double WorldState::parts_of_plan_for_joints(int divisions) const {
    const double parts = std::ceil(interval * joint_rate / largest_turn);
    return parts > 2.0 && parts <= std::exp2(divisions) ? parts : 1.0;
}

/// Sweeps that the step under way may still take.
std::int64_t WorldState::work_left() const {
    return std::max<std::int64_t>(std::int64_t{most_solves} * settings.iteration_limit - work_done, 0);
}

void WorldState::fall_short(StepReport& report, const Unsettled& unsettled) const {
    report.at_iteration_limit = true;
    report.is_out_of_work = work_left() == 0;
    report.unsettled = unsettled;
}

/// Are impacts waited for, rather than held ahead? Not for ever: a ball coming to rest bounces infinitely often, and half of a
/// step's work is left to plan the rest of it.
bool WorldState::stops_at_impacts() const {
    return settings.impacts == ImpactHandling::stop && work_left() > work_done;
}

/// Shortens the planned interval to its first impact, if there is one. good: did the plan converge?
void WorldState::stop_at_impact(StepReport& report, bool& good) {
    const std::optional<Impact> impact =
        time_of_impact(bodies, contact_solver.velocity(), search.pairs, settings, interval);
    const std::optional<double> overlap = repair.overlap_time();
    if (!impact && !overlap) {
        return;
    }
    const bool by_feature = impact && (!overlap || impact->time <= *overlap);
    const double time = by_feature ? impact->time : *overlap;
    if (time >= interval - shortest_interval(settings)) {
        return;
    }
    stopped_at_impact = true;
    if (by_feature) {
        good = plan_until_impact(*impact, report);
    } else {
        interval = std::max(time, shortest_interval(settings));
        good = plan_interval(report);
    }
}

/// Plans the interval that ends at an impact. Its end moves a little with the impulses of the shorter
/// interval, so the time is corrected until the gap at the planned poses is closed. Returns false if the plan did not
/// converge.
bool WorldState::plan_until_impact(const Impact& impact, StepReport& report) {
    const double longest = interval;
    const Manifold& manifold = search.pairs[impact.pair].manifold;
    const auto a = static_cast<std::size_t>(manifold.body_a);
    const auto b = static_cast<std::size_t>(manifold.body_b);
    const FoundContact contact = manifold.found(manifold.contacts[impact.contact], bodies.pose[a], bodies.pose[b]);
    const double shortest = shortest_interval(settings);
    interval = std::max(impact.time, shortest);
    for (int correction = 0; correction < most_rounds; ++correction) {
        const bool good = plan_interval(report);
        const std::span<const Pose> planned = contact_solver.predicted();
        const double gap = impact_gap(contact, {bodies.pose[a], bodies.pose[b]}, {planned[a], planned[b]}, touch_gap(settings));
        const double approach = (contact.at.gap - gap) / interval;
        if (std::abs(gap) <= 0.5 * touch_gap(settings) || approach <= 0.0) {
            return good;
        }
        interval = std::clamp(interval + gap / approach, std::max(0.5 * interval, shortest), longest);
    }
    return plan_interval(report);
}

/// One solve over `interval`, checked by the shapes at the planned poses. Returns false if it did not converge.
bool WorldState::plan_interval(StepReport& report) {
    StepSettings used = settings;
    used.impacts = stops_at_impacts() ? ImpactHandling::stop : ImpactHandling::ahead;
    used.iteration_limit = static_cast<int>(
        std::min<std::int64_t>(used.iteration_limit, std::max<std::int64_t>(work_left(), sweeps_to_arrange)));
    repair.begin(interval, stops_at_impacts());
    contact_solver.prepare(bodies, search.pairs, joints, used, interval);
    bool good = false;
    for (int round = 1;; ++round) {
        const ContactSolveReport result = contact_solver.solve(bodies, search.pairs, joints);
        report.contact_iterations += result.iterations;
        work_done += result.iterations + sweeps_to_arrange;
        report.residual = result.residual;
        report.joint_gap = contact_solver.joint_gap();
        // Contacts give no energy, or the plan is wrong: what an impact turns far touches elsewhere as the interval ends than as it began.
        const bool is_followed = result.converged && energy.allows(result.work, bodies, after_collisions, energy_in_springs());
        good = repair.verify() && is_followed;
        if (!is_followed || round == most_rounds || work_left() == 0 || !repair.repair(after_collisions)) {
            break;
        }
    }
    report.contacts = contact_solver.contact_count();
    report.joints = static_cast<int>(joints.size());
    return good;
}

} // namespace sim
