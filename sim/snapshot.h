#pragma once
/// Plain poses and velocities of all bodies at one instant, and what can be computed from them.
#include "sim/math.h"
#include "sim/scene_def.h"

#include <cstdint>
#include <span>
#include <vector>

namespace sim {

/// One body at one instant.
struct BodySnapshot {
    Vec3 position = Vec3::Zero();            ///< centre of mass [m]
    Quat orientation = Quat::Identity();     ///< world_from_body
    Vec3 velocity = Vec3::Zero();            ///< of the centre of mass [m/s]
    Vec3 angular_velocity = Vec3::Zero();    ///< [rad/s], world frame
};

/// All bodies at one instant. Second-order accurate in position and velocity.
struct Snapshot {
    std::int64_t step = 0;
    double time = 0.0;                       ///< [s]
    std::vector<BodySnapshot> bodies;        ///< [body_count], order of SceneDef::bodies
};

/// Mechanical quantities of all dynamic bodies.
struct Mechanics {
    double kinetic_energy = 0.0;             ///< [J]
    double potential_energy = 0.0;           ///< [J], zero at the world's origin
    Vec3 momentum = Vec3::Zero();            ///< [N s]
    Vec3 angular_momentum = Vec3::Zero();    ///< [N m s], about the world's origin
};
Mechanics mechanics(const SceneDef& scene, const Snapshot& snapshot);

/// FNV-1a over the bits of step and all poses and velocities: equal states, equal hash.
std::uint64_t state_hash(const Snapshot& snapshot);

} // namespace sim
