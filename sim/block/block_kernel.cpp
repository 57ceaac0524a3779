/// One sweep over batches of blocks. Compiled once for each instruction set; KERNEL names it.
#include "sim/block/solve.h"

namespace sim {
namespace {

/// Solves the blocks of these lanes with all others held. Returns the largest change of each lane.
template <int N>
LANES_INLINE Real visit_lanes(const BatchSweep& sweep, BlockBatch& batch, Visit<N>& v) {
    const Real zero = real(0.0);
    v.force = v.moment = {zero, zero, zero};
    v.change = v.left = zero;
    for (int k = 0; k < N; ++k) {
        const BatchPoint& point = v.points[k];
        v.p_n[k] = v.load(point.p_n);
        v.p_1[k] = v.load(point.p_t[0]);
        v.p_2[k] = v.load(point.p_t[1]);
    }
    v.solve_normals(real(sweep.tolerance));
    if (batch.has_friction) {
        v.solve_friction();
    }
    for (int k = 0; k < N; ++k) {
        BatchPoint& point = v.points[k];
        v.store(point.p_n, v.p_n[k]);
        v.store(point.p_t[0], v.p_1[k]);
        v.store(point.p_t[1], v.p_2[k]);
    }
    const Frame f = frame_of(batch, v);
    push_bodies(sweep.rows, sweep.velocity, batch, v, f.world(v.force), f.world(v.moment));
    const Real change = select(v.lanes_of(v.points[0].there), v.change, zero);
    v.store3(batch.seen, {v.twist.u.x, v.twist.u.y, select(v.left > sweep.skip, real(no_point), v.twist.u.z)});
    v.store3(batch.seen + 3, v.twist.w);
    v.store(batch.change, change);
    return change;
}

/// The same for all lanes, where velocities at the points of one of them changed by more than `skip` since the last time.
template <int N>
Real visit_batch(const BatchSweep& sweep, BlockBatch& batch) {
    BatchPoint* points = sweep.points + batch.first;
    Twist twist[lane_count / width];
    bool is_due = false;
    for (int first = 0; first < lane_count; first += width) {
        const Visit<N> v(batch, points, first);
        const Twist now = twist[first / width] = twist_of(sweep.velocity, batch, frame_of(batch, v), v);
        const Twist since{now.u - v.load3(batch.seen), now.w - v.load3(batch.seen + 3)};
        is_due = is_due || any(v.lanes_of(points[0].there) & (v.largest_square(since) > sweep.skip * sweep.skip));
    }
    Real change = real(0.0);
    if (!is_due) {
        batch.change = {};
        return change;
    }
    for (int first = 0; first < lane_count; first += width) {
        Visit<N> v(batch, points, first);
        v.twist = twist[first / width];
        change = max(change, visit_lanes(sweep, batch, v));
    }
    return change;
}

Real visit_batch(const BatchSweep& sweep, BlockBatch& batch) {
    switch (batch.count) {
    case 1:
        return visit_batch<1>(sweep, batch);
    case 2:
        return visit_batch<2>(sweep, batch);
    case 4:
        return visit_batch<4>(sweep, batch);
    case 6:
        return visit_batch<6>(sweep, batch);
    default:
        return visit_batch<9>(sweep, batch);
    }
}

} // namespace

double KERNEL(const BatchSweep& sweep) {
    Real worst = real(0.0);
    for (std::size_t i = 0; i < sweep.batch_count; ++i) {
        worst = max(worst, visit_batch(sweep, sweep.batches[i]));
    }
    double largest = 0.0;
    for (int l = 0; l < width; ++l) {
        largest = largest < worst[l] ? worst[l] : largest;
    }
    return largest;
}

} // namespace sim
