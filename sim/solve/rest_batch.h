#pragma once
/// Resting contacts in the lanes of block_batch.h: the fast form of what contact_solver.cpp, contact_measure.cpp and
/// contact_remember.cpp do block by block, for blocks that are all solved in batches. This header knows no library:
/// rest_kernel.cpp is compiled once for each instruction set.
#include "sim/block/batch.h"

namespace sim {

inline constexpr int most_points = 9; ///< of a block: block_size

/// Two rows of 64 bytes of a body. As the interval begins: position (3), inverse mass, inverse inertia tensor
/// (xx xy xz yy yz zz). As predicted at its end: rotation since then (row by row), position.
struct alignas(64) BodyRows {
    double x[16];
};

/// Point k of each block of a batch, beside its BatchPoint; see RestingContact.
struct RestPoint {
    Lanes gap;    ///< [m] as the interval begins
    Lanes height; ///< [m] of the point on a along n, from the block's centre on a
    Lanes gap_target;
    Lanes owed[2];
    Lanes u_n_before, approach_speed, load;
    Lanes force_share;             ///< of its impulse, once remembered
    const double* at[lane_count];  ///< gap, n, a of a contact, from its ContactGeometry; of none where no point is
    double* memory[lane_count];    ///< two rows of a ContactMemory, from p_n on
    unsigned there = 0;            ///< bit l: lane l has this point
    unsigned edges = 0;            ///< bit l: crossing edges touch there
    unsigned ahead = 0;            ///< bit l: is_ahead
    unsigned closing = 0;          ///< bit l: would_close
    unsigned restarts = 0;         ///< bit l: restarts
};

/// A batch, beside its BlockBatch.
struct RestBlock {
    Lanes nearest_gap;  ///< [m] of the contact in whose plane the impulses act
    Lanes edge_a[3];    ///< of crossing edges: their directions, so that n is along edge_a x edge_b
    Lanes edge_b[3];
    Lanes reach;        ///< [m] of crossing edges: how far the touch may wander
    unsigned edges = 0; ///< bit l: one of its points is of crossing edges
    unsigned plain = 0; ///< bit l: all others are fixed to one body, at a face of the other: measured in lanes
    unsigned hit = 0;   ///< bit l: a body of it is hit by an impact held ahead
};

/// What is the same for all batches.
struct RestRules {
    double h = 0.0; ///< [s]
    double tolerance = 0.0;
    double band = 0.0;               ///< [m] see soft_band
    double relaxation = 0.0;
    double step_share = 1.0;
    double velocity_tolerance = 0.0; ///< [m/s]
    double largest_stretch = 0.0;
    double largest_growth = 0.0;
    double limit = 0.0;              ///< [-] friction beyond this share of mu p_n is at its limit
    double slip_tolerance = 0.0;     ///< [m]
    double gravity[3] = {0.0, 0.0, 0.0};
    bool warm_start = true;
};

/// What a kernel does with a range of batches.
enum class RestPhase {
    start,   ///< geometry, targets, and impulses of the last interval
    apply,   ///< gives the bodies the impulses
    measure, ///< gaps and slips at the predicted poses -> the targets of the velocities; the largest error of a gap [m]
    remember ///< what the contacts hand to the next interval
};

struct RestWork {
    RestPhase phase = RestPhase::start;
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    RestBlock* blocks = nullptr; ///< [batch_count]
    BatchPoint* points = nullptr; ///< all of them
    RestPoint* rest = nullptr;
    const BodyRows* begin = nullptr;   ///< [body_count]
    const BodyRows* end = nullptr;     ///< [body_count]
    const double* before = nullptr;    ///< velocities before any impulse, rows as in BatchSweep
    double* velocity = nullptr;        ///< and after them
    const unsigned* only = nullptr;    ///< [batch_count] lanes that are measured; null: all
    const RestRules* rules = nullptr;
};

/// Returns the largest error of a gap [m] where the phase is to measure, else 0.
double work_on_rest(const RestWork& work);

} // namespace sim
