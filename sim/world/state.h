#pragma once
/// What a World holds, and its stages: world.cpp has the step, candidates.cpp the search for pairs that may
/// touch, contacts.cpp that for their contacts.
#include "sim/base/step_report.h"
#include "sim/base/workers.h"
#include "sim/collide/box_axes.h"
#include "sim/collide/broad_phase.h"
#include "sim/model/snapshot.h"
#include "sim/solve/collision_solver.h"
#include "sim/solve/contact_solver.h"
#include "sim/solve/time_of_impact.h"
#include "sim/world/energy.h"

#include <chrono>
#include <limits>
#include <optional>
#include <string>
#include <utility>

namespace sim {

/// Contacts are looked for this many tolerances beyond what the bodies can approach in the step.
inline constexpr double margin_tolerances = 2.0;

/// How far a point of the body moves between two poses in a frame that moves by `drift` [m] meanwhile, at most [m].
double moved_by(const BodyProps& props, const Pose& from, const Pose& to, const Vec3& drift);

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
    /// As the scene's text has it: begin() or resume() is next.
    WorldState(const SceneDef& scene, int threads);

    void begin();
    void resume();
    StepReport step();
    void move(StepReport& report);
    Vec3 search_drift_in(double t) const;
    void find_reach();
    bool has_escaped(std::size_t i) const;
    bool have_many_escaped() const;
    void find_candidates();
    void find_all_candidates();
    void find_candidates_of_escaped();
    double search_reach(std::size_t i) const;
    void set_search_box(std::size_t i);
    Bounds searched_box(std::size_t i) const;
    void search();
    void add_candidates();
    /// Bodies that may touch in the step.
    struct NearPair {
        std::size_t candidate = 0;
        double margin = 0.0; ///< [m] see margin_of
    };
    void find_pair_contacts(const NearPair& of, std::vector<Contact>& contacts, PairContacts& pair);
    template <typename F>
    void place_boxes(std::span<const Pose> poses, F&& is_moved);
    void update_axes(std::size_t first, std::size_t last);
    void find_near();
    bool may_touch(const BodyPair& pair) const;
    bool are_boxes(const BodyPair& pair) const;
    double least_separation(const BodyPair& pair, std::size_t slot, const Pose& pose_a, const Pose& pose_b) const;
    void check_pairs();
    void replace_contacts(std::size_t index, const std::vector<Contact>& contacts);
    void put_back_replaced();
    void find_contacts(StepReport& report);
    void resolve_collisions(StepReport& report);
    void restart(std::span<const char> touched);
    double intervals_for_spin() const;
    double intervals_for_joints() const;
    void plan(StepReport& report);
    std::int64_t work_left() const;
    void fall_short(StepReport& report, const Unsettled& unsettled) const;
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
    void take_known_pairs(std::size_t first, std::size_t last, std::vector<PairContacts>& found);
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
    std::vector<double> pair_penetration; ///< [slots] then [m]
    std::vector<char> is_box;             ///< [reported_count] a single box, not a part of a compound
    std::vector<PlacedBoxRow> box_rows;   ///< [reported_count]
    std::vector<BoxAxes> axes;            ///< [slots] of pairs of boxes
    /// A separation [m] that was found, and at which poses.
    struct Separation {
        double distance = -std::numeric_limits<double>::infinity();
        Pose a;
        Pose b;
    };
    std::vector<Separation> separations;  ///< [slots] of other pairs, where the last look found them apart
    std::vector<Pose> box_pose;           ///< [reported_count] at which the axes of a body's pairs were found
    std::vector<BodyPair> meeting;        ///< apart now, overlapping at the planned poses
    double verified_penetration = 0.0;    ///< [m] at the planned poses
    double joint_rate = 0.0;              ///< [rad/s] of joints under the load of the interval planned
    std::int64_t work_done = 0;           ///< [sweeps] in the step under way
    int stops = 0;                        ///< in the step under way
    bool stopped_at_impact = false;       ///< the interval planned ends at one

    Bodies bodies;
    std::vector<Velocity> after_collisions;     ///< [body_count] velocities at the instant, without what it plans
    std::span<const Velocity> velocity_at_node; ///< [body_count] with the half of the impulses planned
    EnergyWatch energy;
    std::vector<Joint> joints;
    std::vector<BodyPair> jointed; ///< ascending: pairs that do not collide
    std::vector<JointMemory> joint_memory;
    JointSolver joint_rows; ///< at the present poses, for what the last impulses owe
    BroadPhase broad_phase;
    std::vector<double> reach; ///< [reported_count] that each body may move in the step, in the frame of the search [m]
    std::vector<double> rim_speed; ///< [m/s] of its outermost point by its rotation
    Vec3 search_frame = Vec3::Zero();   ///< [m/s] its velocity: that of bodies which fall together
    Vec3 search_drift = Vec3::Zero();   ///< [m] it went since then
    std::vector<Pose> searched_pose;    ///< in that frame, when each body's pairs were searched for
    std::vector<double> searched_reach; ///< [m] that each body may be away from there
    std::vector<int> escaped;           ///< bodies whose pairs have to be searched for again
    std::vector<Bounds> boxes;
    std::size_t searched_again = 0;    ///< bodies, one by one, since all were searched for
    std::vector<BodyPair> found_pairs; ///< by the last search
    /// Bodies that may touch in the next steps, and where what is known of them lies.
    struct Candidate {
        BodyPair bodies;
        std::size_t slot = 0;
    };
    std::vector<Candidate> candidates; ///< ascending
    std::vector<std::size_t> free_slots;
    std::vector<std::size_t> candidate_bodies; ///< all in `candidates`, ascending
    std::vector<char> is_unseen;     ///< [reported_count] the body's pairs were searched for and not looked at since
    std::vector<char> moved;         ///< [reported_count] of candidate_bodies: since their pairs were last looked at
    std::vector<double> near_margin; ///< [candidates] [m] see NearPair; negative: too far apart
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
