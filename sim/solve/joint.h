#pragma once
/// The rows of joints, solved exactly together inside the iteration loop of the contacts.
///
/// Bender et al. 2005 predict a joint's gap at t0 + h and apply the impulse that closes it, joint by joint.
/// Here all joints of bodies that they connect, an assembly, are one sparse linear system: a chain then needs no iterations, only
/// contacts do.
///
/// A spring's row is soft. Its force is the mean of those at both ends of an interval (the mean acceleration method, Newmark
/// 1959, beta = 1/4): half of an interval's impulse acts at its start, half at its end. That is second order, keeps the
/// energy of a linear spring, and is stable at any step. What is too stiff for the step would ring for ever, and against
/// contacts; it goes over to the force at the end, all of which acts at the start (backward Euler), which comes to rest.
/// A motor's row asks for a speed, with an impulse that has a limit.
#include "sim/block/blocks.h"
#include "sim/solve/joint_model.h"
#include "sim/solve/prediction.h"

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>

namespace sim {

/// All joints of a scene. Costs nothing where there are none.
class JointSolver : public JointEquations {
public:
    JointSolver();
    ~JointSolver() override;
    JointSolver(JointSolver&&) noexcept;
    JointSolver& operator=(JointSolver&&) noexcept;

    /// Sets up the rows at the poses of `bodies`, for a first solve; J M^-1 J^T is factored when it is first needed, and where it
    /// has changed. A scene's joints, and what moves, stay the same from call to call.
    void prepare(const Bodies& bodies, std::span<const Joint> joints);

    /// Another solve at the same poses.
    void begin_solve(std::span<const Joint> joints);

    bool empty() const { return rows_.empty(); }

    /// All assemblies. What is said to be `of` some leaves the others alone: these may be of another thread.
    std::span<const int> assemblies() const { return all_; }
    std::span<const int> assembly_of() const override { return assembly_of_; }
    std::span<const int> bodies_of(int assembly) const override { return at(assembly).bodies; }
    std::span<const std::array<int, 2>> pairs_of(int assembly) const override { return at(assembly).pairs; }
    void add_equations(int assembly, double heaviest, std::span<const int> place, BodyFactors& to) const override;
    /// Unites those of each assembly; see disjoint_sets.h.
    void unite_bodies(std::vector<int>& sets) const;

    /// Targets: every joint point at rest relative to its partner (collisions); springs and motors have no answer to an impact.
    void target_rest();

    /// Targets: the gaps of the predicted poses close within h (resting solve).
    /// Where h is only `share` of a step, that share of the gap at t0 is closed: no velocity grows as the
    /// interval shrinks. Springs and motors get the targets of their forces. Returns the largest error of a gap [m]; an
    /// angular gap counts with an arm of 1 m.
    double target_closed(std::span<const int> of, std::span<const Joint> joints, const Prediction& to, double share);

    /// A joint and how far it is open [m]; an angular gap counts as above.
    struct Opening {
        int joint = -1;
        double gap = 0.0;
    };
    /// The widest one at those poses.
    Opening widest(std::span<const int> of) const;

    /// Adds to velocities before the next impulses what springs and motors owe; then the joints close (see half_kick()).
    void add_owed(std::span<Velocity> velocity);

    /// Adds what springs and motors give before t0 of this solve's impulses, of motors the share `weight` [joint_count] of
    /// them; then the joints close.
    void add_before(std::span<const int> of, std::span<const double> weight, std::span<Velocity> velocity);

    /// Takes away what opens the joints.
    void close_again(std::span<Velocity> velocity);

    /// Velocities [body_count] before the impulses of a solve, with what of them acts before t0, and after them.
    struct Kick {
        std::span<const Velocity> before, at_node, after;
    };
    /// Work that kinematic bodies and motors do by the impulses of this solve; what add_before() gave of them acts before t0.
    /// kinematic: kinematic_velocity(); kick: null without motors.
    DriveWork work(std::span<const Velocity> kinematic, const Kick* kick) const;
    /// The same of what add_owed() gave, from velocities kick.before to kick.after [J], of joints with a body in `only` [body_count].
    double half_kick_work(std::span<const Velocity> kinematic, const Kick& kick, std::span<const char> only) const;
    /// Work [J] of the last half kick of an assembly's springs and motors; velocities before and after it.
    double half_kick_work(int assembly, std::span<const Velocity> before, std::span<const Velocity> after) const;
    bool has_motors() const { return std::ranges::any_of(assemblies_, &Assembly::has_motors); }
    bool has_drives(std::span<const int> of) const; ///< motors, springs: what gives energy

    /// Writes what the next interval takes from this solve's to the joints' memory; of motors the share `weight` was given
    /// before t0.
    void store(std::span<Joint> joints, std::span<const double> weight) const;

    /// Of each assembly the rate [rad/s] of the fastest motion that the joints' forces allow beside their own rows, as across a
    /// taut chain: the square root of the largest |eigenvalue| of M^-1 K, K the geometric stiffness of the impulses of this solve,
    /// each spread over its `interval` [joint_count] [s], on the motions that keep the joints closed. One step of the power iteration
    /// a call, from the mode found in the last call; several in the first. 0 before the first solve.
    std::vector<double> fastest_rates(const Bodies& bodies, std::span<const double> interval);

    /// That mode: motions of all bodies, of which one is 1 m/s or 1 rad/s; empty before the first call.
    std::vector<Velocity>& mode() { return mode_; }
    const std::vector<Velocity>& mode() const { return mode_; }

    double solve(std::span<const int> of, std::span<Velocity> velocity) override;
    void keep(std::span<const int> of) override;
    void take_kept(std::span<const int> of) override;

private:
    enum class RowKind { point, angle, spring, motor };
    struct Row {
        RowKind kind;
        int joint;           ///< whose row it is
        int index;           ///< in the joint
        int a, b;
        double inverse_mass_a, inverse_mass_b;
        Vec3 axis;           ///< zero for an angular row
        Vec3 r_a, r_b;       ///< of the joint's point from the centres of mass [m]
        Vec3 arm_a, arm_b;   ///< angular Jacobians
        Vec3 turn_a, turn_b; ///< J^-1 times them
        double gap = 0.0;    ///< at t0 [m] or [rad]; of springs and motors: drive_position()
        double target = 0.0; ///< [m/s] or [rad/s]
        double sum = 0.0;    ///< impulses of this solve [N s] or [N m s]
        double before = 0.0; ///< of springs and motors, what of the last solve's acts at the end of its interval
        double half = 0.0;   ///< given by the last half kick
        double late = 0.0;     ///< of a spring: 0: mean of both ends, 1: the force at the end of the interval [-]
        double softness = 0.0; ///< of a spring: velocity that a unit of impulse does without [m/s] or [rad/s]
        double most = std::numeric_limits<double>::infinity(); ///< of a motor: its largest impulse
        double response = 0.0; ///< of a spring: velocity that a unit of impulse gives, with all joints closed
        std::int64_t age = 0;  ///< of that, in intervals
        bool is_out = false; ///< it takes no part: its impulse stays what it is
        double kept_sum = 0.0; ///< see keep()
        bool was_out = false;  ///< the same

        bool is_drive() const { return kind == RowKind::spring || kind == RowKind::motor; }
        /// Without the row's own softness what is missing would be so much of it [-].
        double share() const { return response / (response + softness); }
    };
    struct Factor;
    /// Bodies that joints connect; those that nothing moves connect none.
    struct Assembly {
        std::vector<int> joints; ///< ascending
        std::vector<int> bodies; ///< the same
        std::vector<std::array<int, 2>> pairs; ///< of them, that a joint connects
        std::size_t first = 0;   ///< of its rows
        std::size_t count = 0;
        std::unique_ptr<Factor> factor;
        bool is_factored = false;
        bool has_motors = false;
        bool has_springs = false;
        Opening widest;
    };

    /// The search for the motors at their limits.
    struct Pivots {
        std::size_t fewest = std::numeric_limits<std::size_t>::max(); ///< that were on the wrong side of theirs
        std::size_t rounds = 0; ///< in which these did not become fewer
        bool may_try = false;   ///< all at once, though they do not
    };

    void find_assemblies(const Bodies& bodies, std::span<const Joint> joints);
    void find_responses(Assembly& of);
    Assembly& at(int assembly) { return assemblies_[static_cast<std::size_t>(assembly)]; }
    const Assembly& at(int assembly) const { return assemblies_[static_cast<std::size_t>(assembly)]; }
    std::span<const Row> rows_of(const Assembly& of) const { return std::span(rows_).subspan(of.first, of.count); }
    std::span<Row> rows_of(const Assembly& of) { return std::span(rows_).subspan(of.first, of.count); }
    double row_velocity(const Row& row, std::span<const Velocity> velocity) const;
    void half_kick(std::span<const int> of, std::span<Velocity> velocity);
    double solve(Assembly& of, std::span<Velocity> velocity);
    double missing_of(const Row& row, std::span<const Velocity> velocity) const;
    void add_rows(const Bodies& bodies, const Joint& joint, int index, Assembly& of);
    static bool target_drive(const Joint& joint, Row& row, double position, double row_velocity, double h);
    bool keep_limits(Assembly& of, std::span<Velocity> velocity, Pivots& pivots);
    void take_out_drives(Assembly& of, bool is_out);
    const Eigen::VectorXd& close(Assembly& of, std::span<Velocity> velocity);
    static void apply(const Row& row, double p, std::span<Velocity> velocity);
    static std::optional<double> coupling(const Row& x, const Row& y);
    void factorise(Assembly& of);
    double improve_mode(Assembly& of, const Bodies& bodies, std::span<const double> interval);

    std::vector<Row> rows_; ///< assembly by assembly
    std::vector<Assembly> assemblies_;
    std::vector<int> all_;         ///< their indices
    std::vector<int> assembly_of_; ///< [body_count]
    std::vector<Velocity> mode_; ///< [body_count] of fastest_rates()
    std::vector<Velocity> next_; ///< [body_count] memory of improve_mode(); zero of what does not move
};

} // namespace sim
