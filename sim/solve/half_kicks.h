#pragma once
/// What velocities lack between two instants to be those at the instant: half of what forces gave them over the last interval, as in
/// Verlet's scheme. Contacts' forces are their owed impulses; those of joints are the JointSolver's.
#include "sim/solve/contact_memory.h"
#include "sim/solve/joint.h"

namespace sim {

/// Adds them to `velocity`, that of `bodies`. A force keeps bodies where they are: its half kick takes back what went astray of
/// their energy. What would give more to all that loads connect than their springs and motors do was no force but a push that has
/// done its work, and the pairs owe so much less of it that it gives none. connected [body_count]: bodies that loads
/// connect, each by the first of them. rows: prepared at the instant.
void apply_half_kicks(const Bodies& bodies, std::span<const int> connected, std::span<PairContacts> pairs, JointSolver& rows,
                      std::span<Velocity> velocity);

/// at_node: velocities at an instant with its half kicks, those of `bodies` before its impulses, `after` them. In between bodies have
/// no more energy than before or after, but where some of their contacts begin to bear what others have borne: a row that is being
/// wedged. The half kicks of bodies that are `held` together, as `connected`, are cut to what gives no more. own: the bodies looked at,
/// which move. Returns whether any are cut.
bool cut_half_kicks(const Bodies& bodies, std::span<const std::size_t> own, std::span<const int> held,
                    std::span<const Velocity> after, std::span<Velocity> at_node);

/// Work [J] that kinematic bodies do by those of pairs with a body in `only` [body_count]. kinematic: kinematic_velocity().
double half_kick_work(const Bodies& bodies, std::span<const PairContacts> pairs, std::span<const char> only,
                      std::span<const Velocity> kinematic);

} // namespace sim
