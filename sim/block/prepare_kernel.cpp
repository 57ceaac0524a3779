/// Frames, points and responses of eight blocks. Compiled once for each instruction set; KERNEL names it.
#include "sim/block/lane_twist.h"

namespace sim {
namespace {

/// Element (i, j), i >= j, of a symmetric matrix.
LANES_INLINE int at(int i, int j) {
    return i * (i + 1) / 2 + j;
}

/// A unit vector across n: from the world axis that is least along n, so it turns continuously with n.
LANES_INLINE Real3 tangent_of(const Real3& n) {
    const Real zero = real(0.0);
    const Mask by_x = (abs(n.x) <= abs(n.y)) & (abs(n.x) <= abs(n.z));
    const Mask by_y = abs(n.y) <= abs(n.z);
    const Real3 t = select(by_x, Real3{zero, n.z, -n.y}, select(by_y, Real3{-n.z, zero, n.x}, Real3{n.y, -n.x, zero}));
    return (1.0 / sqrt(dot(t, t))) * t;
}

/// Centre, frame and points of the blocks of these lanes, whose bodies have the rows a and b.
LANES_INLINE void place(const BatchPreparation& preparation, BlockBatch& batch, Window lanes, const Real* a, const Real* b) {
    BatchPoint* points = preparation.points + batch.first;
    const Real zero = real(0.0);
    Real3 on_a[block_size];
    Real gap[block_size];
    Real3 n{zero, zero, real(1.0)};
    Real count = zero;
    Real3 mean{zero, zero, zero};
    for (int k = 0; k < batch.count; ++k) {
        Real row[8];
        gather([&](int l) { return preparation.at[lane_count * k + lanes.first + l]; }, row);
        gap[k] = row[0];
        on_a[k] = {row[4], row[5], row[6]};
        n = k == 0 ? Real3{row[1], row[2], row[3]} : n;
        const Real here = flag(lanes.lanes_of(points[k].there));
        count += here;
        mean = mean + here * on_a[k];
    }
    mean = (1.0 / max(count, real(1.0))) * mean;
    // The plane in which the impulses act is that of the contact that touches first; others are still apart.
    Real nearest_gap = gap[0];
    Real3 nearest = on_a[0];
    for (int k = 1; k < batch.count; ++k) {
        const Mask nearer = lanes.lanes_of(points[k].there) & (gap[k] < nearest_gap);
        nearest_gap = select(nearer, gap[k], nearest_gap);
        nearest = select(nearer, on_a[k], nearest);
    }
    const Real3 centre = mean + dot(n, nearest - mean) * n;
    lanes.store3(batch.r_a, centre - Real3{a[8], a[9], a[10]});
    lanes.store3(batch.r_b, centre - nearest_gap * n - Real3{b[8], b[9], b[10]});
    lanes.store(batch.nearest_gap, nearest_gap);
    const Real3 t1 = tangent_of(n);
    const Real3 t2 = cross(n, t1);
    lanes.store3(batch.t1, t1);
    lanes.store3(batch.n, n);
    const Twist before = twist_of(preparation.velocity, batch, {t1, t2, n}, lanes);
    lanes.store3(batch.before, {before.u.x, before.u.y, before.w.z});
    lanes.store(batch.node_weight, real(1.0));
    lanes.store(batch.change, zero);
    for (Lanes& seen : batch.seen) {
        lanes.store(seen, real(no_point));
    }
    for (int k = 0; k < batch.count; ++k) {
        BatchPoint& point = points[k];
        const Mask there = lanes.lanes_of(point.there);
        lanes.store(point.x, flag(there) * dot(t1, on_a[k] - mean));
        lanes.store(point.y, flag(there) * dot(t2, on_a[k] - mean));
        lanes.store(point.gap, gap[k]);
        lanes.store(point.height, dot(n, on_a[k] - nearest));
        lanes.store(point.u_n_target, select(there, zero, real(no_point)));
        Lanes* const at_zero[] = {&point.u_t_target[0], &point.u_t_target[1], &point.p_n, &point.p_t[0], &point.p_t[1]};
        for (Lanes* value : at_zero) {
            lanes.store(*value, zero);
        }
    }
}

/// Adds a body's share to the lower triangle of a response. row: of the body; r: arm, world.
LANES_INLINE void add_body(const Real3 frame[3], const Real* row, const Real3& r, Real* response) {
    const Real& inverse_mass = row[0];
    const Sym3 inertia{row[1], row[2], row[3], row[4], row[5], row[6]};
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
    response[at(0, 0)] += inverse_mass + z * turn[1][0] - y * turn[2][0];
    response[at(1, 0)] += x * turn[2][0] - z * turn[0][0];
    response[at(1, 1)] += inverse_mass + x * turn[2][1] - z * turn[0][1];
    response[at(2, 0)] += y * turn[0][0] - x * turn[1][0];
    response[at(2, 1)] += y * turn[0][1] - x * turn[1][1];
    response[at(2, 2)] += inverse_mass + y * turn[0][2] - x * turn[1][2];
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            response[at(3 + i, k)] += turn[i][k];
        }
        for (int k = 0; k <= i; ++k) {
            response[at(3 + i, 3 + k)] += j[i][k];
        }
    }
}

/// Largest eigenvalue of K_tt at a point of the block.
LANES_INLINE Real largest_eigenvalue(const Real* w, const Real& x, const Real& y) {
    const Real w_05 = w[at(5, 0)];
    const Real w_15 = w[at(5, 1)];
    const Real w_55 = w[at(5, 5)];
    const Real k_11 = w[at(0, 0)] - 2.0 * (y * w_05) + y * y * w_55;
    const Real k_22 = w[at(1, 1)] + 2.0 * (x * w_15) + x * x * w_55;
    const Real k_12 = w[at(1, 0)] + x * w_05 - y * w_15 - x * y * w_55;
    const Real half_trace = 0.5 * (k_11 + k_22);
    return half_trace + sqrt(max(half_trace * half_trace - (k_11 * k_22 - k_12 * k_12), real(0.0)));
}

/// All that does not change while these lanes are iterated.
LANES_INLINE void prepare(const BatchPreparation& preparation, BlockBatch& batch, Window lanes) {
    BatchPoint* points = preparation.points + batch.first;
    Real a[16];
    Real b[16];
    gather_two(preparation.rows->x, batch.a + lanes.first, a);
    gather_two(preparation.rows->x, batch.b + lanes.first, b);
    place(preparation, batch, lanes, a, b);
    const Frame f = frame_of(batch, lanes);
    const Real3 frame[3] = {f.t1, f.t2, f.n};
    Real response[21];
    for (Real& value : response) {
        value = real(0.0);
    }
    add_body(frame, a, lanes.load3(batch.r_a), response);
    add_body(frame, b, lanes.load3(batch.r_b), response);
    // In lanes that are not there the equations have a solution, too.
    const Mask there = lanes.lanes_of(points[0].there);
    for (int row = 0; row < 6; ++row) {
        for (int k = 0; k <= row; ++k) {
            lanes.store(batch.response[at(row, k)], select(there, response[at(row, k)], real(row == k ? 1.0 : 0.0)));
        }
    }
    // Points that are not there lie at the centre, where K_tt, convex in the place, is not the largest.
    Real k_t = real(0.0);
    for (int k = 0; k < batch.count; ++k) {
        k_t = max(k_t, largest_eigenvalue(response, lanes.load(points[k].x), lanes.load(points[k].y)));
    }
    lanes.store(batch.per_k_t, 1.0 / k_t);
}

} // namespace

void KERNEL(const BatchPreparation& preparation) {
    for (std::size_t i = 0; i < preparation.batch_count; ++i) {
        BlockBatch& batch = preparation.batches[i];
        batch.sticking = 0;
        for (Window lanes; lanes.first < lane_count; lanes.first += width) {
            prepare(preparation, batch, lanes);
        }
    }
}

} // namespace sim
