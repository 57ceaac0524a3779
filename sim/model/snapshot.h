#pragma once
/// Plain poses and velocities of all bodies at one instant, and what can be computed from them.
#include "sim/base/math.h"
#include "sim/model/scene_def.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sim {

/// One body at one instant; one that is not released yet as it will be then.
struct BodySnapshot {
    Vec3 position = Vec3::Zero();            ///< centre of mass [m]
    Quat orientation = Quat::Identity();     ///< world_from_body
    Vec3 velocity = Vec3::Zero();            ///< of the centre of mass [m/s]
    Vec3 angular_velocity = Vec3::Zero();    ///< [rad/s], world frame
};

/// A contact that carries a load, and its impulses over the step that begins at the instant; or an impact: what acts
/// on a contact at one instant.
struct ContactSnapshot {
    std::array<std::int32_t, 2> bodies{-1, -1};            ///< a, b: indices into SceneDef::bodies
    Eigen::Vector3f point = Eigen::Vector3f::Zero();       ///< [m]
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();      ///< unit, from b to a
    Eigen::Vector3f impulse = Eigen::Vector3f::Zero();     ///< on a, normal and friction, of one step or impact [N s]
    bool is_sticking = false;
};

/// All bodies at one instant. Second-order accurate in position and velocity.
struct Snapshot {
    std::int64_t step = 0;
    double time = 0.0;                       ///< [s]
    std::vector<BodySnapshot> bodies;        ///< [body_count], order of SceneDef::bodies
    std::int64_t contact_count = 0;          ///< those that carry a load; 0 unless asked for
    std::vector<ContactSnapshot> contacts;   ///< empty unless asked for
    std::vector<ContactSnapshot> impacts;    ///< since the snapshot before; empty unless asked for
};

/// Mechanical quantities of all dynamic bodies that are there.
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
