#pragma once
/// What of a scene double precision cannot compute to the scene's tolerances: looked for once, when it is
/// loaded.
#include "sim/model/scene_def.h"

#include <optional>
#include <string>

namespace sim {

/// Largest turn of a body in contact in one step [rad], beyond which a run ends; and largest phase of joints that vibrate under load
/// for which a step is divided, as for turns, into parts of a fifth of a radian: more, and it would seem to hang.
inline constexpr double largest_turn_in_step = 2048.0;

/// Farthest a body may travel in one step, in multiples of half its length [-]. Measured: of boxes and balls shot into a
/// tower, overlaps stay within the tolerance up to 300 times half the thinnest side, and not at 1000.
inline constexpr double largest_travel_in_step = 256.0;

/// The first quantity of a scene beyond its bound.
struct Excess {
    int body = -1;       ///< index into bodies; -1: of the simulation or of a joint
    std::string key;     ///< the key that is to blame
    std::string message; ///< one sentence: the quantity, its value and the bound
};

/// Nothing if all quantities are within the bounds that follow from rounding, tolerances and the step.
std::optional<Excess> find_excess(const SceneDef& scene);

} // namespace sim
