#include "sim/contact_block.h"

#include <algorithm>
#include <bit>

namespace sim {
namespace {

/// Colours a body's blocks can have before the rest of them are visited one by one.
constexpr int colour_limit = 64;

/// Point of an empty place: its velocity is always far above the target.
constexpr double never = -1e300;

/// Points of a lane in a batch that holds blocks of `count` points.
int padded_count(int count) {
    return count <= 2 ? count : count <= 4 ? 4 : count <= 6 ? 6 : block_size;
}

void set_vector(Lanes* to, std::size_t lane, const Vec3& v) {
    for (int i = 0; i < 3; ++i) {
        to[i].x[lane] = v[i];
    }
}

void set_symmetric(Lanes* to, std::size_t lane, const Mat3& m) {
    const double values[6] = {m(0, 0), m(0, 1), m(0, 2), m(1, 1), m(1, 2), m(2, 2)};
    for (int i = 0; i < 6; ++i) {
        to[i].x[lane] = values[i];
    }
}

/// Puts what does not change while a block is iterated into its lane.
void fill_lane(BlockBatch& batch, std::size_t lane, const ContactBlock& block, const Bodies& bodies) {
    const auto a = static_cast<std::size_t>(block.a);
    const auto b = static_cast<std::size_t>(block.b);
    batch.a[lane] = block.a;
    batch.b[lane] = block.b;
    batch.moves_a |= static_cast<unsigned>(!bodies.props[a].is_static()) << lane;
    batch.moves_b |= static_cast<unsigned>(!bodies.props[b].is_static()) << lane;
    batch.has_friction = batch.has_friction || block.has_friction();
    for (int axis = 0; axis < 3; ++axis) {
        set_vector(batch.frame + 3 * axis, lane, block.frame.col(axis));
    }
    set_vector(batch.r_a, lane, block.r_a);
    set_vector(batch.r_b, lane, block.r_b);
    batch.inverse_mass_a.x[lane] = bodies.props[a].inverse_mass;
    batch.inverse_mass_b.x[lane] = bodies.props[b].inverse_mass;
    set_symmetric(batch.inverse_inertia_a, lane, bodies.inverse_inertia[a]);
    set_symmetric(batch.inverse_inertia_b, lane, bodies.inverse_inertia[b]);
    batch.node_weight.x[lane] = block.node_weight;
    batch.flat |= static_cast<unsigned>(block.is_flat) << lane;
}

/// A lane without a block: nothing moves in it, and its equations have a solution.
void fill_empty_lane(BlockBatch& batch, std::size_t lane) {
    batch.a[lane] = batch.b[lane] = 0;
    batch.block[lane] = -1;
    for (const int axis : {0, 1, 2}) {
        set_vector(batch.frame + 3 * axis, lane, Vec3::Unit(axis));
    }
    batch.inverse_mass_a.x[lane] = 1.0;
    set_symmetric(batch.inverse_inertia_a, lane, Mat3::Identity());
}

} // namespace

/// Colours the blocks so that no two of a colour move the same body, each taking the first colour free, and fills
/// batches colour by colour with blocks of like size.
void ContactBlocks::arrange(const Bodies& bodies) {
    std::vector<std::uint64_t> used(bodies.props.size(), 0);
    struct Place {
        int colour;
        int count;
        int block;
    };
    std::vector<Place> places;
    places.reserve(blocks.size());
    int alone = colour_limit;
    for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
        const ContactBlock& block = blocks[static_cast<std::size_t>(i)];
        if (block.count == 0) {
            continue;
        }
        std::uint64_t none = 0;
        std::uint64_t& used_a = bodies.props[static_cast<std::size_t>(block.a)].is_static()
                                    ? none
                                    : used[static_cast<std::size_t>(block.a)];
        std::uint64_t& used_b = bodies.props[static_cast<std::size_t>(block.b)].is_static()
                                    ? none
                                    : used[static_cast<std::size_t>(block.b)];
        int colour = std::countr_one(used_a | used_b);
        if (colour < colour_limit) {
            used_a |= std::uint64_t{1} << colour;
            used_b |= std::uint64_t{1} << colour;
        } else {
            colour = alone++;
        }
        places.push_back({colour, padded_count(block.count), i});
    }
    std::ranges::stable_sort(places, {}, [](const Place& p) { return 16 * p.colour + p.count; });
    batches.clear();
    batch_points.clear();
    for (std::size_t first = 0; first < places.size();) {
        BlockBatch& batch = batches.emplace_back();
        batch.count = places[first].count;
        batch.first = static_cast<int>(batch_points.size());
        BatchPoint empty{};
        std::fill_n(empty.u_n_target.x, lane_count, never);
        batch_points.insert(batch_points.end(), static_cast<std::size_t>(batch.count), empty);
        std::size_t lane = 0;
        for (; lane < lane_count && first < places.size() && places[first].colour == places[first - lane].colour &&
               places[first].count == batch.count;
             ++lane, ++first) {
            const ContactBlock& block = blocks[static_cast<std::size_t>(places[first].block)];
            batch.block[lane] = places[first].block;
            fill_lane(batch, lane, block, bodies);
            for (int k = 0; k < block.count; ++k) {
                const ContactPoint& point = points[static_cast<std::size_t>(block.first + k)];
                BatchPoint& to = batch_points[static_cast<std::size_t>(batch.first + k)];
                to.x.x[lane] = point.x;
                to.y.x[lane] = point.y;
            }
        }
        for (; lane < lane_count; ++lane) {
            fill_empty_lane(batch, lane);
        }
    }
    prepare_batches({batches.data(), batches.size(), batch_points.data()});
}

void ContactBlocks::load_batches(const Bodies& bodies) {
    activity.assign(bodies.props.size(), 0.0);
    for (BlockBatch& batch : batches) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            if (batch.block[lane] < 0) {
                continue;
            }
            const ContactBlock& block = blocks[static_cast<std::size_t>(batch.block[lane])];
            batch.mu.x[lane] = block.is_sticking ? block.mu_s : block.mu_d;
            batch.sticking.x[lane] = block.is_sticking ? 1.0 : 0.0;
            batch.seen_a.x[lane] = -1.0;
            set_vector(batch.before, lane, block.twist_before);
            for (int k = 0; k < block.count; ++k) {
                const ContactPoint& point = points[static_cast<std::size_t>(block.first + k)];
                BatchPoint& to = batch_points[static_cast<std::size_t>(batch.first + k)];
                to.u_n_target.x[lane] = point.u_n_target;
                to.p_n.x[lane] = point.p_n;
                for (int i = 0; i < 2; ++i) {
                    to.u_t_target[i].x[lane] = point.u_t_target[i];
                    to.p_t[i].x[lane] = point.p_t[i];
                }
            }
        }
    }
}

void ContactBlocks::store_impulses() {
    for (const BlockBatch& batch : batches) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            if (batch.block[lane] < 0) {
                continue;
            }
            const ContactBlock& block = blocks[static_cast<std::size_t>(batch.block[lane])];
            for (int k = 0; k < block.count; ++k) {
                ContactPoint& point = points[static_cast<std::size_t>(block.first + k)];
                const BatchPoint& from = batch_points[static_cast<std::size_t>(batch.first + k)];
                point.p_n = from.p_n.x[lane];
                point.p_t = {from.p_t[0].x[lane], from.p_t[1].x[lane]};
            }
        }
    }
}

double ContactBlocks::sweep(std::span<Velocity> velocity, double skip, double slack) {
    return sweep_batches({.batches = batches.data(),
                          .batch_count = batches.size(),
                          .points = batch_points.data(),
                          .velocity = velocity.front().v.data(),
                          .activity = activity.data(),
                          .skip = skip,
                          .slack = slack});
}

} // namespace sim
