/// Blocks by islands: what Newton's method is tried on, and what it brought.
#include "sim/block/blocks.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <span>
#include <utility>

namespace sim {
namespace {

/// Where more than this share [-] of the load slides none is tried: the equations lack what friction does with the load.
constexpr double most_sliding = 0.05;

/// Bodies beside each body, by places: those of body i are of[begin[i]] and on, up to begin[i + 1].
struct Neighbours {
    std::vector<std::size_t> begin;
    std::vector<std::size_t> of;

    Neighbours(std::size_t count, std::span<const std::array<std::size_t, 2>> between) : begin(count + 1, 0), of(2 * between.size()) {
        for (const auto& [a, b] : between) {
            ++begin[a];
            ++begin[b];
        }
        std::partial_sum(begin.begin(), begin.end(), begin.begin());
        for (const auto& [a, b] : between) {
            of[--begin[a]] = b;
            of[--begin[b]] = a;
        }
    }
    std::span<const std::size_t> operator[](std::size_t i) const { return std::span(of).subspan(begin[i], begin[i + 1] - begin[i]); }
};

} // namespace

/// Islands in the order of their least bodies, found in breadth. Bodies go by their places among those that move.
void Blocks::find_islands() {
    const std::vector<BodyRows>& rows = bodies_->rows;
    std::vector<int>& place = bodies_->place;
    const auto is_dynamic = [&](int body) { return rows[static_cast<std::size_t>(body)].x[0] > 0.0; };
    const auto place_of = [&](int body) { return static_cast<std::size_t>(place[static_cast<std::size_t>(body)]); };
    find_members(0, [&](std::size_t body) { return rows[body].x[0] > 0.0; });
    std::vector<int> own(members_.begin(), members_.end());
    std::ranges::sort(own);
    for (std::size_t i = 0; i < own.size(); ++i) {
        place[static_cast<std::size_t>(own[i])] = static_cast<int>(i);
    }
    std::vector<std::array<std::size_t, 2>> between;
    for (const Block& block : blocks) {
        if (block.count > 0 && is_dynamic(block.a) && is_dynamic(block.b)) {
            between.push_back({place_of(block.a), place_of(block.b)});
        }
    }
    const Neighbours neighbours(own.size(), between);
    std::vector<int> island_of(own.size(), -1); // not seen yet
    std::vector<std::size_t> found; // the bodies of an island
    const auto add = [&](std::size_t body) {
        if (island_of[body] < 0) {
            island_of[body] = static_cast<int>(islands_.size()) - 1;
            found.push_back(body);
        }
    };
    for (std::size_t least = 0; least < own.size(); ++least) {
        if (island_of[least] >= 0) {
            continue;
        }
        Island& island = islands_.emplace_back();
        found.clear();
        add(least);
        for (std::size_t first = 0, last = 1; first < last; first = std::exchange(last, found.size())) {
            for (std::size_t i = first; i < last; ++i) {
                std::ranges::for_each(neighbours[found[i]], add);
            }
            const auto width = static_cast<double>(found.size() - first); // of a matrix that is symmetric half of the products
            island.cost += 0.5 * static_cast<double>(last - first) * width * width;
        }
        for (const std::size_t body : found) {
            island.bodies.push_back(own[body]);
        }
        std::ranges::sort(island.bodies);
        const auto is_held = [&](int body) { return !assembly_of.empty() && assembly_of[static_cast<std::size_t>(body)] >= 0; };
        island.has_joints = std::ranges::any_of(island.bodies, is_held);
    }
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i].count > 0) {
            const int body = is_dynamic(blocks[i].a) ? blocks[i].a : blocks[i].b;
            islands_[static_cast<std::size_t>(island_of[place_of(body)])].blocks.push_back(static_cast<int>(i));
        }
    }
    for (Island& island : islands_) {
        island.cost /= static_cast<double>(island.blocks.size());
        begin_wait(island);
    }
    for (const int body : own) {
        place[static_cast<std::size_t>(body)] = -1;
    }
}

/// As the solves before have left it.
void Blocks::begin_wait(Island& island) const {
    island.wait = bodies_->waits[static_cast<std::size_t>(island.bodies.front())];
    island.in_vain = 0.0;
}

/// Of the solves to come: a step in vain makes them wait for what it has cost, and twice as long as this one had to.
void Blocks::set_wait(Island& island, bool was_in_vain) {
    island.in_vain = was_in_vain ? island.in_vain + std::exchange(island.rounds, 0) * island.cost : 0.0;
    const auto wait = static_cast<float>(was_in_vain ? 2.0 * island.wait.whole + island.in_vain : 0.0);
    for (const int body : island.bodies) {
        bodies_->waits[static_cast<std::size_t>(body)] = {wait, wait};
    }
}

/// Largest change [m/s] by the last sweep in the blocks of an island.
double Blocks::largest_change(const Island& island) const {
    double change = 0.0;
    for (const int i : island.blocks) {
        const Block& block = blocks[static_cast<std::size_t>(i)];
        change = std::max(change, batch_of(block).change.x[lane_of(block)]);
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

/// A step of Newton's method for each island that the last sweep changed by more than `skip` [m/s]. It is in vain if it is taken back.
/// It was, and none follows in this solve, if what the sweeps since then still change is no less than before.
void Blocks::solve_stalled(std::span<Velocity> velocity, double skip) {
    if (islands_.empty()) {
        find_islands();
    }
    for (Island& island : islands_) {
        if (island.has_joints) {
            continue;
        }
        const double change = largest_change(island);
        island.is_extrapolated = change > skip;
        if (!island.is_extrapolated) {
            continue;
        }
        if (island.is_served && change >= island.change) {
            set_wait(island, true);
            island.resists = true;
        }
        const double cost = island.cost * static_cast<double>(island.blocks.size()) / static_cast<double>(blocks.size());
        const double affordable = (budget_ - spent()) / cost; // rounds
        island.is_served = !island.resists && sweeps_ >= island.wait.left && affordable >= 1.0 &&
                           sliding_share(*this, island) <= most_sliding;
        if (!island.is_served) {
            continue;
        }
        island.change = change;
        const auto rounds = static_cast<int>(std::min(affordable, double{newton_rounds}));
        island.is_extrapolated = !newton_.step(*this, island, *bodies_, velocity, {.rounds = rounds, .least = skip});
        newton_cost_ += island.rounds * cost;
        set_wait(island, island.is_extrapolated);
        for (const int i : island.blocks) {
            const Block& block = blocks[static_cast<std::size_t>(i)];
            batch_of(block).seen[2].x[lane_of(block)] = no_point;
        }
    }
}

/// What Newton's method does is no step of the sweeps: extrapolation goes on from the impulses as they are.
void Blocks::hold(const Island& island) {
    for (const int i : island.blocks) {
        const Block& block = blocks[static_cast<std::size_t>(i)];
        const BlockBatch& batch = batch_of(block);
        const std::size_t lane = lane_of(block);
        for (auto k = static_cast<std::size_t>(batch.first); k < static_cast<std::size_t>(batch.first + batch.count); ++k) {
            const Lanes* const now[] = {&points[k].p_t[0], &points[k].p_t[1], &points[k].p_n};
            for (std::size_t j = 0; j < 3; ++j) {
                extrapolated_[k].begun[j].x[lane] = extrapolated_[k].swept[j].x[lane] = now[j]->x[lane];
            }
        }
    }
}

} // namespace sim
