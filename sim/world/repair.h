#pragma once
/// The poses that a solve plans, checked by the bodies' shapes and not by its contacts; and contacts for those that would
/// overlap.
#include "sim/solve/contact_solver.h"
#include "sim/world/contact_search.h"

#include <optional>

namespace sim {

/// A contact found at the planned poses, as it is at t0: what is found of a face stays of that face, so that it is measured at
/// the planned poses as it was found. Of others the material points and the normal stay: the impulse acts at t0, but along the
/// normal that the bodies will have where they meet; the gap of edges, which the kernel follows from there, is the one that ends as
/// it was found.
ContactGeometry moved_back(const FoundContact& found, const Pose& planned_a, const Pose& planned_b, const Pose& a, const Pose& b);

class Repair {
public:
    /// All of them stay where they are.
    Repair(const Bodies& bodies, const StepSettings& settings, ContactSearch& search, ContactSolver& solver)
        : bodies_(bodies), settings_(settings), search_(search), solver_(solver) {}

    /// Before the first round of a plan over `interval` [s]. stops_at_impacts: pairs that are apart now are left to
    /// overlap_time().
    void begin(double interval, bool stops_at_impacts);

    /// Are there no pairs that would overlap by more than the tolerance at the planned poses?
    bool verify();
    /// Gives those that are not left to overlap_time() the contacts found there. at_node [body_count]: see RestingContacts::add.
    /// Returns false if there are none, or the last round did not lessen the overlap of one; else the impulses of others are those of
    /// another solve, and it is to be solved again.
    bool repair(std::span<const Velocity> at_node);

    double verified_penetration = 0.0; ///< [m] at the planned poses
    std::optional<Unsettled> pressed;  ///< the last of those that will overlap ever deeper, as no motion parts them

    /// When the first of the pairs left touches, the bodies moving freely with the velocities found [s]; just before.
    std::optional<double> overlap_time() const;

private:
    struct Overlap {
        BodyPair bodies;
        double depth = 0.0; ///< [m]
    };

    bool is_left(const BodyPair& pair) const;
    std::vector<FoundContact> contacts_of(const BodyPair& pair) const;

    const Bodies& bodies_;
    const StepSettings& settings_;
    ContactSearch& search_;
    ContactSolver& solver_;
    double interval_ = 0.0;
    bool stops_at_impacts_ = false;
    bool is_first_ = true;              ///< round of this plan
    std::vector<BodyPair> meeting_;     ///< apart now, overlapping at the planned poses
    std::vector<Overlap> overlapping_;  ///< there, others
    std::vector<Overlap> before_;       ///< as the round before left them
};

} // namespace sim
