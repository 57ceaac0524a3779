#pragma once
/// What benchmarks and studies need of a physics engine: ours and its peers behind one small struct.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"
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
    std::function<std::vector<sim::BodySnapshot>()> bodies; ///< poses and velocities; peers only
};

struct PeerSettings {
    int iterations = 10;       ///< sweeps of the solver
    bool warm_start = true;    ///< Bullet: start from the last impulses
    /// Bullet [m]: deeper overlaps are pushed apart without momentum (split impulses); infinite: none is.
    double split_depth = 0.04;
    bool solves_exactly = false; ///< ODE: the direct solver (dWorldStep) instead of sweeps
};

Engine make_ours(const sim::SceneDef& scene);
/// Both throw sim::Error (usage) for a shape, a mass, a joint or a motion that the engine is not given here.
Engine make_bullet(const sim::SceneDef& scene, const PeerSettings& settings);
Engine make_ode(const sim::SceneDef& scene, const PeerSettings& settings);

/// Restitution and friction of two bodies of a scene, as ours combines them; friction: the dynamic one, for the
/// peers have one coefficient.
struct Surface {
    double restitution = 0.0;
    double friction = 0.0;
};
Surface surface_of(const sim::MaterialDef& a, const sim::MaterialDef& b);

/// Throws sim::Error (usage) for bodies that keys move, and for joints other than free hinges and balls.
void check_peer_can(const sim::SceneDef& scene);

} // namespace bench
