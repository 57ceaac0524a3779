/// One sweep over batches of blocks. Compiled once for each instruction set; KERNEL names it.
#include "sim/block/solve.h"

namespace sim {
namespace {

/// Solves the blocks of a batch with all others held, where velocities at their points changed by more than `skip` since the
/// last time. Returns the largest change of each lane.
template <int N>
Real visit_batch(const BatchSweep& sweep, BlockBatch& batch) {
    Visit<N> v(batch, sweep.points + batch.first);
    const Frame f = frame_of(batch);
    v.twist = twist_of(sweep.velocity, batch, f);
    for (int k = 0; k < N; ++k) {
        v.x[k] = load(v.points[k].x);
        v.y[k] = load(v.points[k].y);
    }
    const Real zero = real(0.0);
    const Mask there = lanes_of(v.points[0].there);
    const Twist seen{load3(batch.seen), load3(batch.seen + 3)};
    const Twist since{v.twist.u - seen.u, v.twist.w - seen.w};
    if (!any(there & (v.largest_square(since) > sweep.skip * sweep.skip))) {
        store(batch.change, zero);
        return zero;
    }
    v.force = v.moment = {zero, zero, zero};
    v.change = v.left = zero;
    for (int k = 0; k < N; ++k) {
        const BatchPoint& point = v.points[k];
        v.p_n[k] = load(point.p_n);
        v.p_1[k] = load(point.p_t[0]);
        v.p_2[k] = load(point.p_t[1]);
    }
    v.solve_normals(real(sweep.tolerance));
    if (batch.has_friction) {
        v.solve_friction();
    }
    for (int k = 0; k < N; ++k) {
        store(v.points[k].p_n, v.p_n[k]);
        store(v.points[k].p_t[0], v.p_1[k]);
        store(v.points[k].p_t[1], v.p_2[k]);
    }
    push_bodies(sweep.rows, sweep.velocity, batch, f.world(v.force), f.world(v.moment));
    const Real change = select(there, v.change, zero);
    store3(batch.seen, {v.twist.u.x, v.twist.u.y, select(v.left > sweep.skip, real(no_point), v.twist.u.z)});
    store3(batch.seen + 3, v.twist.w);
    store(batch.change, change);
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
    Lanes of_lane;
    store(of_lane, worst);
    double largest = 0.0;
    for (const double change : of_lane.x) {
        largest = largest < change ? change : largest;
    }
    return largest;
}

} // namespace sim
