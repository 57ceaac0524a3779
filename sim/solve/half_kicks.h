#pragma once
/// What velocities lack between two instants to be those at the instant: half of what forces gave them over the last interval, as in
/// Verlet's scheme. Contacts' forces are their owed impulses; those of joints are the JointSolver's.
#include "sim/solve/contact_memory.h"

namespace sim {

/// Bodies that move and that owed impulses connect, each by the first of them [body_count]; the others by themselves.
std::vector<int> connected_by_loads(const Bodies& bodies, std::span<const PairContacts> pairs);

/// Adds them to `velocity`, that of `bodies`. A force keeps bodies where they are: its half kick takes back what went astray of
/// their energy. What would give some to all that loads connect was no force but a push that has done its work, and the pairs owe
/// so much less of it that it gives none. connected: connected_by_loads().
void apply_half_kicks(const Bodies& bodies, std::span<const int> connected, std::span<PairContacts> pairs,
                      std::span<Velocity> velocity);

/// Work [J] that kinematic bodies do by those of pairs with a body in `only` [body_count]. kinematic: kinematic_velocity().
double half_kick_work(const Bodies& bodies, std::span<const PairContacts> pairs, std::span<const char> only,
                      std::span<const Velocity> kinematic);

} // namespace sim
