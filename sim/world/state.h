#pragma once
/// What a World holds, and the stages of its step.
#include "sim/base/step_report.h"
#include "sim/base/workers.h"
#include "sim/model/snapshot.h"
#include "sim/solve/collision_solver.h"
#include "sim/solve/half_kicks.h"
#include "sim/solve/time_of_impact.h"
#include "sim/world/energy.h"
#include "sim/world/repair.h"

#include <chrono>
#include <string>

namespace sim {

/// All solves of a step together have the sweeps of this many [-] at their limit.
inline constexpr int most_solves = 10;

/// World frame, at the present poses.
void find_inverse_inertia(Bodies& bodies);

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

/// A body to be released.
struct Waiting {
    std::size_t body;
    double release;      ///< [s]
    double inverse_mass; ///< [1/kg] from then on
};

/// The state at one instant, and the impulses already found that carry it over the next interval.
///
/// An instant holds the velocity before its resting impulses, `bodies.velocity`, and after them,
/// contact_solver.velocity(). The velocity *at* the instant lies between them (Verlet): that is what a snapshot
/// reports, so positions and velocities are both second order without another solve.
struct WorldState {
    /// As the scene's text has it: begin() or resume() is next.
    WorldState(const SceneDef& scene, int threads);

    void begin();
    void resume();
    StepReport step();
    double time() const;
    void move(StepReport& report);
    void let_wait(const SceneDef& scene);
    std::vector<std::size_t> take_due();
    std::vector<std::size_t> release();
    void check_places_of(std::span<const std::size_t> released) const;
    void find_contacts(StepReport& report);
    void resolve_collisions(StepReport& report);
    void restart(std::span<const char> touched);
    void check_joints() const;
    double intervals_for_spin();
    double intervals_for_joints() const;
    double parts_of_plan_for_joints(int divisions) const;
    void plan(StepReport& report);
    bool plan_interval(StepReport& report);
    bool plan_until_impact(const Impact& impact, StepReport& report);
    void stop_at_impact(StepReport& report, bool& good);
    bool stops_at_impacts() const;
    std::int64_t work_left() const;
    void fall_short(StepReport& report, const Unsettled& unsettled) const;
    double energy_in_springs() const;
    double interval_left() const { return h * (1.0 - progress); }
    Snapshot take_snapshot(ContactDetail contacts) const;

    std::vector<std::string> names;
    std::size_t reported_count = 0; ///< bodies of the scene; the world itself comes after them
    StepSettings settings;
    double h = 0.0;
    Bodies bodies;
    std::vector<Joint> joints;
    bool has_drives = false; ///< kinematic bodies or motors
    std::vector<Waiting> waiting; ///< the next one last
    Workers workers; ///< for what is done pair by pair
    ContactSearch search;
    ContactSolver contact_solver;
    Repair repair;
    CollisionSolver collision_solver{contact_solver.blocks(), contact_solver.joints()};
    EnergyWatch energy;
    std::vector<ContactSnapshot> impacts; ///< kept since they were last asked for

    std::int64_t step_index = 0;
    double progress = 0.0;          ///< [-] 0..1, of the step under way
    double interval = 0.0;          ///< [s] planned next
    int divided = 0;                ///< times by two [-] until it could be
    bool stopped_at_impact = false; ///< that ends at one
    bool begun_at_limit = false;    ///< the plan made before the first step did not converge: reported with that step
    double joint_rate = 0.0;        ///< [rad/s] of joints under the load of the interval planned; see ContactSolver::joint_rate()
    std::int64_t work_done = 0;     ///< [sweeps] in the step under way
    bool gives_way = false;         ///< what contacts ask for, in the step under way: see Blocks::softness()
    std::vector<Velocity> after_collisions;     ///< [body_count] velocities at the instant, without what it plans
    std::vector<int> connected;                 ///< [body_count] bodies that the loads planned connect, each by the first of them
    std::span<const Velocity> velocity_at_node; ///< [body_count] with the half of the impulses planned
};

} // namespace sim
