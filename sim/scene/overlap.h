#pragma once
/// Overlaps that a scene starts with: looked for once, when it is loaded.
#include "sim/model/scene_def.h"

#include <optional>

namespace sim {

/// The deepest overlap of a scene and how many there are.
struct StartOverlap {
    int body_a = -1;
    int body_b = -1;          ///< > body_a
    double penetration = 0.0; ///< [m]
    int pair_count = 0; ///< at most most_overlaps
};

/// The search ends with so many.
inline constexpr int most_overlaps = 1000;

/// Pairs that overlap by more than the scene's tolerance at the start, or as they are released together or where a fixed
/// body is, of which at least one body is dynamic
/// and which no joint connects; nothing if there are none.
std::optional<StartOverlap> find_start_overlap(const SceneDef& scene);

} // namespace sim
