#pragma once
/// What one step of the world did: counts, iterations, residuals and the time of each stage.
#include <array>
#include <cstdint>

namespace sim {

/// Stages of World::step, in order.
enum class Stage { broad_phase, narrow_phase, collisions, contacts, integrate, count };
inline constexpr int stage_count = static_cast<int>(Stage::count);
inline constexpr std::array<const char*, stage_count> stage_names{"broad_phase", "narrow_phase", "collisions",
                                                                  "contacts", "integrate"};

/// What a step left unsettled: the widest open joint, a pair of bodies that are pressed together, or contacts of the pair that its
/// last sweep changed most.
struct Unsettled {
    int joint = -1;      ///< -1: the contacts
    int a = -1;
    int b = -1;
    int island = 0;      ///< bodies [-] that contacts connect with them
    double change = 0.0; ///< [m/s]
    double error = 0.0;  ///< [m] the joint's gap, the overlap, or the largest gap error of contacts
    bool is_pressed = false; ///< what closes in on the bodies leaves them no room: they overlap by more than the tolerance
};

/// A run that gains more energy than this [-] has missed a promise; see EnergyWatch::gain().
inline constexpr double energy_gain_allowed = 1e-3;

struct StepReport {
    int pairs = 0;                     ///< body pairs whose bounding boxes overlap
    int manifolds = 0;                 ///< pairs with at least one contact
    int collisions = 0;                ///< contacts resolved as collisions
    int collision_passes = 0;
    int contacts = 0;                  ///< contact points in the resting solve
    int joints = 0;
    int collision_iterations = 0;      ///< sweeps over the collisions; a step of Newton's method counts as those that it costs
    int contact_iterations = 0;        ///< the same over the resting contacts
    int impacts_stopped_at = 0;        ///< times of impact at which the step was divided
    int divisions = 0;                 ///< times the step was halved because it did not converge
    double interval = 0.0;             ///< [s] into which the step was divided, root mean square over its time
    double residual = 0.0;             ///< [m] largest gap error of contacts left by the solve
    double joint_gap = 0.0;            ///< [m] largest of a joint, at the poses after the step; an angle counts with an arm of 1 m
    double max_penetration = 0.0;      ///< [m] on the geometry of the poses after the step, >= 0
    double energy_gain = 0.0;          ///< [-] see EnergyWatch::gain()
    bool at_iteration_limit = false;   ///< not converged, and not mended
    bool is_out_of_work = false;       ///< and that because the step had no sweeps left to divide it with
    Unsettled unsettled;               ///< then
    std::array<double, stage_count> stage_ms{};   ///< wall time by Stage [ms]
};

} // namespace sim
