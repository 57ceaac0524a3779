#pragma once
/// Collisions at velocity level (Bender & Schmitt 2006, sec. 3.1): velocities change, no time passes.
#include "sim/model/snapshot.h"
#include "sim/solve/contact_memory.h"
#include "sim/solve/joint.h"

#include <limits>

namespace sim {

/// What tells a collision in one pass.
struct Pass {
    int number = 0;
    double threshold = 0.0; ///< [m/s] slower contacts rest
    double reach = 0.0;     ///< [m] contacts farther apart do not touch,
    double soon = 0.0;      ///< [s] unless they do within this time
};

struct CollisionReport {
    int collisions = 0; ///< contacts resolved, over all passes
    int passes = 0;
    int iterations = 0;          ///< sweeps, and what Newton's steps cost
    double energy_removed = 0.0; ///< [J] that Newton's law with friction would have added
    double drive_work = 0.0; ///< [J] that kinematic bodies did
    /// The last pass converged, and no contact is left that collides. What an earlier pass left undone the next one mends.
    bool converged = true;
    Unsettled unsettled; ///< if it did not
    std::vector<char> touched; ///< [body_count] 1: its velocity may have changed; static bodies: 0
};

/// Resolves collisions in passes: a pass contains the contacts that are collisions when it starts, later ones what touches
/// their bodies too, and passes repeat until none is one, or their limit is reached, which is reported.
///
/// A contact is a collision if it touches (gap <= touch_gap(), or simultaneous_gap, or at once) and approaches faster than the resting
/// threshold, or if, placed ahead of its impact, it took away such an approach in the last step. With
/// Newton's law and friction an oblique impact may gain energy; such a pass is taken back towards the plastic
/// impact (e = 0) until it does not.
class CollisionSolver {
public:
    /// memory: holds the blocks of a pass; of others in between. joints: as they are prepared at the instant.
    CollisionSolver(Blocks& memory, JointSolver& joints) : loop_(memory), joints_(joints) {}

    /// Contacts up to this gap [m] collide too: where an impact has stopped the step, those that would touch next
    /// to at once are one impact with it, whatever the order in which rounding makes them touch.
    double simultaneous_gap = 0.0;

    /// Where the impulses of collisions are added, pass by pass; null: nowhere.
    std::vector<ContactSnapshot>* impacts = nullptr;

    /// What the last interval's impulses took from bodies, in the order of these; see ContactSolver::energy_lost().
    std::span<const EnergyLoss> lost;

    bool may_give_way = false; ///< see Blocks::softness()

    /// Sweeps [-] of all passes of an instant together, with what it takes to arrange them.
    std::int64_t most_sweeps = std::numeric_limits<std::int64_t>::max();

    /// velocity: those of the instant [body_count]; changed in place.
    CollisionReport resolve(const Bodies& bodies, std::span<const PairContacts> pairs, const StepSettings& settings,
                            std::vector<Velocity>& velocity);

private:
    /// A pair that may collide within this instant; each pass looks at all of them, and at few of the pairs.
    struct NearPair {
        int a, b; ///< bodies
        int pair;
        bool was_ahead;
    };

    bool collect(const Bodies& bodies, std::span<const PairContacts> pairs, const StepSettings& settings,
                 std::span<const Velocity> velocity, int pass);
    void hold_neighbours(const Bodies& bodies, std::span<const PairContacts> pairs, const Pass& now);
    void add_pair(const Bodies& bodies, const PairContacts& pair, int index, std::span<const Velocity> velocity,
                  const Pass& now);
    const PairContacts& near(std::span<const PairContacts> pairs, std::size_t k) const {
        return pairs[static_cast<std::size_t>(near_[k].pair)];
    }
    bool is_changed(const NearPair& pair) const {
        return is_changed_[static_cast<std::size_t>(pair.a)] != 0 || is_changed_[static_cast<std::size_t>(pair.b)] != 0;
    }
    Unsettled fastest_left();
    void iterate(std::vector<Velocity>& velocity, const StepSettings& settings, bool& converged);
    void report_impacts(int pass);
    double energy_owed() const;
    void begin_pass(const Bodies& bodies, std::vector<Velocity>& velocity);
    double keep_energy(const Bodies& bodies, std::vector<Velocity>& velocity, const StepSettings& settings,
                       bool& converged);
    double work_of_pass();

    Blocks& loop_;
    /// Of a contact in this pass [m/s].
    struct Target {
        double u_n = 0.0;      ///< that it is to have
        double approach = 0.0; ///< as the pass begins
    };
    std::vector<Target> targets_;     ///< [loop_.contacts]
    std::vector<BatchPoint> elastic_; ///< [loop_.points] before energy was taken away
    std::vector<std::size_t> in_pass_; ///< these bodies, in their order
    std::vector<int> assemblies_;      ///< of joints that hold some of them, ascending
    std::vector<Velocity> before_;  ///< [body_count] as this pass began, of the bodies in it
    std::vector<Velocity> plastic_; ///< [body_count] memory of keep_energy()
    std::vector<NearPair> near_;    ///< ascending
    std::vector<char> collides_;    ///< [near_] in this pass, or is held in it
    std::vector<char> is_changed_;  ///< [body_count] by the last pass, then by this one
    int sweeps_ = 0;                ///< of all passes so far, those of their plastic solutions too
    double energy_taken_ = 0.0; ///< [J] by contacts placed ahead, before the first pass
    std::vector<Velocity> kinematic_; ///< kinematic_velocity(); empty where there are none
    double joint_work_ = 0.0;  ///< [J] of all impulses of joints so far
    double work_ = 0.0;        ///< [J] that kinematic bodies do in the pass
    JointSolver& joints_;
};

} // namespace sim
