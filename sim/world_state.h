#pragma once
/// What a World holds, and its stages: world.cpp has the step, world_contacts.cpp the search for contacts.
#include "sim/box_axes.h"
#include "sim/broad_phase.h"
#include "sim/collision_solver.h"
#include "sim/contact_solver.h"
#include "sim/snapshot.h"
#include "sim/step_report.h"
#include "sim/time_of_impact.h"
#include "sim/workers.h"

#include <chrono>
#include <optional>
#include <string>
#include <utility>

namespace sim {

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

/// The state at one instant, and the impulses already found that carry it over the next interval.
///
/// An instant holds the velocity before its resting impulses, `bodies.velocity`, and after them,
/// solver.velocity(). The velocity *at* the instant lies between them (Verlet): that is what a snapshot
/// reports, so positions and velocities are both second order without another solve.
struct WorldState {
    WorldState(const SceneDef& scene, int threads);

    StepReport step();
    void move(StepReport& report);
    void find_candidates();
    /// Bodies that may touch in the step.
    struct NearPair {
        std::size_t candidate = 0;
        double margin = 0.0; ///< [m] see margin_of
    };
    void find_pair_contacts(const NearPair& of, std::vector<Contact>& contacts, PairContacts& pair) const;
    void update_axes(std::span<const Pose> poses, std::vector<char>& moved);
    bool is_far_from_plane(const BodyPair& pair) const;
    bool are_boxes(const BodyPair& pair) const;
    void check_pairs();
    void replace_contacts(std::size_t index, const std::vector<Contact>& contacts);
    void put_back_replaced();
    void find_contacts(StepReport& report);
    void resolve_collisions(StepReport& report);
    void restart(std::span<const char> touched);
    double intervals_for_spin() const;
    double intervals_for_joints() const;
    void check_mass_ratios(const char* stage) const;
    void plan(StepReport& report);
    bool plan_until_impact(const Impact& impact, StepReport& report);
    bool plan_interval(StepReport& report);
    int repair();
    std::optional<double> overlap_time() const;
    bool stops_at_impacts() const;
    void stop_at_impact(StepReport& report, bool& good);
    double interval_left() const { return h * (1.0 - progress); }
    double margin_of(int a, int b) const;
    double reach_of(const BodyPair& pair) const;
    std::size_t pair_index(const BodyPair& pair) const;
    std::vector<PairContacts> known_pairs();
    Snapshot take_snapshot(ContactDetail contacts) const;

    std::vector<std::string> names;
    std::size_t reported_count = 0; ///< bodies of the scene; the world itself comes after them
    StepSettings settings;
    double h = 0.0;
    bool begun_at_limit = false; ///< the plan made before the first step did not converge: reported with that step
    std::int64_t step_index = 0;
    double progress = 0.0;                ///< [-] 0..1, of the step under way
    double interval = 0.0;                ///< [s] planned next
    std::vector<Pose> checked_pose;       ///< planned poses when a body's pairs were last looked at
    bool check_all = true;                ///< they have not been looked at in this plan
    std::vector<double> pair_penetration; ///< [candidates] then [m]
    std::vector<char> is_box;             ///< [reported_count] a single box, not a part of a compound
    std::vector<PlacedBoxRow> box_rows;   ///< [reported_count]
    std::vector<BoxAxes> axes;            ///< [candidates] of pairs of boxes
    std::vector<Pose> box_pose;           ///< [reported_count] at which the axes of a body's pairs were found
    bool axes_known = false;              ///< they are those of the present candidates
    std::vector<BodyPair> meeting;        ///< apart now, overlapping at the planned poses
    double verified_penetration = 0.0;    ///< [m] at the planned poses
    double joint_rate = 0.0;              ///< [rad/s] of joints under the load of the interval planned
    int stops = 0;                        ///< in the step under way
    bool stopped_at_impact = false;       ///< the interval planned ends at one

    Bodies bodies;
    std::vector<Velocity> at_node; ///< [body_count] velocities at the instant, after its collisions
    std::vector<Joint> joints;
    std::vector<BodyPair> jointed; ///< ascending: pairs that do not collide
    std::vector<JointMemory> joint_memory;
    JointSolver joint_rows; ///< at the present poses, for what the last impulses owe
    BroadPhase broad_phase;
    std::vector<double> reach; ///< [m] that each body may move in the step
    std::vector<double> rim_speed; ///< [m/s] of its outermost point by its rotation
    std::vector<Pose> searched_pose;    ///< when the candidates were searched for
    std::vector<double> searched_reach; ///< [m] that each body may be away from there
    std::vector<Bounds> boxes;
    std::vector<BodyPair> candidates;
    std::vector<NearPair> near;
    std::vector<PairContacts> pairs; ///< those with contacts, ascending; then those that repair added
    std::size_t sorted_pairs = 0;    ///< length of the ascending part
    std::vector<std::pair<std::size_t, PairContacts>> replaced; ///< by repair: index into pairs, and what was found there
    Workers workers;                 ///< for what is done pair by pair
    ContactSolver contact_solver;
    CollisionSolver collision_solver;
    std::vector<ContactSnapshot> impacts; ///< kept since they were last asked for
};

} // namespace sim
