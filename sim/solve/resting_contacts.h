#pragma once
/// Resting contacts in the batches of a solve: taken from their pairs, started from what these remember, and stored there
/// again. gap_measure.h measures them at the predicted poses; contact_store.cpp has what they hand to the next interval.
#include "sim/model/scene_def.h"
#include "sim/solve/contact_memory.h"
#include "sim/solve/joint_model.h"
#include "sim/solve/prediction.h"
#include "sim/solve/rest_batch.h"

namespace sim {

/// Keeps its arrays between steps.
class RestingContacts {
public:
    explicit RestingContacts(std::shared_ptr<BlockBodies> bodies) : loop(std::move(bodies)) {}

    Blocks loop;
    std::vector<RestPoint> rest_points; ///< [loop.points]
    std::vector<RestBlock> rest_blocks; ///< [loop.batches]

    /// Before begin(): the rules of the solve.
    void follow(const StepSettings& settings, const RestRules& rules);
    /// Takes the contacts of the pairs `own`, ascending, at the poses of `bodies`; the bodies of `to` get the impulses that
    /// they start from, those in `uncertain` [body_count] the share of them that is. `pairs` and what they hold stay where they are
    /// until store(), but for pairs that are added, or dropped.
    void begin(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> own, Prediction& to,
               std::span<Velocity> uncertain);

    /// Adds the contacts of the pairs `added`. at_node [body_count]: velocities at t0, after its collisions; a contact that
    /// approaches faster than the resting threshold even so was not there to collide, and counts as placed before its
    /// impact; empty: all were there.
    void add(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> added,
             std::span<const Velocity> at_node, Prediction& to);

    /// Takes the contacts of a pair and their impulses out again: other features face each other, and are to be added. They
    /// start from the impulses that these had, or loads a thousand times the weight would throw the bodies between them.
    void drop(const Bodies& bodies, int pair, Prediction& to);

    /// Work [J] of the uncertain share against how much faster than their targets the contacts part with `velocity`.
    double uncertain_work(std::span<const Velocity> velocity);
    /// Work [J] that the impulses do on the bodies, but for what pushes overlaps apart: contacts give no energy. velocity: after them.
    double impulse_work(std::span<Velocity> velocity);
    /// Keeps so much [-] of that share.
    void scale_uncertain(double kept);

    /// What overlaps is asked to part to the tolerance only; within it, where there is little room left, at a pace [m/s]. Returns the
    /// most [m] that loaded contacts are asked for less.
    double hold_overlaps(double pace);
    /// After the sweeps: what impulses that give way leave missing is asked for no more. Returns the most of it [m].
    double give_way(std::span<Velocity> velocity);

    /// Eq. 6 on converged sums. Returns true if the iteration has to go on for it: with mu_s = mu_d a mark changes nothing.
    bool update_marks(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Velocity> velocity);

    /// Stores impulses and marks in the memory of pairs, those in `own`, and gives the bodies at t0 what acts before it of the
    /// impulses. assemblies: bodies that joints connect.
    void store(const std::vector<PairContacts>& pairs, std::span<const int> own, std::span<const std::span<const int>> assemblies,
               Prediction& to, std::span<Velocity> at_node);

    /// Once they are stored: unites the bodies that move and that loads connect; see disjoint_sets.h.
    void unite_loaded(std::vector<int>& connected) const;
    /// Once they are stored: what kinematic bodies do by the impulses. velocity: kinematic_velocity().
    DriveWork work_by(std::span<const Velocity> velocity) const;

    /// One phase for batches first..last. Returns what work_on_rest() does.
    double work(RestPhase phase, std::size_t first, std::size_t last, std::span<Velocity> velocity);

private:
    double sum(RestPhase phase, const double* before, std::span<Velocity> velocity);
    void remember(const Block& block) const;
    std::size_t take(const Bodies& bodies, const PairContacts& pair, const Contact** to) const;
    void take_all(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> own);
    void start(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::size_t first_block, Prediction& to,
               std::span<Velocity> uncertain);
    void start_batch(const std::vector<PairContacts>& pairs, std::size_t i, std::span<Velocity> velocity);
    void start_lane(const Manifold& manifold, std::size_t i, std::size_t lane);
    void work_with_memory(RestWork work, std::size_t i);
    RestWork work_of(RestPhase phase, std::size_t first, std::size_t last, std::span<Velocity> velocity);
    void find_late_impacts(std::size_t first_block, std::span<const Velocity> at_node);
    void set_mark(Block& block, bool sticks);
    bool update_mark(const Bodies& bodies, const PairContacts& pair, Block& block, std::span<const Velocity> velocity);
    double force_share(const Block& block) const;
    void find_hit_bodies(std::span<const std::span<const int>> assemblies, std::span<char> is_reached);
    void forget_left_out(const std::vector<PairContacts>& pairs, std::span<const int> own) const;

    StepSettings settings_;
    RestRules rules_;
    const double* before_ = nullptr;    ///< bodies.velocity
    const BodyRows* end_ = nullptr;     ///< predicted
    bool has_two_coefficients_ = false; ///< mu_s and mu_d differ somewhere
    std::size_t sorted_blocks_ = 0;     ///< so many are in the order of their pairs; then those added
    bool has_all_ = true;               ///< no contact was left out
    std::vector<double> sums_;          ///< [loop.batches] of sum()
};

} // namespace sim
