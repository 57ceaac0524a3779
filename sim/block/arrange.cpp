#include "sim/block/contact_block.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace sim {
namespace {

/// Colours a body's blocks can have before the rest of them are visited one by one.
constexpr int colour_limit = 64;

/// Shares of a colour's batches that are alike.
constexpr std::size_t equal_shares = 4;

/// Point of an empty place: its velocity is always far above the target.
constexpr double never = -1e300;

/// Points of a lane in a batch that holds blocks of `count` points.
int padded_count(int count) {
    return count <= 2 ? count : count <= 4 ? 4 : count <= 6 ? 6 : block_size;
}

/// The items in the order of their keys, small numbers; of equal ones in the order they have.
template <typename Item, typename Key>
std::vector<Item> sorted_by(const std::vector<Item>& items, Key&& key) {
    std::vector<std::size_t> begin; // of each key's items
    for (const Item& item : items) {
        const auto k = static_cast<std::size_t>(key(item));
        begin.resize(std::max(begin.size(), k + 2));
        ++begin[k + 1];
    }
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Item> sorted(items.size());
    for (const Item& item : items) {
        sorted[begin[static_cast<std::size_t>(key(item))]++] = item;
    }
    return sorted;
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
    batch.face_of_a |= static_cast<unsigned>(block.is_face_of_a) << lane;
}

/// A lane without a block: nothing moves in it, and its equations have a solution.
void fill_empty_lane(BlockBatch& batch, std::size_t lane) {
    batch.a[lane] = batch.b[lane] = 0;
    for (const int axis : {0, 1, 2}) {
        set_vector(batch.frame + 3 * axis, lane, Vec3::Unit(axis));
    }
    batch.inverse_mass_a.x[lane] = 1.0;
    set_symmetric(batch.inverse_inertia_a, lane, Mat3::Identity());
}

} // namespace

/// Colours the blocks so that no two of a colour move the same body, each taking the first colour free, and fills
/// batches colour by colour with blocks of like size.
void ContactBlocks::plan(const Bodies& bodies) {
    used_.resize(bodies.props.size());
    for (const ContactBlock& block : blocks) {
        used_[static_cast<std::size_t>(block.a)] = used_[static_cast<std::size_t>(block.b)] = 0;
    }
    struct Place {
        int colour;
        int count;
        int block;
    };
    std::vector<Place> unsorted;
    unsorted.reserve(blocks.size());
    int alone = colour_limit;
    for (int i = 0; i < static_cast<int>(blocks.size()); ++i) {
        const ContactBlock& block = blocks[static_cast<std::size_t>(i)];
        if (block.count == 0) {
            continue;
        }
        std::uint64_t none = 0;
        std::uint64_t& used_a = bodies.props[static_cast<std::size_t>(block.a)].is_static()
                                    ? none
                                    : used_[static_cast<std::size_t>(block.a)];
        std::uint64_t& used_b = bodies.props[static_cast<std::size_t>(block.b)].is_static()
                                    ? none
                                    : used_[static_cast<std::size_t>(block.b)];
        int colour = std::countr_one(used_a | used_b);
        if (colour < colour_limit) {
            used_a |= std::uint64_t{1} << colour;
            used_b |= std::uint64_t{1} << colour;
        } else {
            colour = alone++;
        }
        unsorted.push_back({colour, padded_count(block.count), i});
    }
    const std::vector<Place> places = sorted_by(unsorted, [](const Place& p) { return 16 * p.colour + p.count; });
    // What each batch holds; those of a colour in an order that gives threads equal shares of large and small ones.
    struct Plan {
        std::size_t first;
        std::size_t lanes;
    };
    std::vector<Plan> plans;
    std::vector<Plan> of_colour;
    colours.clear();
    for (std::size_t first = 0; first < places.size();) {
        of_colour.clear();
        const int colour = places[first].colour;
        while (first < places.size() && places[first].colour == colour) {
            const std::size_t begin = first;
            while (first < places.size() && first - begin < lane_count && places[first].colour == colour &&
                   places[first].count == places[begin].count) {
                ++first;
            }
            of_colour.push_back({begin, first - begin});
        }
        for (std::size_t share = 0; share < equal_shares; ++share) {
            for (std::size_t i = share; i < of_colour.size(); i += equal_shares) {
                plans.push_back(of_colour[i]);
            }
        }
        colours.push_back(plans.size());
    }
    batches.resize(plans.size());
    std::size_t point_count = 0;
    for (std::size_t i = 0; i < plans.size(); ++i) {
        batches[i].count = places[plans[i].first].count;
        batches[i].first = static_cast<int>(point_count);
        point_count += static_cast<std::size_t>(batches[i].count);
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            batches[i].block[lane] = lane < plans[i].lanes ? places[plans[i].first + lane].block : -1;
        }
    }
    batch_points.resize(point_count);
}

void ContactBlocks::arrange(const Bodies& bodies) {
    plan(bodies);
    share(batches.size(), [&](std::size_t first, std::size_t last) { fill_batches(bodies, first, last); });
}

/// Puts what does not change while they are iterated into the batches first..last.
void ContactBlocks::fill_batches(const Bodies& bodies, std::size_t first, std::size_t last) {
    BatchPoint empty{};
    std::fill_n(empty.u_n_target.x, lane_count, never);
    for (std::size_t i = first; i < last; ++i) {
        BlockBatch& batch = batches[i];
        std::fill_n(batch_points.begin() + batch.first, batch.count, empty);
        batch.moves_a = batch.moves_b = batch.flat = batch.face_of_a = 0;
        batch.has_friction = false;
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            if (batch.block[lane] < 0) {
                fill_empty_lane(batch, lane);
                continue;
            }
            const ContactBlock& block = blocks[static_cast<std::size_t>(batch.block[lane])];
            fill_lane(batch, lane, block, bodies);
            for (int k = 0; k < block.count; ++k) {
                const ContactPoint& point = points[static_cast<std::size_t>(block.first + k)];
                BatchPoint& to = batch_points[static_cast<std::size_t>(batch.first + k)];
                to.x.x[lane] = point.x;
                to.y.x[lane] = point.y;
            }
        }
    }
    prepare_batches({batches.data() + first, last - first, batch_points.data()});
}

/// Before the first of a solve's sweeps.
void ContactBlocks::begin_sweeps(const Bodies& bodies) {
    activity.resize(bodies.props.size());
    for (const ContactBlock& block : blocks) {
        activity[static_cast<std::size_t>(block.a)] = activity[static_cast<std::size_t>(block.b)] = 0.0;
    }
    carried_.clear();
    momentum_.begin();
}

void ContactBlocks::wake(const Bodies& bodies) {
    begin_sweeps(bodies);
    for (BlockBatch& batch : batches) {
        std::fill_n(batch.seen_a.x, lane_count, -1.0);
    }
}

void ContactBlocks::load_batches(const Bodies& bodies) {
    begin_sweeps(bodies);
    share(batches.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            load_batch(batches[i]);
        }
    });
}

void ContactBlocks::load_batch(BlockBatch& batch) {
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

void ContactBlocks::store_impulses() {
    share(batches.size(), [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            store_batch(batches[i]);
        }
    });
}

void ContactBlocks::store_batch(const BlockBatch& batch) {
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

/// Repeats a share of what the last sweep did, or begins to watch what sweeps do.
void ContactBlocks::carry_on(std::span<Velocity> velocity) {
    if (carried_.empty()) {
        for (const BatchPoint& point : batch_points) {
            CarriedPoint& carried = carried_.emplace_back();
            carried = {{point.p_t[0], point.p_t[1], point.p_n}, {point.p_t[0], point.p_t[1], point.p_n}};
        }
        momentum_.start(change_);
        return;
    }
    const auto carry = [&](std::size_t first, std::size_t last, double* along, double momentum) {
        carry_batches({.batches = batches.data() + first,
                       .batch_count = last - first,
                       .points = batch_points.data(),
                       .carried = carried_.data(),
                       .along = along,
                       .momentum = momentum,
                       .velocity = velocity.front().v.data(),
                       .activity = activity.data()});
    };
    along_.resize(batches.size());
    share(batches.size(), [&](std::size_t first, std::size_t last) { carry(first, last, along_.data() + first, 0.0); });
    const double momentum = momentum_.next(std::accumulate(along_.begin(), along_.end(), 0.0), change_);
    share_colours([&](std::size_t first, std::size_t last) { carry(first, last, nullptr, momentum); });
}

double ContactBlocks::sweep(std::span<Velocity> velocity, double skip, double slack, int projections) {
    if (momentum_.carries()) {
        carry_on(velocity);
    }
    std::atomic<double> worst = 0.0;
    share_colours([&](std::size_t first, std::size_t last) {
        raise_to(worst, sweep_batches({.batches = batches.data() + first,
                                       .batch_count = last - first,
                                       .points = batch_points.data(),
                                       .velocity = velocity.front().v.data(),
                                       .activity = activity.data(),
                                       .skip = skip,
                                       .slack = slack,
                                       .projections = projections}));
    });
    return change_ = worst;
}

} // namespace sim
