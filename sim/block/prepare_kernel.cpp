/// The responses of eight blocks. The formulas are those of block_response in contact_block.cpp, which is the readable
/// form. Compiled once for each instruction set; KERNEL names it.
#include "sim/base/lanes.h"
#include "sim/block/batch.h"

namespace sim {
namespace {

LANES_INLINE int place(int i, int j) {
    return i * (i + 1) / 2 + j;
}

/// Adds a body's share to the lower triangle of a response. inertia: inverse, world; r: arm, world.
LANES_INLINE void add_body(const Real3 frame[3], const Real& inverse_mass, const Sym3& inertia, const Real3& r,
                           Real* response) {
    Real j[3][3]; // inverse inertia in the block's frame
    for (int k = 0; k < 3; ++k) {
        const Real3 column = inertia * frame[k];
        for (int i = 0; i < 3; ++i) {
            j[i][k] = dot(frame[i], column);
        }
    }
    const Real x = dot(frame[0], r);
    const Real y = dot(frame[1], r);
    const Real z = dot(frame[2], r);
    Real turn[3][3]; // j [r]x
    for (int i = 0; i < 3; ++i) {
        turn[i][0] = z * j[i][1] - y * j[i][2];
        turn[i][1] = x * j[i][2] - z * j[i][0];
        turn[i][2] = y * j[i][0] - x * j[i][1];
    }
    response[place(0, 0)] += inverse_mass + z * turn[1][0] - y * turn[2][0];
    response[place(1, 0)] += x * turn[2][0] - z * turn[0][0];
    response[place(1, 1)] += inverse_mass + x * turn[2][1] - z * turn[0][1];
    response[place(2, 0)] += y * turn[0][0] - x * turn[1][0];
    response[place(2, 1)] += y * turn[0][1] - x * turn[1][1];
    response[place(2, 2)] += inverse_mass + y * turn[0][2] - x * turn[1][2];
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            response[place(3 + i, k)] += turn[i][k];
        }
        for (int k = 0; k <= i; ++k) {
            response[place(3 + i, 3 + k)] += j[i][k];
        }
    }
}

/// Largest eigenvalue of K_tt at a point of the block.
LANES_INLINE Real largest_eigenvalue(const Real* w, const Real& x, const Real& y) {
    const Real w_05 = w[place(5, 0)];
    const Real w_15 = w[place(5, 1)];
    const Real w_55 = w[place(5, 5)];
    const Real k_11 = w[place(0, 0)] - 2.0 * (y * w_05) + y * y * w_55;
    const Real k_22 = w[place(1, 1)] + 2.0 * (x * w_15) + x * x * w_55;
    const Real k_12 = w[place(1, 0)] + x * w_05 - y * w_15 - x * y * w_55;
    const Real half_trace = 0.5 * (k_11 + k_22);
    return half_trace + sqrt(max(half_trace * half_trace - (k_11 * k_22 - k_12 * k_12), real(0.0)));
}

} // namespace

void KERNEL(const BatchPreparation& preparation) {
    for (std::size_t i = 0; i < preparation.batch_count; ++i) {
        BlockBatch& batch = preparation.batches[i];
        const Real3 frame[3] = {load3(batch.frame), load3(batch.frame + 3), load3(batch.frame + 6)};
        Real response[21];
        for (Real& value : response) {
            value = real(0.0);
        }
        add_body(frame, load(batch.inverse_mass_a), load_sym(batch.inverse_inertia_a), load3(batch.r_a), response);
        add_body(frame, load(batch.inverse_mass_b), load_sym(batch.inverse_inertia_b), load3(batch.r_b), response);
        for (int k = 0; k < 21; ++k) {
            store(batch.response[k], response[k]);
        }
        // Points that are not there lie at the centre, where K_tt, convex in the place, is not the largest.
        Real k_t = real(0.0);
        for (int k = 0; k < batch.count; ++k) {
            const BatchPoint& point = preparation.points[batch.first + k];
            k_t = max(k_t, largest_eigenvalue(response, load(point.x), load(point.y)));
        }
        store(batch.k_t, k_t);
    }
}

} // namespace sim
