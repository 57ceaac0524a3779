#pragma once
/// Contact blocks, eight at a time: the fast form of solve_block (block_solve.cpp), lane by lane the same equations.
///
/// A batch holds blocks of which no two move the same body, so its lanes are solved independently and the
/// arithmetic of a block does not depend on its neighbours, on the width of the processor's registers or on the
/// number of threads. This header knows no library: block_kernel.cpp is compiled once for each instruction set.
#include "sim/base/lane_count.h"

#include <cstddef>

namespace sim {

/// Point k of each block of a batch; see ContactPoint. Lanes with fewer points hold one that is never loaded.
struct BatchPoint {
    Lanes x, y;
    Lanes u_n_target;
    Lanes u_t_target[2];
    Lanes p_n;
    Lanes p_t[2];
};

/// Eight blocks in lanes; see ContactBlock.
struct BlockBatch {
    int a[lane_count];  ///< body of each lane
    int b[lane_count];
    int block[lane_count]; ///< index of its block; -1: an empty lane
    int first = 0;      ///< index of its first BatchPoint
    int count = 0;      ///< [-] points of a lane: 1, 2, 4, 6 or block_size
    unsigned moves_a = 0; ///< bit l: body a of lane l is not static
    unsigned moves_b = 0;
    unsigned flat = 0;      ///< bit l: see ContactBlock::is_flat
    unsigned face_of_a = 0; ///< bit l: see ContactBlock::is_face_of_a
    bool has_friction = false;
    Lanes frame[9];     ///< t_1, t_2, n, each x y z
    Lanes r_a[3];       ///< [m]
    Lanes r_b[3];
    Lanes inverse_mass_a, inverse_mass_b;
    Lanes inverse_inertia_a[6]; ///< xx xy xz yy yz zz
    Lanes inverse_inertia_b[6];
    Lanes response[21];     ///< lower triangle, row by row
    Lanes before[3];        ///< u_1, u_2, w_n before any impulse: u_t_before of the points
    Lanes mu;               ///< mu_s of a sticking block, mu_d of a sliding one
    Lanes sticking;         ///< 1: the mark of eq. 6
    Lanes node_weight;
    Lanes k_t;
    Lanes seen_a, seen_b;   ///< activity when last solved; negative: never
};

/// Fills in response and k_t of all lanes, from the rest of a batch that does not change.
struct BatchPreparation {
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    const BatchPoint* points = nullptr;
};
void prepare_batches(const BatchPreparation& preparation);

/// What is left of the errors of all gaps after sweeps, where it is linear in the velocities' changes.
struct BatchCheck {
    const BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    const BatchPoint* points = nullptr;
    const double* velocity = nullptr; ///< rows as in BatchSweep
    const double* measured = nullptr; ///< the same when the gaps were measured
    const double* radius = nullptr;   ///< [m] [body_count] of the bodies around their centres; static: 0
    double h = 0.0;                   ///< [s] the interval
    double bend = 0.0;                ///< [m] gaps may be so far from linear
    unsigned* unsure = nullptr;       ///< [batch_count] then bit l: lane l bends more, and is not looked at
};
/// Returns the largest error of a gap [m], two-sided where a point carries load.
double check_batches(const BatchCheck& check);

/// What a sweep over batches needs beside them.
struct BatchSweep {
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    BatchPoint* points = nullptr;
    double* velocity = nullptr; ///< rows of 8: v, w, two unused; rows of 64 bytes, aligned
    double* activity = nullptr; ///< [body_count] sum of the velocity changes of each body's blocks [m/s]
    double skip = 0.0;          ///< [m/s] blocks whose bodies changed by less are passed over
    /// [m/s] targets that a rigid motion misses by no more are met on average, and the load is shared smoothly;
    /// else fewer points carry it.
    double slack = 0.0;
    int projections = 0; ///< [-] within one friction solve
};

/// Once over all batches, in order; returns the largest velocity change at any point [m/s].
double sweep_batches(const BatchSweep& sweep);

/// Impulses p_t, p_n [N s] of a BatchPoint: as the last sweep began, and as the one before it ended.
struct CarriedPoint {
    Lanes begun[3];
    Lanes swept[3];
};

/// Impulses of batches, carried on after a sweep.
struct BatchCarry {
    const BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    BatchPoint* points = nullptr;
    CarriedPoint* carried = nullptr; ///< of the same points
    double* along = nullptr;    ///< [batch_count] then see Momentum::next: only this is found; null: they are carried on
    double momentum = 0.0;      ///< [-] share of the last sweep's step that is repeated
    double* velocity = nullptr; ///< rows as in BatchSweep
    double* activity = nullptr; ///< see BatchSweep
};
void carry_batches(const BatchCarry& carry);

} // namespace sim
