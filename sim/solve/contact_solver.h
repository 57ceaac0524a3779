#pragma once
/// Resting contacts at position level (Bender & Schmitt 2006, sec. 3.2): impulses at t0 such that the
/// predicted gaps at t0 + h are closed. contact_measure.cpp has what is measured at the predicted poses,
/// contact_remember.cpp what is handed to the next interval, contact_lanes.cpp the same eight blocks at a time.
#include "sim/block/together.h"
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

/// Where edges that are nearly parallel touch wanders far with a small turn, and their normal turns with it. Beyond this
/// share [-] of the smaller body the gap is that of the points that touched as the interval began, along its normal
/// then; the check after the move sees what that leaves.
inline constexpr double wander_share = 0.02;

/// Time [s] that the impulses of an interval h stand for: from the middle of the interval before to its own
/// middle.
inline double impulse_interval(double node_weight, double h) {
    return node_weight < 1.0 ? 0.5 * h / (1.0 - node_weight) : h;
}

/// Within this share [-] of the tolerance a gap is not closed at once but by a share of it a step: closing an error of d
/// in one step needs the velocity d / h, which the next step has to take away again.
inline constexpr double soft_band = 0.5;

/// The impulses of an interval are no guess at those of one so many times [-] as long: next to an impact they stop what
/// approaches slowly, rather than carry a load.
inline constexpr double largest_stretch = 100.0;

/// Next to an impact held ahead, just after an impact, or where there was a force, an impulse so many times [-] that of the
/// last step's force, and of the weight, answers an impact and is no force.
inline constexpr double largest_growth = 2.0;

/// Friction within this share [-] of mu p_n is at its limit: projected there, it differs by rounding only.
inline constexpr double limit_rounding = 1e-9;

/// Is the friction of a loaded contact as large as mu p_n?
inline bool is_at_limit(const ContactPoint& point, double mu) {
    return point.p_n > 0.0 && point.p_t.norm() >= (1.0 - limit_rounding) * mu * point.p_n;
}

/// A resting contact in the solve, beside its ContactPoint.
struct RestingContact {
    int pair = -1;               ///< index into the pairs
    int index = -1;              ///< index into the pair's contacts
    double gap_target = 0.0;     ///< [m] at t0 + h
    Vec2 owed = Vec2::Zero();    ///< [m] of the slip of earlier steps, taken back in this one; in the block's tangents
    Vec3 point_a = Vec3::Zero(); ///< material points whose distance is d: body frames [m]
    Vec3 point_b = Vec3::Zero();
    bool is_on_face = false;     ///< a point fixed to one body, at the block's face of the other
    bool is_ahead = false;       ///< placed before its impact
    bool would_close = false;    ///< it is an impact: without impulses its gap would close in this interval
    double approach_speed = 0.0; ///< [m/s] it would touch with, without impulses
    double u_n_before = 0.0;     ///< [m/s] normal velocity before any impulse
    double load = 0.0;           ///< [N s] that the force of the last step would give in this interval
    bool restarts = false;       ///< an impact at t0 ended the force of the last step
    double force_share = 1.0;    ///< [-] of its impulse that is a force; the rest answers an impact
};

/// Sets point_a and point_b of a contact of the block as the interval begins.
inline void set_material_points(const Bodies& bodies, const ContactBlock& block, const ContactGeometry& at,
                                RestingContact& contact) {
    const Pose& a = bodies.pose[static_cast<std::size_t>(block.a)];
    const Pose& b = bodies.pose[static_cast<std::size_t>(block.b)];
    contact.point_a = a.orientation.conjugate() * (at.a - a.position);
    contact.point_b = b.orientation.conjugate() * (at.b - b.position);
}

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
    /// `pairs` and what they hold stay where they are until remember(), but for pairs that are added, or dropped.
    void prepare(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                 std::span<const JointMemory> joint_memory, const StepSettings& settings, double h);

    /// Adds the contacts of pair `pair`. at_node [body_count]: velocities at t0, after its collisions; a contact that
    /// approaches faster than the resting threshold even so was not there to collide, and counts as placed before its
    /// impact.
    void add_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair,
                      std::span<const Velocity> at_node);

    /// Takes the contacts of pair `pair` and their impulses out of the solve: other features face each other.
    void drop_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair);

    /// Iterates until the predicted gaps are closed. Fills velocity() and predicted().
    ContactSolveReport solve(const Bodies& bodies, const std::vector<PairContacts>& pairs,
                             std::span<const Joint> joints);

    /// Writes impulses, marks and leftover slip back to the pairs' memory.
    void remember(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<JointMemory> joint_memory);

    /// Of the joints under the impulses found: see JointSolver::fastest_rate() [rad/s].
    double joint_rate(const Bodies& bodies);

    std::span<const std::size_t> solved_bodies() const {
        return solved_bodies_;
    }                                                                ///< in contacts or joints; others move freely
    std::span<const Velocity> velocity() const { return velocity_; } ///< at t0 after the impulses
    std::span<const Pose> predicted() const { return predicted_; }   ///< at t0 + h
    /// Velocities at t0 itself: with the share of the impulses that acts before it (Verlet's half).
    std::vector<Velocity> velocity_at_node(const Bodies& bodies) const;
    int contact_count() const { return static_cast<int>(point_count_); }

private:
    double part_of(double tolerance) const;
    void find_solved_bodies(const Bodies& bodies, std::span<const PairContacts> pairs, std::span<const Joint> joints);
    void add_solved_body(const Bodies& bodies, int body);
    void predict(const Bodies& bodies);
    /// Contacts of one pair.
    struct Taken {
        std::vector<ContactGeometry> at;
        std::vector<int> index; ///< into the pair's contacts
    };
    /// Indices of a block and a point.
    struct Place {
        std::size_t block = 0;
        std::size_t point = 0;
    };
    Place size_of(const Bodies& bodies, const PairContacts& pair, Taken& taken) const;
    void take(const Bodies& bodies, const PairContacts& pair, Taken& taken) const;
    void resize(const Place& end);
    void place_contacts(const Bodies& bodies, const PairContacts& pair, int pair_index, const Place& place,
                        const Taken& taken);
    void apply_impulses(const Bodies& bodies, std::size_t first);
    void start_block(const Bodies& bodies, const PairContacts& pair, ContactBlock& block);
    void find_late_impacts(const PairContacts& pair, std::size_t first_block, std::span<const Velocity> at_node);
    double measure(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    void tell_forces(const Bodies& bodies);
    void remember_block(const ContactBlock& block, std::vector<PairContacts>& pairs) const;
    double measure_again(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    double measure_batches_again(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    double measure_block(const Bodies& bodies, const std::vector<PairContacts>& pairs, const ContactBlock& block);
    struct Displacement {
        double gap = 0.0;         ///< [m] at the predicted poses
        Vec2 d_t = Vec2::Zero();  ///< [m] tangential, over the interval; in the block's tangents
    };
    /// What the lanes need to know of the contacts of a block.
    struct BlockHead {
        const Contact* contacts = nullptr; ///< its own
        ContactMemory* memory = nullptr;
        int pair = -1;
        int index = -1; ///< of the first of them, in the pair
        bool is_plain = false;  ///< see RestBlock
        bool has_edges = false; ///< and its last contact is of crossing edges
        Vec3 edge_a = Vec3::Zero(); ///< see RestBlock
        Vec3 edge_b = Vec3::Zero();
    };
    /// A contact of a block that is measured.
    struct Measured {
        const ContactBlock& block;
        const Vec6& twist;
        const Vec3& n; ///< of the block's face at the predicted poses
        const RestingContact& contact;
    };
    Displacement displacement(const Bodies& bodies, const PairContacts& pair, const Measured& of,
                              const ContactPoint& point) const;
    double measure_point(const Bodies& bodies, const PairContacts& pair, const Measured& of, ContactPoint& point) const;
    Vec3 predicted_normal(const Bodies& bodies, const ContactBlock& block) const;

    bool fits_lanes(std::span<const PairContacts> pairs) const;
    void head_blocks(const Bodies& bodies, PairContacts& pair, int pair_index, Place place);
    void start_lanes(const Bodies& bodies, std::vector<PairContacts>& pairs, std::span<const Place> places);
    void head_batch(const Bodies& bodies, std::size_t i);
    void fetch_batch(std::size_t i) const;
    double work_on_batches(RestPhase phase, std::size_t first, std::size_t last, const unsigned* only = nullptr);
    ContactBlock block_in_lane(const BlockBatch& batch, std::size_t lane) const;
    double measure_lanes(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::size_t first, std::size_t last,
                         const unsigned* only);
    double measure_lane(const Bodies& bodies, const std::vector<PairContacts>& pairs, const BlockBatch& batch,
                        std::size_t lane);
    void leave_lanes(const Bodies& bodies, const std::vector<PairContacts>& pairs);
    void remember_lanes(const Bodies& bodies);
    void add_node_impulses(const Bodies& bodies, std::vector<Velocity>& velocity) const;
    double curvature_bound(const Bodies& bodies, int a, int b) const;
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
    std::vector<RestingContact> contacts_;  ///< [loop_.points]; not in lanes
    std::size_t point_count_ = 0;
    bool in_lanes_ = false;                 ///< blocks and points are in the batches only
    std::vector<BlockHead> heads_;          ///< [loop_.blocks] in lanes
    std::vector<RestPoint> rest_points_;    ///< [loop_.batch_points]
    std::vector<RestBlock> rest_blocks_;    ///< [loop_.batches]
    std::vector<BodyRows> begin_;           ///< [body_count] in lanes
    std::vector<BodyRows> end_;
    const double* before_ = nullptr;        ///< bodies.velocity
    RestRules rules_;
    std::vector<double> joint_weight_;      ///< [joint_count]
    std::vector<std::size_t> solved_bodies_;
    std::vector<char> is_solved_; ///< [body_count] is it one of them?
    std::vector<Velocity> velocity_;
    std::vector<Velocity> measured_; ///< those of the first measurement of this solve
    std::vector<char> is_hit_;       ///< [body_count] by an impact held ahead
    std::vector<double> radius_;     ///< [m] of the bodies around their centres of mass; static: 0
    std::vector<unsigned> unsure_;   ///< lanes of the batches that are to be measured again
    bool all_in_solve_ = true; ///< no contact was left out or dropped
    std::vector<Pose> predicted_;
    std::vector<PlacedBody> placed_; ///< the same, with rotation matrices
    JointSolver joints_;
};

} // namespace sim
