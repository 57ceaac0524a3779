#pragma once
/// What contacts remember from step to step, pair by pair: for the warm start.
#include "sim/block/blocks.h"

namespace sim {

/// Contacts of a pair, with what the last step remembered of them.
struct PairContacts {
    PairContacts() {} // as with Contact

    Manifold manifold;
    PairMaterial material;
    double least_gap = 0.0;            ///< [m] of its contacts
    std::uint32_t blocks = 0;          ///< that its contacts make; see block_count()
    bool was_ahead = false;            ///< a contact of it took an impact away that is to be given back
    bool is_struck = false;            ///< a collision of this instant reaches a body of it
    bool is_repaired = false;          ///< it was given other contacts in this solve; see ContactSearch::put_back()
    Vec3 owed_impulse = Vec3::Zero();  ///< [N s] on a: the owed share of the impulses remembered, at the present points
    Vec3 owed_moment = Vec3::Zero();   ///< [N m s] of it about the world's origin
};

/// What the impulses of an interval took from a body.
struct EnergyLoss {
    std::size_t body;
    double energy; ///< [J]; infinity: not known
};

/// Gives the pair these contacts, and hands what it remembers of those it had to them: by feature id, the rest to the nearest
/// core. What bears a load has to go on: the half kick of one contact alone would throw a body that is held between two.
void replace_contacts(PairContacts& pair, std::span<const FoundContact> found);

/// A block of pair number `index`, without its contacts.
Block block_like(const PairContacts& pair, int index);

/// Sums up what the pair's contacts tell of it as a whole: the members after `material`.
void sum_up(PairContacts& pair);

} // namespace sim
