/// Impulses of batches carried on beyond a sweep: TogetherSweeps::carry_on(), eight blocks at a time.
#include "sim/contact_block.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace sim {
namespace {

Mat3 symmetric_in_lane(const Lanes* from, std::size_t lane) {
    Mat3 m;
    m << from[0].x[lane], from[1].x[lane], from[2].x[lane], from[1].x[lane], from[3].x[lane], from[4].x[lane],
        from[2].x[lane], from[4].x[lane], from[5].x[lane];
    return m;
}

} // namespace

void ContactBlocks::carry_on(std::span<Velocity> velocity) {
    const auto impulses = [](const BatchPoint& point) {
        return std::array{point.p_t[0], point.p_t[1], point.p_n};
    };
    if (carried_.empty()) {
        carried_.resize(batch_points.size());
        for (std::size_t i = 0; i < carried_.size(); ++i) {
            std::ranges::copy(impulses(batch_points[i]), carried_[i].begun);
            std::ranges::copy(impulses(batch_points[i]), carried_[i].swept);
        }
        momentum_.start(change_);
        return;
    }
    along_.resize(batches.size());
    share(batches.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            along_[i] = along_step(batches[i]);
        }
    });
    const double momentum = momentum_.next(std::accumulate(along_.begin(), along_.end(), 0.0), change_);
    share_colours([&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            carry_batch(batches[i], momentum, velocity);
        }
    });
}

/// Its share of what Momentum::next() asks for.
double ContactBlocks::along_step(const BlockBatch& batch) const {
    Lanes sum{};
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        const BatchPoint& point = batch_points[static_cast<std::size_t>(k)];
        const CarriedPoint& carried = carried_[static_cast<std::size_t>(k)];
        const Lanes* p[3] = {&point.p_t[0], &point.p_t[1], &point.p_n};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t lane = 0; lane < lane_count; ++lane) {
                const double now = p[axis]->x[lane];
                sum.x[lane] += (now - carried.begun[axis].x[lane]) * (now - carried.swept[axis].x[lane]);
            }
        }
    }
    return std::accumulate(sum.x, sum.x + lane_count, 0.0);
}

/// Repeats the share `momentum` [-] of what the last sweep did to the impulses of a batch, and gives its bodies the
/// difference: apply_wrench(), lane by lane.
void ContactBlocks::carry_batch(const BlockBatch& batch, double momentum, std::span<Velocity> velocity) {
    Lanes force[3]{}; // t_1, t_2, n
    Lanes moment[3]{};
    for (int k = batch.first; k < batch.first + batch.count; ++k) {
        BatchPoint& point = batch_points[static_cast<std::size_t>(k)];
        CarriedPoint& carried = carried_[static_cast<std::size_t>(k)];
        Lanes* p[3] = {&point.p_t[0], &point.p_t[1], &point.p_n};
        Lanes added[3];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            for (std::size_t lane = 0; lane < lane_count; ++lane) {
                const double now = p[axis]->x[lane];
                added[axis].x[lane] = momentum * (now - carried.swept[axis].x[lane]);
                carried.swept[axis].x[lane] = now;
                carried.begun[axis].x[lane] = p[axis]->x[lane] = now + added[axis].x[lane];
                force[axis].x[lane] += added[axis].x[lane];
            }
        }
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            moment[0].x[lane] += added[2].x[lane] * point.y.x[lane];
            moment[1].x[lane] -= added[2].x[lane] * point.x.x[lane];
            moment[2].x[lane] += point.x.x[lane] * added[1].x[lane] - point.y.x[lane] * added[0].x[lane];
        }
    }
    for (std::size_t lane = 0; lane < lane_count && batch.block[lane] >= 0; ++lane) {
        Vec3 p = Vec3::Zero();
        Vec3 l = Vec3::Zero();
        for (int axis = 0; axis < 3; ++axis) {
            p += force[axis].x[lane] * vector_in_lane(batch.frame + 3 * axis, lane);
            l += moment[axis].x[lane] * vector_in_lane(batch.frame + 3 * axis, lane);
        }
        if (p.isZero(0.0) && l.isZero(0.0)) {
            continue;
        }
        const auto push = [&](int body, const Lanes& inverse_mass, const Lanes* inverse_inertia, const Lanes* arm,
                              double sign) {
            const Vec3 r = vector_in_lane(arm, lane);
            const Vec3 dv = sign * inverse_mass.x[lane] * p;
            const Vec3 dw = sign * (symmetric_in_lane(inverse_inertia, lane) * (r.cross(p) + l));
            velocity[static_cast<std::size_t>(body)].v += dv;
            velocity[static_cast<std::size_t>(body)].w += dw;
            activity[static_cast<std::size_t>(body)] += dv.norm() + dw.norm() * r.norm();
        };
        if ((batch.moves_a >> lane & 1u) != 0) {
            push(batch.a[lane], batch.inverse_mass_a, batch.inverse_inertia_a, batch.r_a, 1.0);
        }
        if ((batch.moves_b >> lane & 1u) != 0) {
            push(batch.b[lane], batch.inverse_mass_b, batch.inverse_inertia_b, batch.r_b, -1.0);
        }
    }
}

} // namespace sim
