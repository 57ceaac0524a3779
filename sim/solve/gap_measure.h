#pragma once
/// Gaps and slips of resting contacts at the predicted poses, and the targets that close them (eq. 8).
#include "sim/solve/resting_contacts.h"

namespace sim {

struct GapMeasure {
    const Bodies& bodies;
    const std::vector<PairContacts>& pairs;
    Prediction& to;
    RestingContacts& contacts;

    /// Gaps and displacements at the predicted poses, and the targets that close them (eq. 8: the velocity change
    /// d_n / h). Returns the largest error [m] of a gap, two-sided where the contact carries load.
    double measure() const;

private:
    double measure_others(std::size_t i) const;
    double measure_lane(const BlockBatch& batch, std::size_t lane) const;
};

} // namespace sim
