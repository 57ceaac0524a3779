/// What enters the active set of Newton's method, and what a step is taken back to.
#include "sim/block/blocks.h"
#include "sim/block/newton.h"

#include <algorithm>

namespace sim {

IslandNewton::PointState IslandNewton::state_of(const BatchPoint& point, std::size_t lane, const Vec6& twist) {
    const LanePoint at(point, lane);
    if ((point.there >> lane & 1u) == 0) {
        return {};
    }
    const Vec2 u_t = at.tangential_velocity(twist);
    return {{at.p_t.x(), at.p_t.y(), at.p_n},
            {u_t.x() - point.u_t_target[0].x[lane], u_t.y() - point.u_t_target[1].x[lane],
             at.normal_velocity(twist) - point.u_n_target.x[lane]}};
}

/// Calls visit(batch, lane, points) for the blocks of an island.
template <typename F>
void IslandNewton::for_each_block(Blocks& loop, const Island& island, F&& visit) {
    for (const int i : island.blocks) {
        const Block& block = loop.blocks[static_cast<std::size_t>(i)];
        const BlockBatch& batch = loop.batch_of(block);
        visit(batch, Blocks::lane_of(block), loop.points_of(batch));
    }
}

/// Which bodies contacts push.
void IslandNewton::find_loaded(Blocks& loop, const Island& island, std::span<const int> place) {
    is_loaded_.assign(island.bodies.size(), 0);
    for_each_block(loop, island, [&](const BlockBatch& batch, std::size_t lane, std::span<const BatchPoint> points) {
        const auto pushes = [&](const BatchPoint& point) { return point.p_n.x[lane] > 0.0; };
        for (const int body : {batch.a[lane], batch.b[lane]}) {
            if (const int at = place[static_cast<std::size_t>(body)]; at >= 0 && std::ranges::any_of(points, pushes)) {
                is_loaded_[static_cast<std::size_t>(at)] = 1;
            }
        }
    });
}

/// Points without a load that part slower than they are to by more than `least` [m/s] enter the set (eq. 2, 3): they get next to
/// nothing of the impulse that would mend it. Bodies that nothing pushes yet fall together, as those of a tower that was put down: they
/// enter with all points that do not part faster, or each set would take up one more of them
/// (`law_funnel_settings.a_tower_that_is_put_down...`). Returns whether there are any.
bool IslandNewton::enter_set(Blocks& loop, const Island& island, std::span<const int> place, std::span<const Velocity> velocity,
                             double least) const {
    const auto falls = [&](int body) {
        const int at = place[static_cast<std::size_t>(body)];
        return at >= 0 && is_loaded_[static_cast<std::size_t>(at)] == 0;
    };
    bool any = false;
    for_each_block(loop, island, [&](const BlockBatch& batch, std::size_t lane, std::span<BatchPoint> points) {
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(velocity);
        const double enough = falls(batch.a[lane]) || falls(batch.b[lane]) ? -least : least;
        for (BatchPoint& point : points) {
            const LanePoint at(point, lane);
            const double missing = point.u_n_target.x[lane] - at.normal_velocity(twist);
            if (at.p_n == 0.0 && missing > enough) {
                const double along_n = batch.response[5].x[lane]; // [1/kg]
                point.p_n.x[lane] = rounding_share * std::max(missing, least) / along_n;
                any = true;
            }
        }
    });
    return any;
}

/// What a step may have to be taken back to.
void IslandNewton::begin(Blocks& loop, const Island& island, std::span<const Velocity> velocity) {
    begun_.clear();
    for_each_block(loop, island, [&](const BlockBatch& batch, std::size_t lane, std::span<const BatchPoint> points) {
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(velocity);
        for (const BatchPoint& point : points) {
            begun_.push_back(state_of(point, lane, twist));
        }
    });
    begun_velocity_.clear();
    for (const int body : island.bodies) {
        begun_velocity_.push_back(velocity[static_cast<std::size_t>(body)]);
    }
    if (!island.assemblies.empty()) {
        loop.joints->keep(island.assemblies);
    }
}

/// Impulses p minimise p.A p / 2 + b.p, where A p + b is what they miss. Has the step made that less?
bool IslandNewton::is_nearer(Blocks& loop, const Island& island, std::span<const Velocity> velocity) const {
    double change = 0.0; // [J]
    auto begun = begun_.begin();
    for_each_block(loop, island, [&](const BlockBatch& batch, std::size_t lane, std::span<const BatchPoint> points) {
        const Vec6 twist = LaneFrame(batch, lane).relative_twist(velocity);
        for (const BatchPoint& point : points) {
            const PointState now = state_of(point, lane, twist);
            change += 0.5 * (now.impulse - begun->impulse).dot(now.missed + begun->missed);
            ++begun;
        }
    });
    return change < 0.0;
}

void IslandNewton::take_back(Blocks& loop, const Island& island, std::span<Velocity> velocity) const {
    auto begun = begun_.begin();
    for_each_block(loop, island, [&](const BlockBatch&, std::size_t lane, std::span<BatchPoint> points) {
        for (BatchPoint& point : points) {
            const Vec3& impulse = begun++->impulse;
            point.p_t[0].x[lane] = impulse.x();
            point.p_t[1].x[lane] = impulse.y();
            point.p_n.x[lane] = impulse.z();
        }
    });
    for (std::size_t i = 0; i < island.bodies.size(); ++i) {
        velocity[static_cast<std::size_t>(island.bodies[i])] = begun_velocity_[i];
    }
    if (!island.assemblies.empty()) {
        loop.joints->take_kept(island.assemblies);
    }
}

} // namespace sim
