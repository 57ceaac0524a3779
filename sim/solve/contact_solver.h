#pragma once
/// Resting contacts at position level (Bender & Schmitt 2006, sec. 3.2): impulses at t0 such that the
/// predicted gaps at t0 + h are closed.
#include "sim/solve/contact_groups.h"

namespace sim {

/// One solve over an interval. Keeps its arrays between steps.
class ContactSolver {
public:
    /// Threads that share its loops; the result does not depend on them.
    void set_workers(Workers* workers) { workers_ = workers; }
    /// Of its first group, from prepare() to the end of the step; in between their memory serves collisions.
    Blocks& blocks() { return groups_.front().contacts.loop; }
    /// Of the scene's joints, to be prepared at an instant before prepare(): for what the last impulses owe, and for collisions.
    JointSolver& joints() { return joints_; }

    /// Groups of all contacts of `pairs` at the poses of `bodies`, which the first solve() warm-starts. `bodies.velocity` are
    /// those at t0 before any resting impulse; h [s] is the interval, settings.time_step that of a whole step.
    /// `pairs` and what they hold stay where they are until store_impulses(), but for pairs that are added, or dropped.
    void prepare(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                 const StepSettings& settings, double h);

    /// See ContactGroups.
    void add_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> added,
                      std::span<const Velocity> at_node) {
        groups_.add(bodies, pairs, added, at_node, to_);
    }
    void drop_contacts(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair) {
        groups_.drop(bodies, pairs, pair, to_);
    }

    bool may_give_way = false; ///< see Blocks::softness()

    /// Iterates until the predicted gaps are closed, in the groups where contacts have been added or dropped since. Fills
    /// velocity() and predicted(). iterations: see StepReport, the most of a group.
    ContactSolveReport solve(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints);

    /// Stores impulses and marks in the memory of pairs and joints; where the plan falls short, they may make bodies no faster.
    /// Returns bodies that loads connect, each by the first of them [body_count].
    std::vector<int> store_impulses(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<Joint> joints,
                                    bool falls_short = false);

    /// Once the impulses are stored: what kinematic bodies and motors do by them.
    DriveWork drive_work(const Bodies& bodies);

    /// Of the joints under the impulses found, the fastest: see JointSolver::fastest_rates() [rad/s]. In islands with contacts each
    /// counts twice (`law_taut`): without, the error of Verlet's scheme swings, and is taken back; with them, what vibrates gains by it.
    double joint_rate(const Bodies& bodies);

    std::span<const std::size_t> solved_bodies() const { return to_.solved; } ///< in contacts or joints; others move freely
    std::span<const Velocity> velocity() const { return to_.velocity; }       ///< at t0 after the impulses
    std::span<const Pose> predicted() const { return to_.pose; }              ///< at t0 + h
    /// Velocities at t0 itself, once the impulses are stored: with the share of them that acts before it (Verlet's half).
    std::span<const Velocity> velocity_at_node() const { return at_node_; }
    /// Once the impulses are stored: of the bodies that impacts reach, in their order.
    std::span<const EnergyLoss> energy_lost() const { return lost_; }
    int contact_count() const;
    /// Of any pair.
    double given_way() const;
    /// The most [m] that a contact of the pair's island, or of its group, is asked for less, as no motion gives it.
    double given_way(int pair) const;
    double joint_gap() const { return joints_.widest(joints_.assemblies()).gap; } ///< [m] largest at the predicted poses
    Unsettled least_settled();

    /// Puts or gets what is planned, and what the next solve takes from this one beside the memory of pairs and joints.
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
        archive(solver.to_.velocity);
        archive(solver.at_node_);
        archive(solver.to_.pose);
        archive(solver.joints_.mode());
        archive(solver.groups_.block_bodies().swept);
        archive(solver.groups_.block_bodies().waits);
        archive(solver.groups_.block_bodies().wedged);
        archive(solver.memory_interval_);
        archive(solver.lost_);
    }

    void set_rules(const StepSettings& settings, double h);
    double part_of(double tolerance) const;
    void begin_group(const Bodies& bodies, const std::vector<PairContacts>& pairs, ContactGroup& group);
    void give_guess(const Bodies& bodies, ContactGroup& group);
    void take_uncertain(ContactGroup& group);
    void give_uncertain(const Bodies& bodies, ContactGroup& group);
    int iterate(ContactGroup& group, int budget, bool& converged);
    /// Motors and springs do work by way of contacts.
    bool is_told_more(const Bodies& bodies, const ContactGroup& group) const;
    bool is_driven(const ContactGroup& group) const { return !group.assemblies.empty() && joints_.has_drives(group.assemblies); }
    void find_energy_lost(const Bodies& bodies);
    void slow_down(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints,
                   std::vector<int>& held);
    void solve_group(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const Joint> joints, ContactGroup& group);

    StepSettings settings_;
    RestRules rules_;
    double iteration_tolerance_ = 0.0; ///< [m/s]
    Workers* workers_ = nullptr;
    ContactGroups groups_;
    JointSolver joints_;
    std::vector<double> joint_weight_; ///< [joint_count]
    Prediction to_;
    std::vector<Velocity> at_node_;    ///< see velocity_at_node()
    bool converged_ = true;            ///< the last solve
    std::vector<EnergyLoss> lost_;     ///< see energy_lost()
    std::vector<Velocity> change_;     ///< [body_count] by what is uncertain of the guess
    std::vector<Velocity> guessed_;    ///< [body_count] with what is certain of it, of bodies with joints until these are measured
    double memory_interval_ = std::numeric_limits<double>::infinity(); ///< [s] of the impulses stored last; 0: they did not converge
};

} // namespace sim
