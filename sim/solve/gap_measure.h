#pragma once
/// Gaps and slips of resting contacts at the predicted poses, and the targets that close them (eq. 8).
#include "sim/solve/resting_contacts.h"

namespace sim {

struct GapMeasure {
    const Bodies& bodies;
    const std::vector<PairContacts>& pairs;
    const StepSettings& settings;
    Prediction& to;
    RestingContacts& contacts;

    /// Gaps and displacements at the predicted poses, and the targets that close them (eq. 8: the velocity change
    /// d_n / h). Returns the largest error [m] of a gap, two-sided where the contact carries load.
    double all() const;

    /// The same after the velocities changed from `measured` [body_count]: from the measurement there, where gaps are linear
    /// in the change to well within the tolerance, else measured again.
    double again(std::span<const Velocity> measured) const;

private:
    double measure(std::size_t first, std::size_t last, const unsigned* only) const;
    double measure_lane(const BlockBatch& batch, std::size_t lane) const;
};

} // namespace sim
