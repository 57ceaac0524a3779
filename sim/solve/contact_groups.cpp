#include "sim/solve/contact_groups.h"

#include "sim/base/disjoint_sets.h"

#include <algorithm>
#include <utility>

namespace sim {
namespace {

/// A group gets islands until it has so many pairs [-]: of stacked boxes that is a quarter of a megabyte of batches.
constexpr std::size_t group_size = 256;

} // namespace

bool ContactGroups::is_large(const ContactGroup& group) {
    return group.pairs.size() >= 2 * group_size;
}

void ContactGroups::begin_group(std::size_t index) {
    if (index == groups_.size()) {
        groups_.emplace_back(block_bodies_);
    }
    ContactGroup& group = groups_[index];
    group.pairs.clear();
    group.bodies.clear();
    group.assemblies.clear();
    group.is_begun = false;
    group.is_wedged = false;
    group.is_due = true;
    group.given_way = 0.0;
}

/// The first body of each one's island.
void ContactGroups::find_islands(const Bodies& bodies, const std::vector<PairContacts>& pairs, const JointSolver& joints,
                                 std::span<const std::size_t> solved) {
    first_of_.resize(bodies.props.size());
    for (const std::size_t i : solved) {
        first_of_[i] = bodies.props[i].is_static() ? -1 : static_cast<int>(i);
    }
    const auto moves = [&](int body) { return first_of_[static_cast<std::size_t>(body)] >= 0; };
    mover_.clear();
    for (const PairContacts& pair : pairs) {
        const auto [a, b] = std::pair(pair.manifold.body_a, pair.manifold.body_b);
        mover_.push_back(moves(a) ? a : b);
        if (moves(a) && moves(b)) {
            unite(first_of_, a, b);
        }
    }
    joints.unite_bodies(first_of_);
    for (const std::size_t i : solved) {
        if (first_of_[i] >= 0) {
            first_of_[i] = first_of_[static_cast<std::size_t>(first_of_[i])]; // that one, earlier, is right
        }
    }
}

void ContactGroups::form(const Bodies& bodies, const std::vector<PairContacts>& pairs, const JointSolver& joints,
                         std::span<const std::size_t> solved, Workers* workers) {
    block_bodies_->begin(bodies, solved, workers);
    find_islands(bodies, pairs, joints, solved);
    const auto island_of = [&](int body) { return static_cast<std::size_t>(first_of_[static_cast<std::size_t>(body)]); };
    size_.assign(bodies.props.size(), 0);
    for (const int mover : mover_) {
        ++size_[island_of(mover)];
    }
    group_of_.assign(bodies.props.size(), -1); // of islands by their first bodies, then of all
    std::size_t used = 0;
    std::size_t filled = group_size; // pairs of the islands in the last group, or what admits no others
    const auto add_island = [&](std::size_t first) {
        if (filled >= group_size) {
            begin_group(used++);
            filled = 0;
        }
        group_of_[first] = static_cast<int>(used) - 1;
        filled += static_cast<std::size_t>(size_[first]);
    };
    for (const int assembly : joints.assemblies()) {
        const std::size_t first = island_of(joints.bodies_of(assembly).front());
        if (group_of_[first] < 0) {
            filled = group_size;
            add_island(first);
        }
        groups_[static_cast<std::size_t>(group_of_[first])].assemblies.push_back(assembly);
    }
    filled = group_size;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        const std::size_t first = island_of(mover_[i]);
        if (group_of_[first] < 0) {
            add_island(first);
        }
        groups_[static_cast<std::size_t>(group_of_[first])].pairs.push_back(static_cast<int>(i));
    }
    if (used == 0) {
        begin_group(used++);
    }
    while (groups_.size() > used) {
        groups_.pop_back();
    }
    for (const std::size_t i : solved) {
        if (first_of_[i] >= 0) {
            group_of_[i] = group_of_[static_cast<std::size_t>(first_of_[i])];
            groups_[static_cast<std::size_t>(group_of_[i])].bodies.push_back(i);
        }
    }
}

/// The group of its bodies that move; the first one where they have been in none.
std::size_t ContactGroups::group_of(const PairContacts& pair) const {
    const int a = group_of_[static_cast<std::size_t>(pair.manifold.body_a)];
    const int b = group_of_[static_cast<std::size_t>(pair.manifold.body_b)];
    return static_cast<std::size_t>(std::max({a, b, 0}));
}

void ContactGroups::drop(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair, Prediction& to) {
    ContactGroup& group = groups_[group_of(pairs[static_cast<std::size_t>(pair)])];
    group.contacts.drop(bodies, pair, to);
    group.is_due = true;
}

void ContactGroups::add(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> added,
                        std::span<const Velocity> at_node, Prediction& to) {
    for (const int index : added) {
        const PairContacts& pair = pairs[static_cast<std::size_t>(index)];
        for (const int body : {pair.manifold.body_a, pair.manifold.body_b}) {
            if (to.add(body)) {
                const std::size_t i[] = {static_cast<std::size_t>(body)};
                block_bodies_->begin(bodies, i, nullptr);
                to.update(bodies, i, nullptr);
            }
            if (!bodies.props[static_cast<std::size_t>(body)].is_static()) {
                const std::size_t into = group_of(pair);
                int& group = group_of_[static_cast<std::size_t>(body)];
                if (group < 0) {
                    group = static_cast<int>(into);
                    groups_[into].bodies.push_back(static_cast<std::size_t>(body));
                } else if (static_cast<std::size_t>(group) != into) {
                    join(bodies, pairs, {static_cast<std::size_t>(group), into}, added, to);
                }
            }
        }
    }
    std::vector<std::vector<int>> of_group(groups_.size());
    for (const int index : added) {
        of_group[group_of(pairs[static_cast<std::size_t>(index)])].push_back(index);
    }
    for (std::size_t i = 0; i < groups_.size(); ++i) {
        if (of_group[i].empty()) {
            continue;
        }
        ContactGroup& group = groups_[i];
        group.contacts.add(bodies, pairs, of_group[i], at_node, to);
        group.is_due = true;
        for (const int index : of_group[i]) {
            if (std::ranges::find(group.pairs, index) == group.pairs.end()) {
                group.pairs.push_back(index);
            }
        }
    }
}

/// Two groups become one, the larger of them. added: pairs that are to follow.
void ContactGroups::join(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::pair<std::size_t, std::size_t> both,
                         std::span<const int> added, Prediction& to) {
    auto [from, into] = both;
    if (groups_[from].pairs.size() > groups_[into].pairs.size()) {
        std::swap(from, into);
    }
    ContactGroup& source = groups_[from];
    ContactGroup& target = groups_[into];
    std::vector<int> moved;
    for (const int index : source.pairs) {
        source.contacts.drop(bodies, index, to); // the pair remembers its impulses
        if (std::ranges::find(added, index) == added.end()) {
            moved.push_back(index);
        }
    }
    target.contacts.add(bodies, pairs, moved, {}, to);
    target.is_due = true;
    target.is_wedged = target.is_wedged || source.is_wedged;
    target.given_way = std::max(target.given_way, source.given_way);
    target.pairs.insert(target.pairs.end(), source.pairs.begin(), source.pairs.end());
    target.bodies.insert(target.bodies.end(), source.bodies.begin(), source.bodies.end());
    target.assemblies.insert(target.assemblies.end(), source.assemblies.begin(), source.assemblies.end());
    for (const std::size_t i : source.bodies) {
        group_of_[i] = static_cast<int>(into);
    }
    source.contacts.loop.clear();
    source.pairs.clear();
    source.bodies.clear();
    source.assemblies.clear();
    source.is_due = false;
    source.given_way = 0.0;
    source.report = {};
}

/// Of bodies in no group none.
void ContactGroups::count_sweeps() {
    std::vector<NewtonWait> before(group_of_.size());
    std::swap(before, block_bodies_->waits);
    block_bodies_->swept.assign(before.size(), false);
    block_bodies_->wedged.assign(before.size(), false);
    for (const ContactGroup& group : groups_) {
        for (const std::size_t i : group.bodies) {
            block_bodies_->wedged[i] = group.is_wedged;
            if (group.sweeps > 1) {
                block_bodies_->swept[i] = true;
                block_bodies_->waits[i] = {before[i].whole, std::max(before[i].left - static_cast<float>(group.sweeps), 0.0f)};
            }
        }
    }
}

} // namespace sim
