#pragma once
/// Resting contacts at position level (Bender & Schmitt 2006, sec. 3.2): impulses at t0 such that the
/// predicted gaps at t0 + h are closed, and the contacts of this step that a later step starts from.
#include "sim/block_together.h"
#include "sim/joint.h"
#include "sim/scene_def.h"

namespace sim {

/// What a contact hands to the next step.
struct ContactMemory {
    std::uint64_t id = 0;
    Vec3 core_a = Vec3::Zero(); ///< body frame of a [m]: finds the contact again where its id changed
    double p_n = 0.0;           ///< [N s]
    Vec3 p_t = Vec3::Zero();    ///< [N s], world
    double interval = 0.0;      ///< time those impulses stood for [s]
    double owed = 0.0;          ///< share [-] of them that the velocities before the next impulses still lack
    double last_interval = 0.0; ///< [s] moved since; 0: they lack nothing (new, or after an impact)
    bool is_sticking = false;
    Vec3 slip = Vec3::Zero();    ///< d_t left over while sticking [m], world: without it a block creeps
    Vec3 sliding = Vec3::Zero(); ///< mean sliding velocity of the step [m/s], world
    double approach_speed = 0.0; ///< [m/s] that a contact placed ahead of its impact took away
    double energy_taken = 0.0;   ///< [J] taken away with it
};

/// Contacts of a pair as a step begins, matched with what the last step remembered of them.
struct PairContacts {
    Manifold manifold;
    std::vector<ContactMemory> memory; ///< [manifold.contacts]
    PairMaterial material;
    double least_gap = 0.0;            ///< [m] of its contacts
    bool was_ahead = false;            ///< a contact of it took an impact away that is to be given back
    Vec3 owed_impulse = Vec3::Zero();  ///< [N s] on a: the owed share of the impulses remembered, at the present points
    Vec3 owed_moment = Vec3::Zero();   ///< [N m s] of it about the world's origin
};

/// Takes over, contact by contact, what `old` remembered: by feature id, else the nearest core within `reach`
/// [m].
void match_memory(std::span<const ContactMemory> old, PairContacts& pair, double reach);

/// Sums up what the pair's contacts tell of it as a whole: the members after `material`.
void sum_up(PairContacts& pair);

/// Adds to the velocities before the next impulses what they lack to be those at the instant: the owed impulses. Only
/// pairs with a body in `only` [body_count] unless that is empty.
void pay_contacts(const Bodies& bodies, std::span<const PairContacts> pairs, std::span<const char> only,
                  std::span<Velocity> velocity);

/// A resting contact in the solve, beside its ContactPoint.
struct RestingContact {
    int pair = -1;               ///< index into the pairs
    int index = -1;              ///< index into the pair's contacts
    double gap_target = 0.0;     ///< [m] at t0 + h
    Vec3 point_a = Vec3::Zero(); ///< material points whose distance is d: body frames [m]
    Vec3 point_b = Vec3::Zero();
    bool is_ahead = false;       ///< placed before its impact
    bool would_close = false;    ///< it is an impact: without impulses its gap would close in this interval
    double approach_speed = 0.0; ///< [m/s] it would touch with, without impulses
    double u_n_before = 0.0;     ///< [m/s] normal velocity before any impulse
};

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
    void prepare(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                 std::span<const JointMemory> joint_memory, const StepSettings& settings, double h);

    /// Adds the contacts of pair `pair`.
    void add_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair);

    /// Takes the contacts of pair `pair` and their impulses out of the solve: other features face each other.
    void drop_contacts(const Bodies& bodies, int pair);

    /// Iterates until the predicted gaps are closed. Fills velocity() and predicted().
    ContactSolveReport solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                             std::span<const Joint> joints);

    /// Writes impulses, marks and leftover slip back to the pairs' memory.
    void remember(std::vector<PairContacts>& pairs, std::span<JointMemory> joint_memory) const;

    /// Of the joints under the impulses found: see JointSolver::fastest_rate() [rad/s].
    double joint_rate(const Bodies& bodies);

    std::span<const Velocity> velocity() const { return velocity_; } ///< at t0 after the impulses
    std::span<const Pose> predicted() const { return predicted_; }   ///< at t0 + h
    /// Velocities at t0 itself: with the share of the impulses that acts before it (Verlet's half).
    std::vector<Velocity> velocity_at_node(const Bodies& bodies) const;
    int contact_count() const { return static_cast<int>(loop_.points.size()); }

private:
    double part_of(double tolerance) const;
    void predict(const Bodies& bodies);
    bool takes(const Bodies& bodies, const PairContacts& pair, std::size_t contact) const;
    void place_contacts(const Bodies& bodies, const PairContacts& pair, int pair_index, std::size_t first_block,
                        std::size_t first_point);
    void start_block(const Bodies& bodies, const PairContacts& pair, ContactBlock& block);
    double measure(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    void remember_block(const ContactBlock& block, std::vector<PairContacts>& pairs) const;
    double measure_again(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    double measure_batches_again(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    double measure_block(const Bodies& bodies, const std::vector<PairContacts>& pairs, const ContactBlock& block);
    double curvature_bound(const Bodies& bodies, int a, int b) const;
    Vec2 owed_displacement(const ContactBlock& block, const ContactMemory& memory) const;
    bool update_marks(const std::vector<PairContacts>& pairs);
    int iterate(const Bodies& bodies, double tolerance, int budget, bool& converged);
    void shock_propagation(const Bodies& bodies);

    StepSettings settings_;
    bool stop_at_impacts_ = false;
    double h_ = 0.0;
    int settling_ = 0;                 ///< sweeps beyond the tolerance in this solve
    double iteration_tolerance_ = 0.0; ///< [m/s]
    double relaxation_ = 0.0; ///< share of a small gap closed in a whole step [-]
    double step_share_ = 1.0; ///< h_ as a share of a whole step [-]
    ContactBlocks loop_;
    TogetherSweeps together_; ///< over few blocks
    std::vector<RestingContact> contacts_;  ///< [loop_.points]
    std::vector<double> joint_weight_;      ///< [joint_count]
    std::vector<Velocity> velocity_;
    std::vector<Velocity> measured_; ///< those of the first measurement of this solve
    std::vector<double> radius_;     ///< [m] of the bodies around their centres of mass; static: 0
    std::vector<unsigned> unsure_;   ///< lanes of the batches that are to be measured again
    /// [pairs] blocks and points of the pairs before each one.
    struct Places {
        std::size_t blocks = 0;
        std::size_t points = 0;
    };
    std::vector<Places> places_;
    bool all_in_solve_ = true; ///< no contact was left out or dropped
    std::vector<Pose> predicted_;
    std::vector<PlacedBody> placed_; ///< the same, with rotation matrices
    JointSolver joints_;
};

} // namespace sim
