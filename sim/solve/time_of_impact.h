#pragma once
/// When contacts that do not touch yet will, within a step (impacts = "stop"). Repair::overlap_time() finds it for
/// bodies that are apart and will overlap, by their shapes.
#include "sim/block/blocks.h"
#include "sim/model/scene_def.h"

#include <functional>
#include <optional>

namespace sim {

struct PairContacts;

/// Gaps tell no less than this [m]: the rounding of positions some metres from the origin.
inline constexpr double gap_rounding = 1e-13;

/// Approach speed [m/s] above which a touching contact is a collision: sqrt(2 g eps_c) (Mirtich), with a
/// floor for zero gravity, and above what a solve to the velocity tolerance leaves.
double resting_threshold(const StepSettings& settings);

/// Largest gap [m] at which an approaching contact collides: the tolerance where impacts are held by contacts
/// placed ahead; next to nothing where the step stops at them, so that normals and times are those of the
/// touch.
double touch_gap(const StepSettings& settings);

/// Intervals are no shorter than this [s]: what would touch sooner touches now. Rounding of positions divided by it
/// is an error of velocities.
double shortest_interval(const StepSettings& settings);

/// A contact that is about to touch.
struct Impact {
    double time = 0.0;       ///< [s] from t0
    std::size_t pair = 0;    ///< index into the pairs
    std::size_t contact = 0; ///< index into its contacts
};

struct PairPoses {
    Pose a;
    Pose b;
};

/// Gap [m] at the poses `to` of a contact of bodies that were at `from`: that of its features, or where these touched from
/// the start (the lowest point of a rim that falls flat), that of the material points that did not. touch [m]: gap that counts
/// as touching.
double impact_gap(const FoundContact& contact, const PairPoses& from, const PairPoses& to, double touch);

/// Earliest impact in (0, h]: a contact with gap > touch_gap that approaches faster than the resting
/// threshold closes its gap, the bodies moving freely with `velocity`. Exact to rounding along the motion.
std::optional<Impact> time_of_impact(const Bodies& bodies, std::span<const Velocity> velocity,
                                     std::span<const PairContacts> pairs, const StepSettings& settings,
                                     double h);

/// The last time [s] at which a gap that is `gap_early` [m] now, and closed at `late`, is still open: to rounding. Regula
/// falsi, with bisection whenever it does not halve the bracket.
double closing_time(const std::function<double(double)>& gap_at, double gap_early, double late, double gap_late);

/// Gravity on a less that on b [m/s^2]; a static body has none.
Vec3 relative_gravity(const Bodies& bodies, const Manifold& manifold, const StepSettings& settings);

/// Is this contact left to time_of_impact, rather than held ahead? It neither touches nor bears a load, and would, falling with
/// the velocities in `bodies`, touch faster than the resting threshold.
bool is_impact(const Bodies& bodies, const Manifold& manifold, const Contact& contact,
               const StepSettings& settings);

} // namespace sim
