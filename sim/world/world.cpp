#include "sim/world/world.h"

#include "sim/base/disjoint_sets.h"
#include "sim/base/error.h"
#include "sim/model/integrate.h"
#include "sim/scene/bounds.h"
#include "sim/scene/model.h"
#include "sim/world/contact_view.h"
#include "sim/world/state.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace sim {
namespace {

/// Where an impact stops the step, contacts with a gap up to this share [-] of the tolerance are part of it.
constexpr double simultaneous_share = 0.1;

/// At t = 0. Behind those of the scene the world, for joints that hold a body in it; the search does not see it.
Bodies all_bodies(const SceneDef& scene) {
    Bodies bodies;
    const std::size_t count = scene.bodies.size() + 1;
    bodies.props.reserve(count);
    bodies.pose.reserve(count);
    bodies.velocity.reserve(count);
    bodies.inverse_inertia.reserve(count);
    for (const BodyDef& body : scene.bodies) {
        bodies.props.push_back(make_body_props(body));
        bodies.pose.push_back({body.pose.position, body.pose.orientation.normalized()});
        bodies.velocity.push_back(body.is_fixed() ? Velocity{} : Velocity{body.velocity, body.angular_velocity});
        if (body.is_kinematic()) {
            bodies.kinematic.push_back({bodies.props.size() - 1, body.motion});
        }
    }
    bodies.props.emplace_back();
    bodies.pose.emplace_back();
    bodies.velocity.emplace_back();
    find_inverse_inertia(bodies);
    return bodies;
}

std::vector<Joint> all_joints(const SceneDef& scene, const Bodies& bodies) {
    std::vector<Joint> joints;
    for (const JointDef& joint : scene.joints) {
        joints.push_back(make_joint(joint, bodies.pose, static_cast<int>(bodies.props.size()) - 1));
    }
    return joints;
}

/// BodyProps::is_led: what joints connect, not by way of what is fixed.
void mark_led(Bodies& bodies, std::span<const Joint> joints) {
    const auto props_of = [&](int body) -> BodyProps& { return bodies.props[static_cast<std::size_t>(body)]; };
    std::vector<int> first = sets_of_one(bodies.props.size());
    for (const Joint& joint : joints) {
        if (!props_of(joint.a).is_fixed() && !props_of(joint.b).is_fixed()) {
            unite(first, joint.a, joint.b);
        }
    }
    find_firsts(first);
    for (const KinematicBody& body : bodies.kinematic) {
        props_of(first[body.index]).is_led = true;
    }
    for (std::size_t i = 0; i < first.size(); ++i) {
        bodies.props[i].is_led = props_of(first[i]).is_led;
    }
}

/// Ascending.
std::vector<BodyPair> jointed_pairs(std::span<const Joint> joints) {
    std::vector<BodyPair> pairs;
    for (const Joint& joint : joints) {
        pairs.push_back({std::min(joint.a, joint.b), std::max(joint.a, joint.b)});
    }
    std::ranges::sort(pairs);
    return pairs;
}

/// An impact changes the loads of all bodies that loads connect with it. What acted before the instant is the last interval's
/// for each of their contacts alike, or bodies between two contacts would be told a velocity that they never have.
void touch_connected(std::span<const int> connected, std::span<char> touched) {
    std::vector<char> is_reached(touched.size());
    for (std::size_t i = 0; i < touched.size(); ++i) {
        is_reached[static_cast<std::size_t>(connected[i])] |= touched[i];
    }
    for (std::size_t i = 0; i < touched.size(); ++i) {
        touched[i] = is_reached[static_cast<std::size_t>(connected[i])];
    }
}

} // namespace

void find_inverse_inertia(Bodies& bodies) {
    bodies.inverse_inertia.clear();
    for (std::size_t i = 0; i < bodies.props.size(); ++i) {
        bodies.inverse_inertia.push_back(inverse_inertia_world(bodies.props[i], bodies.pose[i].orientation));
    }
}

WorldState::WorldState(const SceneDef& scene, int threads)
    : reported_count(scene.bodies.size()), settings(scene.step), h(scene.step.time_step.value()), bodies(all_bodies(scene)),
      joints(all_joints(scene, bodies)), workers(threads),
      search(bodies, reported_count, settings, jointed_pairs(joints), workers),
      repair(bodies, settings, search, contact_solver) {
    for (const BodyDef& body : scene.bodies) {
        names.push_back(body.name);
    }
    mark_led(bodies, joints);
    const auto has_motor = [](const Joint& joint) { return joint.motor.has_value(); };
    let_wait(scene); // the search has seen all bodies as what they will be
    connected = sets_of_one(bodies.props.size());
    has_drives = !bodies.kinematic.empty() || std::ranges::any_of(joints, has_motor);
    settings.impacts = impact_handling(scene);
    contact_solver.set_workers(&workers);
}

/// Contacts and plan of the first step.
void WorldState::begin() {
    StepReport report;
    find_contacts(report);
    resolve_collisions(report);
    plan(report);
    begun_at_limit = report.at_iteration_limit;
    velocity_at_node = contact_solver.velocity_at_node();
    energy.start(bodies, velocity_at_node, settings, energy_in_springs());
}

double WorldState::energy_in_springs() const {
    double sum = 0.0;
    for (const Joint& joint : joints) {
        sum += spring_energy(joint, settings.joint_tolerance);
    }
    return sum;
}

StepReport WorldState::step() {
    StepReport report;
    report.at_iteration_limit = std::exchange(begun_at_limit, false);
    work_done = 0;
    progress = 0.0;
    contact_solver.may_give_way = std::exchange(gives_way, false);
    double cubes = 0.0; // [s^3] of the intervals
    do {
        cubes += std::pow(interval, 3);
        move(report);
        const std::vector<std::size_t> released = release();
        find_contacts(report);
        check_places_of(released);
        resolve_collisions(report);
        plan(report);
    } while (progress < 1.0);
    report.interval = std::sqrt(cubes / h);
    velocity_at_node = contact_solver.velocity_at_node();
    report.energy_gain = energy.gain(bodies, velocity_at_node, energy_in_springs());
    return report;
}

double WorldState::time() const {
    return static_cast<double>(step_index * settings.time_step.num) / static_cast<double>(settings.time_step.den);
}

/// Moves all bodies over the planned interval; the impulses for it have been found.
void WorldState::move(StepReport& report) {
    const StageClock clock(report, Stage::integrate);
    const std::span<const Velocity> after_impulses = contact_solver.velocity();
    const std::span<const Pose> planned = contact_solver.predicted();
    const auto is_finite = [&](std::size_t i) {
        return std::isfinite(bodies.pose[i].position.sum() + bodies.pose[i].orientation.coeffs().sum() +
                             bodies.velocity[i].v.sum() + bodies.velocity[i].w.sum());
    };
    std::atomic<bool> are_finite = true;
    const auto move_some = [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            if (bodies.props[i].is_static()) {
                continue;
            }
            bodies.velocity[i] = velocity_after(bodies.props[i], bodies.pose[i], planned[i], after_impulses[i],
                                                interval * settings.gravity);
            bodies.pose[i] = planned[i];
            bodies.inverse_inertia[i] = inverse_inertia_world(bodies.props[i], bodies.pose[i].orientation);
            if (!is_finite(i)) {
                are_finite = false;
            }
        }
    };
    workers.run(bodies.props.size(), move_some, least_shared);
    if (!are_finite) {
        std::size_t i = 0;
        while (is_finite(i)) {
            ++i;
        }
        throw Error(ExitCode::stopped, fmt::format("body '{}' has left the range of numbers in step {} (integrate)",
                                                   names[i], step_index));
    }
    search.candidates.move(interval);
    report.max_penetration = std::max(report.max_penetration, repair.verified_penetration);
    progress = interval >= interval_left() ? 1.0 : progress + interval / h;
    if (progress == 1.0) {
        ++step_index;
    }
    bodies.time = progress == 1.0 ? time() : bodies.time + interval;
    for (const KinematicBody& body : bodies.kinematic) {
        bodies.pose[body.index] = body.motion.pose_at(bodies.time);
        bodies.velocity[body.index] = body.motion.velocity_at(bodies.time);
    }
}

void WorldState::find_contacts(StepReport& report) {
    {
        const StageClock clock(report, Stage::broad_phase);
        search.candidates.find();
    }
    const StageClock clock(report, Stage::narrow_phase);
    search.find();
    report.pairs = static_cast<int>(search.candidates.all().size());
    report.manifolds = static_cast<int>(search.pairs.size());
}

/// Collisions act on the velocities of the instant: those before the resting impulses plus what they lack. The bodies of a
/// collision, and all that loads connect with them, keep that velocity, and their motion restarts there.
void WorldState::resolve_collisions(StepReport& report) {
    const StageClock clock(report, Stage::collisions);
    after_collisions = bodies.velocity;
    JointSolver& joint_rows = contact_solver.joints(); // for what the last impulses owe, then for collisions
    joint_rows.prepare(bodies, joints);
    apply_half_kicks(bodies, connected, search.pairs, joint_rows, after_collisions);
    const std::vector<Velocity> before = has_drives ? after_collisions : std::vector<Velocity>();
    collision_solver.simultaneous_gap = stopped_at_impact ? simultaneous_share * settings.tolerance : 0.0;
    collision_solver.lost = contact_solver.energy_lost();
    collision_solver.may_give_way = contact_solver.may_give_way;
    collision_solver.most_sweeps = work_left() / 2; // the plan has to come to an end, or it throws what it holds
    CollisionReport result = collision_solver.resolve(bodies, search.pairs, settings, after_collisions);
    std::vector<char>& touched = result.touched;
    energy.add_work(result.drive_work);
    work_done += result.iterations + sweeps_to_arrange * result.passes;
    if (result.collisions > 0) {
        touch_connected(connected, touched);
        if (has_drives) {
            const std::vector<Velocity> kinematic = kinematic_velocity(bodies);
            energy.add_work(half_kick_work(bodies, search.pairs, touched, kinematic) +
                            joint_rows.half_kick_work(kinematic, {bodies.velocity, {}, before}, touched));
        }
        for (std::size_t i = 0; i < after_collisions.size(); ++i) {
            if (touched[i] != 0) {
                bodies.velocity[i] = after_collisions[i];
            }
        }
        restart(touched);
    }
    report.collisions += result.collisions;
    report.collision_passes += result.passes;
    report.collision_iterations += result.iterations;
    if (!result.converged) {
        fall_short(report, result.unsettled);
    }
}

/// The velocities of these bodies' contacts and joints lack nothing now.
void WorldState::restart(std::span<const char> touched) {
    const auto is_touched = [&](int a, int b) {
        return touched[static_cast<std::size_t>(a)] != 0 || touched[static_cast<std::size_t>(b)] != 0;
    };
    const auto restart_some = [&](std::size_t first, std::size_t last) {
        for (PairContacts& pair : std::span(search.pairs).subspan(first, last - first)) {
            if (!is_touched(pair.manifold.body_a, pair.manifold.body_b)) {
                continue;
            }
            for (Contact& contact : pair.manifold.contacts) {
                contact.memory.last_interval = 0.0;
            }
            pair.owed_impulse.setZero();
            pair.owed_moment.setZero();
            pair.is_struck = true;
        }
    };
    workers.run(search.pairs.size(), restart_some, least_shared);
    for (std::size_t i = 0; i < joints.size(); ++i) {
        if (is_touched(joints[i].a, joints[i].b)) {
            joints[i].memory.last_interval = 0.0;
            joints[i].memory.spring_owed = joints[i].memory.motor_owed = 0.0;
        }
    }
}

Snapshot WorldState::take_snapshot(ContactDetail contacts) const {
    Snapshot snapshot;
    snapshot.step = step_index;
    snapshot.time = time();
    for (std::size_t i = 0; i < reported_count; ++i) {
        snapshot.bodies.push_back({bodies.pose[i].position, bodies.pose[i].orientation, velocity_at_node[i].v,
                                   velocity_at_node[i].w});
    }
    if (contacts != ContactDetail::none) {
        snapshot.contacts = loaded_contacts(search.pairs, h);
        snapshot.contact_count = static_cast<std::int64_t>(snapshot.contacts.size());
        if (contacts == ContactDetail::count) {
            snapshot.contacts.clear();
        }
    }
    return snapshot;
}

World::World(const SceneDef& scene, int threads) : World(std::make_unique<WorldState>(scene, threads)) {
    state_->begin();
}
World::World(std::unique_ptr<WorldState> state) : state_(std::move(state)) {}
World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

StepReport World::step() {
    return state_->step();
}
std::int64_t World::step_index() const {
    return state_->step_index;
}
double World::time() const {
    return state_->time();
}
Snapshot World::take_snapshot(ContactDetail contacts) const {
    return state_->take_snapshot(contacts);
}
void World::record_impacts() {
    state_->collision_solver.impacts = &state_->impacts;
}
std::vector<ContactSnapshot> World::take_impacts() {
    return std::exchange(state_->impacts, {});
}

} // namespace sim
