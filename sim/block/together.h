#pragma once
/// Sweeps over few blocks in an order that no numbering of the bodies enters, carried on by momentum.
///
/// Blocks are visited by their distance from static bodies, and those that are as far as each other at the same time,
/// each with its share of a body that several of them act on (mass splitting: Tonge, Benevolenski & Voroshilov 2012,
/// "Mass splitting for jitter-free parallel rigid body simulation"). So a symmetric set-up stays symmetric also where
/// loads can be shared in many ways, or the iteration ends early.
///
/// Sweeps alone would need thousands there: after some the impulses are carried on.
#include "sim/block/contact_block.h"
#include "sim/block/momentum.h"

namespace sim {

class TogetherSweeps {
public:
    /// Are there few enough blocks?
    static bool fits(const ContactBlocks& loop);

    /// Before the sweeps of one solve.
    void begin(const ContactBlocks& loop, const Bodies& bodies);

    /// One iteration over all blocks; returns the largest velocity change at any point [m/s].
    double sweep(ContactBlocks& loop, const Bodies& bodies, std::span<Velocity> velocity);

private:
    void carry_on(ContactBlocks& loop, const Bodies& bodies, std::span<Velocity> velocity);

    std::vector<ContactBlock> blocks_; ///< by group
    std::vector<BlockResponse> responses_; ///< [blocks_] of their shares of the bodies
    std::vector<int> group_;           ///< [blocks_] those of one group are solved at the same time
    std::vector<Vec6> wrenches_;       ///< of one group
    std::vector<Vec3> carried_;        ///< [points] impulses (p_t, p_n) as the last sweep began [N s]
    std::vector<Vec3> swept_;          ///< [points] as the sweep before it ended [N s]
    double change_ = 0.0;              ///< [m/s] by the last sweep
    Momentum momentum_;
};

} // namespace sim
