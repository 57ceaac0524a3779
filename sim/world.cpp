#include "sim/world.h"

#include "sim/broad_phase.h"
#include "sim/collision_solver.h"
#include "sim/error.h"
#include "sim/integrate.h"
#include "sim/narrow_phase.h"
#include "sim/time_of_impact.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace sim {
namespace {

/// Times the step may be divided by two when its contacts do not converge: down to h / 2^6.
constexpr int division_limit = 6;

/// A body in contact turns by at most this angle [rad] in one interval; the step is divided for it.
constexpr double largest_turn = 0.5;

/// Impacts at which one step may be stopped before the rest of it holds contacts ahead (a ball coming to rest
/// bounces infinitely often).
constexpr int stop_limit = 200;

/// Intervals are no shorter than this share [-] of a step: an impact so near its beginning or end falls on
/// it.
constexpr double shortest_interval = 1e-9;

/// Corrections of the time of an impact: each gains several digits.
constexpr int impact_corrections = 6;

/// Rounds of check and repair after the move before the step is divided. In the first ones the contacts found
/// after the move replace those of the pair; later they are added, lest two sets take turns.
constexpr int repair_limit = 8;
constexpr int replace_rounds = 8;

/// A body that moves beyond what its pairs were searched for is searched again with this much [-] to spare.
constexpr double reach_growth = 1.5;

/// Pairs are looked at again in a later round of repair where a body moved by more than this share [-] of the
/// tolerance.
constexpr double recheck_share = 0.02;

/// Contacts are looked for this many tolerances beyond what the bodies can approach in the step.
constexpr double margin_tolerances = 2.0;

/// A contact whose features changed is taken for the one that was within this share [-] of the body's size.
constexpr double match_reach = 1e-2;

/// Adds the wall time since its construction to one stage.
class StageClock {
public:
    StageClock(StepReport& report, Stage stage) : ms_(report.stage_ms[static_cast<std::size_t>(stage)]) {}
    ~StageClock() {
        ms_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
    }
    StageClock(const StageClock&) = delete;
    StageClock& operator=(const StageClock&) = delete;

private:
    double& ms_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// How far a point of the body moves between two poses, at most [m].
double moved_by(const BodyProps& props, const Pose& from, const Pose& to) {
    if (props.is_static()) {
        return 0.0;
    }
    const double turn = 2.0 * (to.orientation * from.orientation.conjugate()).vec().norm();
    return (to.position - from.position).norm() + turn * props.bounding_radius;
}

/// A contact found at the planned poses, as it is at t0: the same material points and the same normal. The
/// impulse acts at t0, but along the normal that the bodies will have where they meet.
ContactGeometry moved_back(const ContactGeometry& at, const Pose& planned_a, const Pose& planned_b,
                           const Pose& a, const Pose& b) {
    ContactGeometry before;
    before.n = at.n;
    before.a = a * (planned_a.orientation.conjugate() * (at.a - planned_a.position));
    before.b = b * (planned_b.orientation.conjugate() * (at.b - planned_b.position));
    before.gap = at.n.dot(before.a - before.b);
    return before;
}

} // namespace

/// The state at one instant, and the impulses already found that carry it over the next interval.
///
/// An instant holds the velocity before its resting impulses, `bodies.velocity`, and after them,
/// solver.velocity(). The velocity *at* the instant lies between them (Verlet): that is what a snapshot
/// reports, so positions and velocities are both second order without another solve.
struct World::Impl {
    explicit Impl(const SceneDef& scene);

    StepReport step();
    void move(StepReport& report);
    void find_candidates();
    void find_contacts(StepReport& report);
    void resolve_collisions(StepReport& report);
    void restart(std::span<const char> touched);
    double fastest_spin_in_contact() const;
    void plan(StepReport& report);
    void plan_until_impact(const Impact& impact, StepReport& report);
    bool plan_interval(StepReport& report);
    bool repair(bool replace);
    double interval_left() const { return h * (1.0 - progress); }
    double margin_of(int a, int b) const;
    double reach_of(const BodyPair& pair) const;
    std::size_t pair_index(const BodyPair& pair) const;
    Snapshot take_snapshot() const;

    std::vector<std::string> names;
    std::size_t reported_count = 0; ///< bodies of the scene; the world itself comes after them
    StepSettings settings;
    double h = 0.0;
    std::int64_t step_index = 0;
    double progress = 0.0;                ///< [-] 0..1, of the step under way
    double interval = 0.0;                ///< [s] planned next
    std::vector<Pose> checked_pose;       ///< planned poses when a body's pairs were last looked at
    bool check_all = true;                ///< they have not been looked at in this plan
    std::vector<double> pair_penetration; ///< [candidates] then [m]
    double verified_penetration = 0.0;    ///< [m] at the planned poses
    int stops = 0;                        ///< in the step under way

    Bodies bodies;
    std::vector<Joint> joints;
    std::vector<BodyPair> jointed; ///< ascending: pairs that do not collide
    std::vector<JointMemory> joint_memory;
    JointSolver joint_rows; ///< at the present poses, for what the last impulses owe
    BroadPhase broad_phase;
    std::vector<double> reach; ///< [m] that each body may move in the step
    std::vector<Bounds> boxes;
    std::vector<BodyPair> candidates;
    std::vector<PairContacts> pairs; ///< those with contacts, ascending; then those that repair added
    std::size_t sorted_pairs = 0;    ///< length of the ascending part
    ContactSolver contact_solver;
    CollisionSolver collision_solver;
};

namespace {

std::vector<BodyProps> all_props(const SceneDef& scene) {
    std::vector<BodyProps> props;
    for (const BodyDef& body : scene.bodies) {
        props.push_back(make_body_props(body));
    }
    props.emplace_back(); // the world, for joints that hold a body in it; the broad phase does not see it
    return props;
}

} // namespace

World::Impl::Impl(const SceneDef& scene)
    : reported_count(scene.bodies.size()), settings(scene.step),
      h(scene.step.time_step.value()), bodies{.props = all_props(scene),
                                              .pose = {},
                                              .velocity = {},
                                              .inverse_inertia = {}},
      broad_phase(std::span(bodies.props).first(reported_count)) {
    for (const BodyDef& body : scene.bodies) {
        names.push_back(body.name);
        bodies.pose.push_back({body.pose.position, body.pose.orientation.normalized()});
        bodies.velocity.push_back(body.is_static() ? Velocity{}
                                                   : Velocity{body.velocity, body.angular_velocity});
    }
    bodies.pose.emplace_back();
    bodies.velocity.emplace_back();
    const std::size_t count = bodies.props.size();
    bodies.inverse_inertia.assign(count, Mat3::Zero());
    for (const JointDef& joint : scene.joints) {
        joints.push_back(make_joint(joint, bodies.pose, static_cast<int>(count) - 1));
        jointed.push_back(
            {std::min(joints.back().a, joints.back().b), std::max(joints.back().a, joints.back().b)});
    }
    std::ranges::sort(jointed);
    joint_memory.resize(joints.size());
    for (std::size_t i = 0; i < count; ++i) {
        bodies.inverse_inertia[i] = inverse_inertia_world(bodies.props[i], bodies.pose[i].orientation);
    }
    StepReport report;
    find_contacts(report);
    resolve_collisions(report);
    plan(report);
}

StepReport World::Impl::step() {
    StepReport report;
    stops = 0;
    progress = 0.0;
    do {
        move(report);
        find_contacts(report);
        resolve_collisions(report);
        plan(report);
    } while (progress < 1.0);
    return report;
}

/// Moves all bodies over the planned interval; the impulses for it have been found.
void World::Impl::move(StepReport& report) {
    const StageClock clock(report, Stage::integrate);
    const std::span<const Velocity> after_impulses = contact_solver.velocity();
    const std::span<const Pose> planned = contact_solver.predicted();
    for (std::size_t i = 0; i < bodies.props.size(); ++i) {
        if (bodies.props[i].is_static()) {
            continue;
        }
        bodies.velocity[i] = velocity_after(bodies.props[i], bodies.pose[i], planned[i], after_impulses[i],
                                            settings.gravity, interval);
        bodies.pose[i] = planned[i];
        const double sum = bodies.pose[i].position.sum() + bodies.pose[i].orientation.coeffs().sum() +
                           bodies.velocity[i].v.sum() + bodies.velocity[i].w.sum();
        if (!std::isfinite(sum)) {
            throw Error(ExitCode::stopped,
                        fmt::format("body '{}' has left the range of numbers in step {} (integrate)",
                                    names[i], step_index));
        }
        bodies.inverse_inertia[i] = inverse_inertia_world(bodies.props[i], bodies.pose[i].orientation);
    }
    report.max_penetration = std::max(report.max_penetration, verified_penetration);
    progress = interval >= interval_left() ? 1.0 : progress + interval / h;
    if (progress == 1.0) {
        ++step_index;
    }
}

/// How near two bodies may be and still touch within the step [m].
double World::Impl::margin_of(int a, int b) const {
    const auto ia = static_cast<std::size_t>(a);
    const auto ib = static_cast<std::size_t>(b);
    const auto turning = [&](std::size_t i) {
        return bodies.props[i].is_static() ? 0.0
                                           : bodies.velocity[i].w.norm() * bodies.props[i].bounding_radius;
    };
    const double approach =
        (bodies.velocity[ia].v - bodies.velocity[ib].v).norm() + turning(ia) + turning(ib);
    return h * (approach + h * settings.gravity.norm()) + margin_tolerances * settings.tolerance;
}

/// How far a contact may have moved on its bodies and still be the same one [m].
double World::Impl::reach_of(const BodyPair& pair) const {
    return match_reach * std::min(bodies.props[static_cast<std::size_t>(pair.a)].bounding_radius,
                                  bodies.props[static_cast<std::size_t>(pair.b)].bounding_radius);
}

/// Index of a pair in `pairs`; pairs.size() if it has no contacts.
std::size_t World::Impl::pair_index(const BodyPair& pair) const {
    const auto key = [](const PairContacts& p) { return BodyPair{p.manifold.body_a, p.manifold.body_b}; };
    const auto sorted_end = pairs.begin() + static_cast<std::ptrdiff_t>(sorted_pairs);
    const auto place = std::ranges::lower_bound(pairs.begin(), sorted_end, pair, {}, key);
    if (place != sorted_end && key(*place) == pair) {
        return static_cast<std::size_t>(place - pairs.begin());
    }
    const auto added = std::ranges::find(sorted_end, pairs.end(), pair, key);
    return static_cast<std::size_t>(added - pairs.begin());
}

/// Pairs of bodies that may touch while each moves by up to its `reach`.
void World::Impl::find_candidates() {
    boxes.resize(reported_count);
    for (std::size_t i = 0; i < reported_count; ++i) {
        boxes[i] = bounds(bodies.props[i].shape, bodies.pose[i]);
        const Vec3 margin = Vec3::Constant(reach[i] + 0.5 * margin_tolerances * settings.tolerance);
        boxes[i].lower -= margin;
        boxes[i].upper += margin;
    }
    broad_phase.find_pairs(boxes, candidates);
    std::erase_if(candidates,
                  [&](const BodyPair& pair) { return std::ranges::binary_search(jointed, pair); });
    check_all = true;
}

void World::Impl::find_contacts(StepReport& report) {
    {
        const StageClock clock(report, Stage::broad_phase);
        reach.resize(reported_count);
        for (std::size_t i = 0; i < reported_count; ++i) {
            const Velocity& velocity = bodies.velocity[i];
            const double speed = velocity.v.norm() + velocity.w.norm() * bodies.props[i].bounding_radius;
            reach[i] = bodies.props[i].is_static() ? 0.0 : h * (speed + h * settings.gravity.norm());
        }
        find_candidates();
    }
    const StageClock clock(report, Stage::narrow_phase);
    std::vector<PairContacts> found;
    for (const BodyPair& candidate : candidates) {
        const auto a = static_cast<std::size_t>(candidate.a);
        const auto b = static_cast<std::size_t>(candidate.b);
        PairContacts pair;
        sim::find_contacts(bodies.props[a].shape, bodies.pose[a], bodies.props[b].shape, bodies.pose[b],
                           margin_of(candidate.a, candidate.b), pair.manifold.contacts);
        if (pair.manifold.contacts.empty()) {
            continue;
        }
        pair.manifold.body_a = candidate.a;
        pair.manifold.body_b = candidate.b;
        pair.material = pair_material(bodies.props[a], bodies.props[b]);
        const std::size_t old = pair_index(candidate);
        match_memory(old < pairs.size() ? pairs[old].memory : std::vector<ContactMemory>{}, pair,
                     reach_of(candidate));
        found.push_back(std::move(pair));
    }
    pairs = std::move(found);
    sorted_pairs = pairs.size();
    report.pairs = static_cast<int>(candidates.size());
    report.manifolds = static_cast<int>(pairs.size());
}

/// Collisions act on the velocities of the instant: those before the resting impulses plus what they lack. A
/// body in a collision keeps that velocity, and its motion restarts there.
void World::Impl::resolve_collisions(StepReport& report) {
    const StageClock clock(report, Stage::collisions);
    std::vector<Velocity> velocity = bodies.velocity;
    joint_rows.prepare(bodies, joints);
    joint_rows.pay(joint_memory, {}, velocity);
    pay_contacts(bodies, pairs, {}, velocity);
    const std::vector<Velocity> before = velocity;
    std::vector<char> touched;
    const CollisionReport result =
        collision_solver.resolve(bodies, pairs, joints, settings, velocity, touched);
    if (result.collisions > 0) {
        joint_rows.pay(joint_memory, touched, bodies.velocity);
        pay_contacts(bodies, pairs, touched, bodies.velocity);
        for (std::size_t i = 0; i < velocity.size(); ++i) {
            bodies.velocity[i].v += velocity[i].v - before[i].v;
            bodies.velocity[i].w += velocity[i].w - before[i].w;
        }
        restart(touched);
    }
    report.collisions += result.collisions;
    report.collision_passes += result.passes;
    report.collision_iterations += result.iterations;
    report.at_iteration_limit = report.at_iteration_limit || !result.converged;
}

/// The velocities of these bodies' contacts and joints lack nothing now.
void World::Impl::restart(std::span<const char> touched) {
    const auto is_touched = [&](int a, int b) {
        return touched[static_cast<std::size_t>(a)] != 0 || touched[static_cast<std::size_t>(b)] != 0;
    };
    for (PairContacts& pair : pairs) {
        if (is_touched(pair.manifold.body_a, pair.manifold.body_b)) {
            for (ContactMemory& memory : pair.memory) {
                memory.owed = 0.0;
                memory.last_interval = 0.0;
            }
        }
    }
    for (std::size_t i = 0; i < joints.size(); ++i) {
        if (is_touched(joints[i].a, joints[i].b)) {
            joint_memory[i].owed = 0.0;
            joint_memory[i].last_interval = 0.0;
        }
    }
}

/// Largest |w| [rad/s] of a body near contact whose contact points move in the body as it turns: all but
/// balls.
double World::Impl::fastest_spin_in_contact() const {
    double fastest = 0.0;
    for (const PairContacts& pair : pairs) {
        for (const int body : {pair.manifold.body_a, pair.manifold.body_b}) {
            const auto i = static_cast<std::size_t>(body);
            if (!std::holds_alternative<Sphere>(bodies.props[i].shape)) {
                fastest = std::max(fastest, bodies.velocity[i].w.norm());
            }
        }
    }
    return fastest;
}

/// Finds the impulses of the next interval: the rest of the step, or all of the next one; shorter if an
/// impact stops it or if its contacts do not converge.
void World::Impl::plan(StepReport& report) {
    const StageClock clock(report, Stage::contacts);
    interval = progress < 1.0 ? interval_left() : h;
    const double spin = fastest_spin_in_contact();
    while (spin * interval > largest_turn) {
        interval *= 0.5;
        ++report.divisions;
    }
    for (int division = 0;; ++division) {
        const bool good = plan_interval(report);
        if (settings.impacts == ImpactHandling::stop && stops < stop_limit) {
            const std::optional<Impact> impact =
                time_of_impact(bodies, contact_solver.velocity(), pairs, settings, interval);
            if (impact && impact->time < (1.0 - shortest_interval) * interval) {
                ++stops;
                ++report.impacts_stopped_at;
                plan_until_impact(*impact, report);
                break;
            }
        }
        if (good) {
            break;
        }
        if (division == division_limit) {
            report.at_iteration_limit = true;
            break;
        }
        ++report.divisions;
        interval *= 0.5;
    }
    contact_solver.remember(pairs, joint_memory);
}

/// Plans the interval that ends at an impact. Its end moves a little with the impulses of the shorter
/// interval, so the time is corrected until the gap at the planned poses is closed.
void World::Impl::plan_until_impact(const Impact& impact, StepReport& report) {
    const double longest = interval;
    const Contact contact = pairs[impact.pair].manifold.contacts[impact.contact];
    const auto a = static_cast<std::size_t>(pairs[impact.pair].manifold.body_a);
    const auto b = static_cast<std::size_t>(pairs[impact.pair].manifold.body_b);
    const double shortest = shortest_interval * h;
    interval = std::max(impact.time, shortest);
    for (int correction = 0; correction < impact_corrections; ++correction) {
        plan_interval(report);
        const std::span<const Pose> planned = contact_solver.predicted();
        const double gap = contact_geometry(contact.feature, planned[a], planned[b]).gap;
        const double approach = (contact.at.gap - gap) / interval;
        if (std::abs(gap) <= 0.5 * touch_gap(settings) || approach <= 0.0) {
            return;
        }
        interval = std::clamp(interval + gap / approach, std::max(0.5 * interval, shortest), longest);
    }
    plan_interval(report);
}

/// One solve over `interval`, checked on the geometry after the move. Returns false if it did not converge.
bool World::Impl::plan_interval(StepReport& report) {
    StepSettings used = settings;
    if (stops >= stop_limit) {
        used.impacts = ImpactHandling::ahead;
    }
    contact_solver.prepare(bodies, pairs, joints, joint_memory, used, interval);
    check_all = true;
    bool good = false;
    for (int round = 0; round < repair_limit && !good; ++round) {
        const ContactSolveReport result = contact_solver.solve(bodies, pairs, joints);
        report.contact_iterations += result.iterations;
        report.residual = result.residual;
        good = repair(round < replace_rounds);
        if (!result.converged) {
            good = false;
            break;
        }
    }
    report.contacts = contact_solver.contact_count();
    report.joints = static_cast<int>(joints.size());
    return good;
}

/// Looks at all pairs again at the planned poses, by their shapes and not by the contacts of the solve. A
/// pair that would overlap by more than the tolerance gets the contacts found there. Returns true if there
/// was none.
bool World::Impl::repair(bool replace) {
    const std::span<const Pose> planned = contact_solver.predicted();
    verified_penetration = 0.0;
    // An impulse may throw a body farther than its velocity before told.
    bool farther = false;
    for (std::size_t i = 0; i < reported_count; ++i) {
        const double moved = moved_by(bodies.props[i], bodies.pose[i], planned[i]);
        if (moved > reach[i]) {
            reach[i] = reach_growth * moved;
            farther = true;
        }
    }
    if (farther) {
        find_candidates();
    }
    pair_penetration.resize(candidates.size());
    std::vector<char> moved(planned.size(), 1);
    if (!check_all) {
        for (std::size_t i = 0; i < reported_count; ++i) {
            moved[i] =
                moved_by(bodies.props[i], checked_pose[i], planned[i]) > recheck_share * settings.tolerance;
        }
    }
    checked_pose.resize(planned.size());
    for (std::size_t i = 0; i < planned.size(); ++i) {
        if (moved[i] != 0) {
            checked_pose[i] = planned[i];
        }
    }
    check_all = false;
    bool good = true;
    std::vector<Contact> contacts;
    std::vector<PairContacts> added;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        const BodyPair& candidate = candidates[k];
        const auto a = static_cast<std::size_t>(candidate.a);
        const auto b = static_cast<std::size_t>(candidate.b);
        double& penetration = pair_penetration[k];
        if (moved[a] != 0 || moved[b] != 0) {
            penetration = -separation(bodies.props[a].shape, planned[a], bodies.props[b].shape, planned[b]);
        }
        verified_penetration = std::max(verified_penetration, penetration);
        if (penetration <= settings.tolerance) {
            continue;
        }
        good = false;
        const std::size_t index = pair_index(candidate);
        const bool known = index < pairs.size();
        sim::find_contacts(bodies.props[a].shape, planned[a], bodies.props[b].shape, planned[b], 0.0,
                           contacts);
        for (Contact& contact : contacts) {
            contact.at = moved_back(contact.at, planned[a], planned[b], bodies.pose[a], bodies.pose[b]);
        }
        if (!known) {
            PairContacts fresh;
            fresh.manifold = {candidate.a, candidate.b, contacts};
            fresh.material = pair_material(bodies.props[a], bodies.props[b]);
            match_memory({}, fresh, 0.0);
            added.push_back(std::move(fresh));
            continue;
        }
        PairContacts& pair = pairs[index];
        std::size_t first = pair.manifold.contacts.size();
        if (replace) {
            contact_solver.drop_contacts(bodies, static_cast<int>(index));
            const std::vector<ContactMemory> memory = std::move(pair.memory);
            pair.manifold.contacts = contacts;
            match_memory(memory, pair, reach_of(candidate));
            first = 0;
        } else {
            for (const Contact& contact : contacts) {
                pair.manifold.contacts.push_back(contact);
                pair.memory.push_back({.id = contact.feature.id, .core_a = contact.feature.core_a});
            }
        }
        contact_solver.add_contacts(bodies, pairs, static_cast<int>(index), first);
    }
    for (PairContacts& pair : added) {
        pairs.push_back(std::move(pair));
        contact_solver.add_contacts(bodies, pairs, static_cast<int>(pairs.size()) - 1, 0);
    }
    return good;
}

Snapshot World::Impl::take_snapshot() const {
    Snapshot snapshot;
    snapshot.step = step_index;
    snapshot.time = static_cast<double>(step_index * settings.time_step.num) /
                    static_cast<double>(settings.time_step.den);
    const std::vector<Velocity> velocity = contact_solver.velocity_at_node(bodies);
    for (std::size_t i = 0; i < reported_count; ++i) {
        snapshot.bodies.push_back(
            {bodies.pose[i].position, bodies.pose[i].orientation, velocity[i].v, velocity[i].w});
    }
    return snapshot;
}

World::World(const SceneDef& scene, int threads) : impl_(std::make_unique<Impl>(scene)) {
    CHECK(threads >= 1);
}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

StepReport World::step() {
    return impl_->step();
}
std::int64_t World::step_index() const {
    return impl_->step_index;
}
double World::time() const {
    const Rational& h = impl_->settings.time_step;
    return static_cast<double>(impl_->step_index * h.num) / static_cast<double>(h.den);
}
Snapshot World::take_snapshot() const {
    return impl_->take_snapshot();
}

} // namespace sim
