/// Blocks by islands: what Newton's method is tried on, how soft, and what it brought.
#include "sim/block/blocks.h"

#include <algorithm>

namespace sim {
namespace {

/// Compliance of Newton's equations [-] that is tried first, and at most: 1 is as soft as a visit of a block alone.
constexpr double least_compliance = 1e-3;
constexpr double largest_compliance = 1.0;
/// Where more than this share [-] of the load slides none is tried: the equations lack what friction does with the load.
constexpr double most_sliding = 0.05;
/// By which it grows where a step made it worse [-].
constexpr double compliance_factor = 10.0;

} // namespace

/// Islands in the order of their least bodies.
void Blocks::find_islands() {
    root_.resize(rows_.size());
    for (const BlockBatch& batch : batches) {
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
            root_[static_cast<std::size_t>(batch.a[lane])] = batch.a[lane];
            root_[static_cast<std::size_t>(batch.b[lane])] = batch.b[lane];
        }
    }
    const auto root_of = [&](int body) {
        while (root_[static_cast<std::size_t>(body)] != body) {
            body = root_[static_cast<std::size_t>(body)] = root_[static_cast<std::size_t>(root_[static_cast<std::size_t>(body)])];
        }
        return body;
    };
    const auto is_dynamic = [&](int body) { return rows_[static_cast<std::size_t>(body)].x[0] > 0.0; };
    for (const Block& block : blocks) {
        if (block.count > 0 && is_dynamic(block.a) && is_dynamic(block.b)) {
            const int a = root_of(block.a);
            const int b = root_of(block.b);
            root_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
        }
    }
    std::vector<std::pair<int, int>> members; // root, block
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i].count > 0) {
            members.emplace_back(root_of(is_dynamic(blocks[i].a) ? blocks[i].a : blocks[i].b), static_cast<int>(i));
        }
    }
    std::ranges::sort(members);
    for (std::size_t i = 0; i < members.size(); ++i) {
        if (i == 0 || members[i].first != members[i - 1].first) {
            islands_.emplace_back();
        }
        Island& island = islands_.back();
        island.blocks.push_back(members[i].second);
        const Block& block = blocks[static_cast<std::size_t>(members[i].second)];
        for (const int body : {block.a, block.b}) {
            if (is_dynamic(body)) {
                island.bodies.push_back(body);
            }
        }
    }
    for (Island& island : islands_) {
        std::ranges::sort(island.bodies);
        island.bodies.erase(std::unique(island.bodies.begin(), island.bodies.end()), island.bodies.end());
        const auto is_between = [&](int i) {
            const Block& block = blocks[static_cast<std::size_t>(i)];
            return is_dynamic(block.a) && is_dynamic(block.b);
        };
        const auto between = static_cast<std::size_t>(std::ranges::count_if(island.blocks, is_between));
        island.is_small = island.bodies.size() <= newton_size || between + 1 <= island.bodies.size() + newton_size;
    }
}

/// Largest change [m/s] by the last sweep in the blocks of an island that it did not settle.
double Blocks::unsettled_change(const Island& island) const {
    double change = 0.0;
    for (const int i : island.blocks) {
        const Block& block = blocks[static_cast<std::size_t>(i)];
        const BlockBatch& batch = batches[static_cast<std::size_t>(block.lane) / lane_count];
        const std::size_t lane = lane_of(block);
        change = batch.seen_a.x[lane] < 0.0 ? std::max(change, batch.change.x[lane]) : change;
    }
    return change;
}

int Blocks::island_size(const Block& block) {
    if (islands_.empty()) {
        find_islands();
    }
    const auto holds = [&](const Island& island) {
        return std::ranges::binary_search(island.bodies, block.a) || std::ranges::binary_search(island.bodies, block.b);
    };
    const auto found = std::ranges::find_if(islands_, holds);
    return found == islands_.end() ? 0 : static_cast<int>(found->bodies.size());
}

Unsettled Blocks::least_settled() {
    Unsettled found;
    const Block* worst = nullptr;
    for (const Block& block : blocks) {
        const double change = block.count > 0 ? batch_of(block).change.x[lane_of(block)] : 0.0;
        if (worst == nullptr || change > found.change) {
            found = {.a = block.a, .b = block.b, .change = change};
            worst = &block;
        }
    }
    found.island = worst == nullptr ? 0 : island_size(*worst);
    return found;
}

void Blocks::save(Island& island, std::span<const Velocity> velocity) const {
    island.velocity.clear();
    island.impulses.clear();
    for (const int body : island.bodies) {
        island.velocity.push_back(velocity[static_cast<std::size_t>(body)]);
    }
    for (const int i : island.blocks) {
        const Block& block = blocks[static_cast<std::size_t>(i)];
        for (const BatchPoint& point : points_of(batches[static_cast<std::size_t>(block.lane) / lane_count])) {
            const LanePoint at(point, lane_of(block));
            island.impulses.emplace_back(at.p_t.x(), at.p_t.y(), at.p_n);
        }
    }
}

void Blocks::restore(const Island& island, std::span<Velocity> velocity) {
    for (std::size_t i = 0; i < island.bodies.size(); ++i) {
        velocity[static_cast<std::size_t>(island.bodies[i])] = island.velocity[i];
    }
    auto impulse = island.impulses.begin();
    for (const int i : island.blocks) {
        const Block& block = blocks[static_cast<std::size_t>(i)];
        for (BatchPoint& point : points_of(batch_of(block))) {
            point.p_t[0].x[lane_of(block)] = impulse->x();
            point.p_t[1].x[lane_of(block)] = impulse->y();
            point.p_n.x[lane_of(block)] = impulse->z();
            ++impulse;
        }
    }
}

/// Judges the last step by what the sweeps since then still changed, and takes it back if that is more than before: then
/// softer equations are tried. Returns false if none are left to try.
bool Blocks::next_compliance(Island& island, std::span<Velocity> velocity) {
    const double change = unsettled_change(island);
    if (island.compliance == 0.0) {
        island.compliance = least_compliance;
    } else if (change < island.change) {
        island.compliance = std::max(island.compliance / compliance_factor, least_compliance);
    } else {
        restore(island, velocity);
        island.compliance *= compliance_factor;
        island.resists = island.compliance > largest_compliance;
        return !island.resists;
    }
    island.change = change;
    save(island, velocity);
    return true;
}

/// A step of Newton's method for each island with blocks that the last sweep has not settled. Returns whether that serves
/// all of them.
bool Blocks::solve_stalled(std::span<Velocity> velocity) {
    if (islands_.empty()) {
        find_islands();
    }
    bool all = true;
    for (Island& island : islands_) {
        if (unsettled_change(island) == 0.0) {
            continue;
        }
        const bool is_tried = !island.resists && island.is_small && sliding_share(*this, island) <= most_sliding;
        if (is_tried) {
            if (next_compliance(island, velocity)) {
                newton_.step(*this, island, rows_, velocity);
            }
            for (const int i : island.blocks) {
                const Block& block = blocks[static_cast<std::size_t>(i)];
                batch_of(block).seen_a.x[lane_of(block)] = -1.0;
            }
        }
        all = all && is_tried && !island.resists;
    }
    return all;
}

} // namespace sim
