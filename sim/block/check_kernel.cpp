/// What is left of the gaps' errors, eight blocks at a time.
/// Compiled once for each instruction set; KERNEL names it.
#include "sim/base/lanes.h"
#include "sim/block/batch.h"

namespace sim {
namespace {

/// Velocity and angular velocity of the bodies of all lanes.
struct Motion {
    Real3 v, w;
};

LANES_INLINE Motion motion_of(const double* velocity, const int* body) {
    Real rows[8];
    gather(velocity, body, rows);
    return {{rows[0], rows[1], rows[2]}, {rows[3], rows[4], rows[5]}};
}

LANES_INLINE Real gather_radius(const double* radius, const int* body) {
    Lanes r;
    for (int l = 0; l < lane_count; ++l) {
        r.x[l] = radius[body[l]];
    }
    return load(r);
}

/// How far the gaps may be from linear [m]: turning and moving between two predicted poses, to second order.
LANES_INLINE Real bend(const BatchCheck& check, const BlockBatch& batch, const Motion& a, const Motion& b) {
    const Motion a0 = motion_of(check.measured, batch.a);
    const Motion b0 = motion_of(check.measured, batch.b);
    const Real turn_a = max(norm(a.w), norm(a0.w));
    const Real turn_b = max(norm(b.w), norm(b0.w));
    const Real bound = norm(a.w - a0.w) * turn_a * gather_radius(check.radius, batch.a) +
                       norm(b.w - b0.w) * turn_b * gather_radius(check.radius, batch.b);
    return (check.h * check.h) * (bound + (turn_a + turn_b) * norm((a.v - a0.v) - (b.v - b0.v)));
}

} // namespace

double KERNEL(const BatchCheck& check) {
    double worst = 0.0;
    for (std::size_t i = 0; i < check.batch_count; ++i) {
        const BlockBatch& batch = check.batches[i];
        const Motion a = motion_of(check.velocity, batch.a);
        const Motion b = motion_of(check.velocity, batch.b);
        const Real3 u = a.v + cross(a.w, load3(batch.r_a)) - (b.v + cross(b.w, load3(batch.r_b)));
        const Real3 w = a.w - b.w;
        const Real u_n = dot(load3(batch.frame + 6), u);
        const Real w_1 = dot(load3(batch.frame), w);
        const Real w_2 = dot(load3(batch.frame + 3), w);
        Real missing = real(-__builtin_inf());
        for (int k = 0; k < batch.count; ++k) {
            const BatchPoint& point = check.points[batch.first + k];
            const Real below = load(point.u_n_target) - (u_n + w_1 * load(point.y) - w_2 * load(point.x));
            missing = max(missing, select(load(point.p_n) > 0.0, abs(below), below));
        }
        Lanes bends;
        Lanes errors;
        store(bends, bend(check, batch, a, b));
        store(errors, check.h * missing);
        unsigned unsure = 0;
        for (int l = 0; l < lane_count; ++l) {
            if (batch.block[l] < 0) {
                continue;
            }
            if ((batch.flat >> l & 1u) != 0 && bends.x[l] <= check.bend) {
                worst = worst < errors.x[l] ? errors.x[l] : worst;
            } else {
                unsure |= 1u << l;
            }
        }
        check.unsure[i] = unsure;
    }
    return worst;
}

} // namespace sim
