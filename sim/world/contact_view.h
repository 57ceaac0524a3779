#pragma once
/// The loaded contacts of a world, as a snapshot shows them.
#include "sim/model/snapshot.h"
#include "sim/solve/contact_solver.h"

#include <span>
#include <vector>

namespace sim {

/// Contacts with a normal impulse, in the order of the pairs. time_step [s]: impulses are scaled to it where
/// the step was divided.
std::vector<ContactSnapshot> loaded_contacts(std::span<const PairContacts> pairs, double time_step);

} // namespace sim
