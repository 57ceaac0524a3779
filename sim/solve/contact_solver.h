#pragma once
/// Resting contacts at position level (Bender & Schmitt 2006, sec. 3.2): impulses at t0 such that the
/// predicted gaps at t0 + h are closed. contact_start.cpp has the contacts and what they start from, contact_measure.cpp what is
/// measured at the predicted poses (eq. 8), contact_store.cpp what is handed to the next interval.
#include "sim/block/blocks.h"
#include "sim/model/scene_def.h"
#include "sim/solve/contact_memory.h"
#include "sim/solve/joint.h"
#include "sim/solve/rest_batch.h"

namespace sim {

/// The iteration stops when no contact changed by more than this share [-] of the tolerance over h, or by the
/// velocity tolerance, whichever is smaller.
inline constexpr double iteration_share = 0.5;

/// Share [-] of the impulses at t0 that acts before it, when the velocities were last exact `last_interval`
/// [s] ago.
inline double node_weight(double last_interval, double h) {
    return last_interval / (last_interval + h);
}

/// Time [s] that the impulses of an interval h stand for: from the middle of the interval before to its own
/// middle.
inline double impulse_interval(double node_weight, double h) {
    return node_weight < 1.0 ? 0.5 * h / (1.0 - node_weight) : h;
}

/// Where edges that are nearly parallel touch wanders far with a small turn, and their normal turns with it. Beyond this
/// share [-] of the smaller body the gap is that of the points that touched as the interval began, along its normal
/// then; the check after the move sees what that leaves.
inline constexpr double wander_share = 0.02;

/// Friction within this share [-] of mu p_n is at its limit: projected there, it differs by rounding only.
inline constexpr double limit_rounding = 1e-9;

struct ContactSolveReport {
    int iterations = 0;
    double residual = 0.0;       ///< [m] largest gap error at the predicted poses
    double joint_residual = 0.0; ///< [m]
    bool converged = true;
};

/// One solve over an interval. Keeps its arrays between steps.
class ContactSolver {
public:
    /// Threads that share its loops; the result does not depend on them.
    void set_workers(Workers* workers) { loop_.workers = workers; }

    /// Blocks for all contacts of `pairs` at the poses of `bodies`, warm-started. `bodies.velocity` are those
    /// at t0 before any resting impulse; h [s] is the interval, settings.time_step that of a whole step.
    /// `pairs` and what they hold stay where they are until store_impulses(), but for pairs that are added, or dropped.
    void prepare(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                 std::span<const JointMemory> joint_memory, const StepSettings& settings, double h);

    /// Adds the contacts of these pairs. at_node [body_count]: velocities at t0, after its collisions; a contact that
    /// approaches faster than the resting threshold even so was not there to collide, and counts as placed before its
    /// impact.
    void add_contacts(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const int> added,
                      std::span<const Velocity> at_node);

    /// Takes the contacts of pair `pair` and their impulses out of the solve: other features face each other.
    void drop_contacts(const Bodies& bodies, int pair);

    /// Iterates until the predicted gaps are closed. Fills velocity() and predicted().
    ContactSolveReport solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                             std::span<const Joint> joints);

    /// Stores impulses, marks and leftover slip in the pairs' memory.
    void store_impulses(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<JointMemory> joint_memory);

    /// Of the joints under the impulses found: see JointSolver::fastest_rate() [rad/s].
    double joint_rate(const Bodies& bodies);

    std::span<const std::size_t> solved_bodies() const {
        return solved_bodies_;
    }                                                                ///< in contacts or joints; others move freely
    std::span<const Velocity> velocity() const { return velocity_; } ///< at t0 after the impulses
    std::span<const Pose> predicted() const { return predicted_; }   ///< at t0 + h
    /// Velocities at t0 itself, once the impulses are stored: with the share of them that acts before it (Verlet's half).
    std::span<const Velocity> find_velocity_at_node(const Bodies& bodies);
    /// What it found last.
    std::span<const Velocity> velocity_at_node() const { return at_node_; }
    int contact_count() const { return contact_count_; }
    Unsettled least_settled() { return loop_.least_settled(); }

    /// Puts or gets what is planned, and what the next solve takes from this one beside the pairs' memory.
    template <typename Archive>
    void exchange_plan(Archive& archive) {
        exchange_plan_of(*this, archive);
    }
    template <typename Archive>
    void exchange_plan(Archive& archive) const {
        exchange_plan_of(*this, archive);
    }

private:
    template <typename Solver, typename Archive>
    static void exchange_plan_of(Solver& solver, Archive& archive) {
        archive(solver.velocity_);
        archive(solver.at_node_);
        archive(solver.predicted_);
        archive(solver.joints_.mode());
        archive(solver.has_doubtful_memory_);
    }

    double part_of(double tolerance) const;
    void set_rules(const StepSettings& settings, double h);
    void find_solved_bodies(const Bodies& bodies, std::span<const PairContacts> pairs, std::span<const Joint> joints);
    void add_solved_body(const Bodies& bodies, int body);
    void take_pairs(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    std::size_t take(const Bodies& bodies, const PairContacts& pair, BlockContact* to) const;

    void start(const Bodies& bodies, std::vector<PairContacts>& pairs, std::size_t first_block);
    void start_batch(const Bodies& bodies, std::vector<PairContacts>& pairs, std::size_t i);
    void start_lane(const Bodies& bodies, PairContacts& pair, std::size_t i, std::size_t lane);
    void set_mark(Block& block, bool sticks);
    void find_late_impacts(const std::vector<PairContacts>& pairs, std::size_t first_block,
                           std::span<const Velocity> at_node);
    double work_on_batches(RestPhase phase, std::size_t first, std::size_t last, std::span<Velocity> velocity,
                           const unsigned* only = nullptr);

    void scale_warm_start(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    void predict(const Bodies& bodies);
    double measure(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    double measure_again(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    double measure_batches(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::size_t first, std::size_t last,
                           const unsigned* only);
    double measure_lane(const Bodies& bodies, const std::vector<PairContacts>& pairs, const BlockBatch& batch,
                        std::size_t lane);

    int iterate(double tolerance, int budget, bool& converged);
    bool update_marks(const std::vector<PairContacts>& pairs);
    bool update_mark(const std::vector<PairContacts>& pairs, Block& block);
    void find_hit_bodies(const Bodies& bodies);

    StepSettings settings_;
    bool stop_at_impacts_ = false;
    double h_ = 0.0;
    int settling_ = 0;                 ///< sweeps beyond the tolerance in this solve
    double iteration_tolerance_ = 0.0; ///< [m/s]
    double step_share_ = 1.0;          ///< h_ as a share of a whole step [-]
    Blocks loop_;
    bool has_two_coefficients_ = false;    ///< mu_s and mu_d differ somewhere
    int contact_count_ = 0;
    std::vector<RestPoint> rest_points_;   ///< [loop_.points]
    std::vector<RestBlock> rest_blocks_;   ///< [loop_.batches]
    std::vector<BodyRows> end_;            ///< [body_count]
    const double* before_ = nullptr;       ///< bodies.velocity
    RestRules rules_;
    std::vector<double> joint_weight_;     ///< [joint_count]
    std::vector<std::size_t> solved_bodies_;
    std::vector<char> is_solved_; ///< [body_count] is it one of them?
    std::vector<Velocity> velocity_;
    std::vector<Velocity> at_node_; ///< memory of find_velocity_at_node()
    std::vector<Velocity> measured_; ///< those of the first measurement of this solve
    std::vector<char> is_hit_;       ///< [body_count] by a speculative impact
    std::vector<double> radius_;     ///< [m] of the bodies around their centres of mass; static: 0
    std::vector<unsigned> unsure_;   ///< lanes of the batches that are to be measured again
    bool converged_ = true;            ///< the last solve
    bool has_doubtful_memory_ = false; ///< what was stored last is of a solve that did not converge
    bool all_in_solve_ = true;       ///< no contact was left out or dropped
    std::vector<Pose> predicted_;
    std::vector<PlacedBody> placed_; ///< the same, with rotation matrices
    JointSolver joints_;
};

} // namespace sim
