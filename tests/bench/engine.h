#pragma once
/// What the funnel benchmark needs of a physics engine: ours and its peers behind one small struct.
#include "sim/scene_def.h"
#include "tests/laws/reference/overlap.h"

#include <functional>
#include <string>
#include <vector>

namespace bench {

/// Counts of one step, where an engine tells them.
struct StepCounts {
    int contacts = 0;
    int collisions = 0;
    int iterations = 0;
    bool unconverged = false;
    double collisions_ms = 0.0; ///< time of the collision phase [ms]
    double contacts_ms = 0.0;   ///< time of the contact phase [ms]
};

/// One engine with one scene loaded. Bodies are those of the scene, in its order.
struct Engine {
    std::string name;
    std::function<void()> step;
    std::function<StepCounts()> counts; ///< of the last step; not timed
    std::function<std::vector<reference::Placement>()> placements;
    std::function<std::string()> state_hash; ///< empty where the engine has none
};

/// iterations: sweeps of the engine's solver. Restitution and friction are those of the scene as combined for
/// a pair of its bodies: all bodies of the scene must agree on them.
Engine make_ours(const sim::SceneDef& scene);
Engine make_bullet(const sim::SceneDef& scene, int iterations);
Engine make_ode(const sim::SceneDef& scene, int iterations);

/// Restitution and friction of every pair of the scene. Throws sim::Error (usage) if bodies differ.
struct Surface {
    double restitution = 0.0;
    double friction = 0.0;
};
Surface common_surface(const sim::SceneDef& scene);

} // namespace bench
