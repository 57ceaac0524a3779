#pragma once
/// Contact blocks, eight at a time.
///
/// A batch holds blocks of which no two move the same body, so its lanes are solved independently and the
/// arithmetic of a block does not depend on its neighbours, on the width of the processor's registers or on the
/// number of threads. This header knows no library: the kernels are compiled once for each instruction set.
#include "sim/base/lane_count.h"

#include <cstddef>

namespace sim {

/// Most contacts in one block: a face of a box clipped by another has at most eight corners, and a crossing
/// of edges.
inline constexpr int block_size = 9;

/// Target [m/s] of a point that is not there: its velocity is always far above it, and far from one that was seen to be this.
inline constexpr double no_point = -1e300;

/// Points nearer to a line (or to each other) than this share [-] of their extent count as lying on it.
inline constexpr double collinear = 1e-7;

/// Differences of less than this share [-] of the terms are rounding.
inline constexpr double rounding_share = 1e-12;

/// Normals, or friction and its limit mu p_n, that differ by less than this share [-] are the same: rounding that has grown.
inline constexpr double same_share = 1e-9;

/// Two rows of 64 bytes of a body. As the interval begins: inverse mass [1/kg] and inverse inertia tensor [1/(kg m^2)]
/// (xx xy xz yy yz zz); position, orientation (x y z w) and bounding radius [m] in the second. As predicted at its end: rotation
/// since then (row by row), position.
struct alignas(64) BodyRows {
    double x[16];
};

/// Point k of each block of a batch. Lanes with fewer points hold one that is never loaded.
struct BatchPoint {
    BatchPoint() {} // no zeros, which of a whole heap take time, too: Blocks::fill_batch() writes all members

    /// [m] In the contact plane, from the block's centre, along t_1 and t_2. In seven digits: gaps depend on them by what the
    /// bodies turn in an interval only.
    ShortLanes x, y;
    Lanes gap;           ///< [m] as the interval begins
    Lanes u_n_target;    ///< [m/s]
    Lanes u_t_target[2]; ///< of a sticking contact [m/s]
    Lanes p_n;           ///< sum of the normal impulses [N s]
    Lanes p_t[2];        ///< sum of the friction impulses [N s]
    ShortLanes height;   ///< [m] of the point on a along n, from the block's centre on a; as with x and y
    unsigned there;      ///< bit l: lane l has this point
    // Of resting contacts; here, as a row of 64 bytes has room for them.
    unsigned edges;    ///< bit l: crossing edges touch there
    unsigned wandered; ///< bit l: once in this interval the touch of edges or of a rim has wandered too far; see wander_share
    unsigned ahead;    ///< bit l: speculative, placed before its impact
    unsigned closing;  ///< bit l: an impact: without impulses, and where the block touches without a fall, its gap would close
};

/// Eight blocks in lanes. The frame of a block: t_1, t_2, n at the mean contact point, in the plane of the contact that
/// touches first.
struct BlockBatch {
    BlockBatch() {} // as with BatchPoint

    int a[lane_count];     ///< body of each lane
    int b[lane_count];
    int block[lane_count]; ///< index of its block; -1: an empty lane
    int first;             ///< index of its first BatchPoint
    int count;             ///< [-] points of a lane: 1, 2, 4, 6 or block_size
    unsigned moves_a;      ///< bit l: body a of lane l is not static
    unsigned moves_b;
    unsigned led;          ///< bit l: a body of lane l is led by keys, see BodyProps
    unsigned face_of_a;    ///< bit l: a face of a against points of b
    unsigned sticking;     ///< bit l: the mark of eq. 6
    bool has_friction;
    Lanes t1[3];       ///< t_2 is n x t_1
    Lanes n[3];
    Lanes r_a[3];      ///< middle of the contacts on a from its centre of mass [m]
    Lanes r_b[3];
    Lanes nearest_gap; ///< [m] of the contact in whose plane the impulses act
    Lanes response[21]; ///< of the relative twist to a unit wrench (K and its angular parts): lower triangle, row by row
    Lanes before[3];    ///< u_1, u_2 [m/s], w_n [rad/s] before any impulse of this solve
    Lanes mu;           ///< mu_s of a sticking block, mu_d of a sliding one
    /// Share [-] of the impulses at which the sliding direction is taken: of a step's impulses the part that acts before
    /// t0; 1 (the velocity after) in a collision, where sticking and sliding are then one law.
    Lanes node_weight;
    Lanes per_k_t;        ///< [kg] 1 / the largest eigenvalue of K_tt over the points
    Lanes seen[6]; ///< u_1, u_2, u_n [m/s], w_1, w_2, w_n [rad/s] as the last visit left them; u_n `no_point`: to be visited again
    Lanes change;  ///< [m/s] largest of a velocity at its points, by the last sweep
};

/// Fills in what does not change while batches are iterated; impulses are zero, targets and marks unset.
struct BatchPreparation {
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    BatchPoint* points = nullptr;
    /// Rows that begin with gap, n, a of the contact of point k in lane l at [lane_count * k + l], of one batch.
    const double* const* at = nullptr;
    const BodyRows* rows = nullptr;   ///< [body_count] as the interval begins
    const double* velocity = nullptr; ///< before any impulse; rows as in BatchSweep
};
void prepare_batches(const BatchPreparation& preparation);

/// What a sweep over batches needs beside them.
struct BatchSweep {
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    BatchPoint* points = nullptr;
    const BodyRows* rows = nullptr; ///< [body_count] as the interval begins
    double* velocity = nullptr;     ///< rows of 8: v, w, two unused; rows of 64 bytes, aligned
    double skip = 0.0; ///< [m/s] blocks at whose points velocities changed by no more are passed over
    /// [m/s] targets that a rigid motion misses by no more are met on average, and the load is shared smoothly;
    /// else fewer points carry it.
    double tolerance = 0.0;
    double softness = 0.0; ///< [-] normal impulses on led bodies give way by this share of what they change
    bool by_half = false;  ///< half of what each visit finds is taken at most, and it is to be visited again
};

/// Once over all batches, in order; returns the largest velocity change at any point [m/s].
double sweep_batches(const BatchSweep& sweep);

/// Impulses p_t, p_n [N s] of a BatchPoint: as the last sweep began, and as the one before it ended.
struct ExtrapolatedPoint {
    ExtrapolatedPoint() {} // as with BatchPoint

    Lanes begun[3];
    Lanes swept[3];
};

/// What the impulses' last step, from the end of a sweep to that of the next, has of what was extrapolated between these, and of
/// what the sweep did: products with it [N^2 s^2].
struct StepParts {
    double extrapolated = 0.0;
    double swept = 0.0;
};

/// Impulses of batches, extrapolated after a sweep.
struct BatchExtrapolation {
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    BatchPoint* points = nullptr;
    ExtrapolatedPoint* before = nullptr;  ///< of the same points
    StepParts* parts = nullptr; ///< [batch_count] then only this is found; null: they are extrapolated
    double share = 0.0;         ///< [-] share of the last sweep's step that is repeated
    const BodyRows* rows = nullptr; ///< this and velocity as in BatchSweep
    double* velocity = nullptr;
};
void extrapolate_batches(const BatchExtrapolation& work);

} // namespace sim
