#pragma once
/// Ball and hinge joints: their rows, solved exactly together inside the iteration loop of the contacts.
///
/// Bender et al. 2005 predict a joint's gap at t0 + h and apply the impulse that closes it, joint by joint.
/// Here all joints of the scene are one sparse linear system: a chain then needs no iterations, only contacts
/// do.
#include "sim/block/blocks.h"
#include "sim/model/scene_def.h"

#include <array>
#include <memory>

namespace sim {

/// What a joint hands to the next step.
struct JointMemory {
    std::array<double, 5> impulse{}; ///< of its rows [N s], [N m s]
    double owed = 0.0;               ///< see ContactMemory
    double last_interval = 0.0;      ///< [s]
};

/// A joint in body frames.
struct Joint {
    JointKind kind = JointKind::ball;
    int a = -1;
    int b = -1;
    Vec3 anchor_a = Vec3::Zero();    ///< [m], body frame of a
    Vec3 anchor_b = Vec3::Zero();    ///< [m], body frame of b
    Vec3 axis_a = Vec3::UnitZ();     ///< hinge: unit, body frame of a
    Vec3 across_b_1 = Vec3::UnitX(); ///< hinge: unit, across the axis, body frame of b
    Vec3 across_b_2 = Vec3::UnitY();
    JointMemory memory;
};

/// Joint from its definition; `world_body` is the index that stands for the world where body_b is -1.
Joint make_joint(const JointDef& def, std::span<const Pose> pose, int world_body);

/// All joints of a scene. Costs nothing where there are none.
class JointSolver {
public:
    JointSolver();
    ~JointSolver();
    JointSolver(JointSolver&&) noexcept;
    JointSolver& operator=(JointSolver&&) noexcept;

    /// Sets up the rows at the poses of `bodies`; J M^-1 J^T is factored when it is first needed.
    void prepare(const Bodies& bodies, std::span<const Joint> joints);

    bool empty() const { return rows_.empty(); }

    /// Targets: every joint point at rest relative to its partner (collisions).
    void target_rest();

    /// Targets: the gaps of the predicted poses, reached with `velocity`, close within h (resting solve).
    /// Where h is only `share` of a step, that share of the gap at t0 is closed: no velocity grows as the
    /// interval shrinks. Returns the largest error of a gap [m]; the hinge's angular gap counts with an arm
    /// of 1 m.
    double target_closed(std::span<const Joint> joints, std::span<const Pose> predicted,
                         std::span<const Velocity> velocity, double h, double share);

    /// Adds the owed share of the impulses that the joints remember at the present poses; only those of a body in `only`
    /// [body_count] unless that is empty.
    void apply_half_kick(std::span<const Joint> joints, std::span<const char> only, std::span<Velocity> velocity) const;

    /// Adds `weight` [joint_count] times the impulses of this solve.
    void add_weighted(std::span<const double> weight, std::span<Velocity> velocity) const;

    /// Work [J] that kinematic bodies do by the impulses of this solve, each times its `weight` [joint_count]; empty: 1.
    /// velocity: kinematic_velocity().
    double work(std::span<const double> weight, std::span<const Velocity> velocity) const;

    /// Writes the impulses of this solve to the joints' memory.
    void store_impulses(std::span<Joint> joints) const;

    /// Rate [rad/s] of the fastest motion that the joints' forces allow beside their own rows, as across a taut chain:
    /// the largest |eigenvalue| of M^-1 K, K the geometric stiffness of the impulses of this solve, each spread over
    /// its `interval` [joint_count] [s], on the motions that keep the joints closed. One step of the power iteration a
    /// call, from the mode found in the last call. 0 before the first solve.
    double fastest_rate(const Bodies& bodies, std::span<const double> interval);

    /// That mode: motions of all bodies, of which one is 1 m/s or 1 rad/s; empty before the first call.
    std::vector<Velocity>& mode() { return mode_; }
    const std::vector<Velocity>& mode() const { return mode_; }

    /// Applies the impulses that bring all rows to their targets at once. Returns the largest velocity change
    /// of a row [m/s].
    double solve(std::span<Velocity> velocity);

private:
    struct Row {
        int a, b;
        double inverse_mass_a, inverse_mass_b;
        Vec3 axis;           ///< zero for an angular row
        Vec3 r_a, r_b;       ///< of the joint's point from the centres of mass [m]
        Vec3 arm_a, arm_b;   ///< angular Jacobians
        Vec3 turn_a, turn_b; ///< J^-1 times them
        double gap = 0.0;    ///< at t0 [m] or [rad]
        double target = 0.0; ///< [m/s] or [rad/s]
        int joint = 0;       ///< whose row it is
        int index = 0;       ///< in the joint
        double sum = 0.0;    ///< impulses of this solve [N s] or [N m s]
    };
    struct Factor;

    double row_velocity(const Row& row, std::span<const Velocity> velocity) const;
    void close(std::span<Velocity> velocity);
    static void apply(const Row& row, double p, std::span<Velocity> velocity);
    void factorise();

    std::vector<Row> rows_;
    std::vector<Velocity> mode_; ///< [body_count] of fastest_rate()
    std::unique_ptr<Factor> factor_;
    bool is_factored_ = false;
};

} // namespace sim
