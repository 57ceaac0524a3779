/// Blocks by islands: what Newton's method is tried on, and what it brought.
#include "sim/base/sort_once.h"
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

/// Places of bodies that a block connects, or a joint of these assemblies.
std::vector<std::array<std::size_t, 2>> Blocks::connected(std::span<const int> assemblies) const {
    std::vector<std::array<std::size_t, 2>> found;
    const auto add = [&](int a, int b) {
        const int at[] = {bodies_->place[static_cast<std::size_t>(a)], bodies_->place[static_cast<std::size_t>(b)]};
        if (at[0] >= 0 && at[1] >= 0) {
            found.push_back({static_cast<std::size_t>(at[0]), static_cast<std::size_t>(at[1])});
        }
    };
    for (const Block& block : blocks) {
        if (block.count > 0) {
            add(block.a, block.b);
        }
    }
    for (const int assembly : assemblies) {
        for (const auto [a, b] : joints->pairs_of(assembly)) {
            add(a, b);
        }
    }
    return found;
}

/// Islands in the order of their least bodies, found in breadth. Bodies go by their places among those that move.
void Blocks::find_islands() {
    const std::vector<BodyRows>& rows = bodies_->rows;
    std::vector<int>& place = bodies_->place;
    const auto is_dynamic = [&](int body) { return rows[static_cast<std::size_t>(body)].x[0] > 0.0; };
    const auto place_of = [&](int body) { return static_cast<std::size_t>(place[static_cast<std::size_t>(body)]); };
    find_members(0, [&](std::size_t body) { return rows[body].x[0] > 0.0; });
    std::vector<int> own(members_.begin(), members_.end());
    const std::vector<int> assemblies = joints == nullptr ? std::vector<int>{} : joints->assemblies_with(own);
    for (const int assembly : assemblies) {
        own.insert(own.end(), joints->bodies_of(assembly).begin(), joints->bodies_of(assembly).end());
    }
    sort_once(own);
    for (std::size_t i = 0; i < own.size(); ++i) {
        place[static_cast<std::size_t>(own[i])] = static_cast<int>(i);
    }
    const Neighbours neighbours(own.size(), connected(assemblies));
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
        for (std::size_t i = 0; i < found.size(); ++i) {
            std::ranges::for_each(neighbours[found[i]], add);
        }
        for (const std::size_t body : found) {
            island.bodies.push_back(own[body]);
        }
        std::ranges::sort(island.bodies);
    }
    const auto island_with = [&](int body) -> Island& { return islands_[static_cast<std::size_t>(island_of[place_of(body)])]; };
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        if (blocks[i].count > 0) {
            island_with(is_dynamic(blocks[i].a) ? blocks[i].a : blocks[i].b).blocks.push_back(static_cast<int>(i));
        }
    }
    for (const int assembly : assemblies) {
        island_with(joints->bodies_of(assembly).front()).assemblies.push_back(assembly);
    }
    for (Island& island : islands_) {
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
    const auto visits = static_cast<double>(island.blocks.size()); // of a sweep
    island.in_vain = was_in_vain ? island.in_vain + std::exchange(island.cost, 0.0) / visits : 0.0;
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
void Blocks::solve_stalled(std::span<Velocity> velocity, double skip, const std::function<void()>& close_joints) {
    if (islands_.empty()) {
        find_islands();
    }
    for (Island& island : islands_) {
        const double change = largest_change(island);
        island.is_extrapolated = change > skip;
        if (!island.is_extrapolated) {
            continue;
        }
        if (island.is_served && change >= island.change) {
            set_wait(island, true);
            island.resists = true;
        }
        island.is_served = !island.resists && sweeps_ >= island.wait.left && sliding_share(*this, island) <= most_sliding;
        if (!island.is_served) {
            continue;
        }
        island.change = change;
        if (!island.assemblies.empty()) {
            close_joints();
        }
        const auto visits = static_cast<double>(blocks.size()); // of a sweep
        const NewtonLimits limits{.cost = (budget_ - spent()) * visits, .least = skip};
        island.is_extrapolated = !newton_.step(*this, island, *bodies_, velocity, limits);
        newton_cost_ += island.cost / visits;
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
