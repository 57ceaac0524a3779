#include "sim/collide/broad_phase.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sim {
namespace {

/// Cells along one axis that a key can hold; coordinates wrap beyond (which only adds box tests).
constexpr std::int64_t key_range = std::int64_t{1} << 20;

/// Boxes of a level are compared with all where they are no more than this: as many cells would be looked at.
constexpr std::size_t few_members = 27;

/// Exponent of the cell size [m] of the lowest level; smaller boxes are in it too.
constexpr int lowest_exponent = -40;

std::int64_t key_of(const std::array<std::int64_t, 3>& cell) {
    const auto wrap = [](std::int64_t i) { return i & (key_range - 1); };
    return (wrap(cell[0]) * key_range + wrap(cell[1])) * key_range + wrap(cell[2]);
}

double cell_size(int level) {
    return std::ldexp(1.0, level + lowest_exponent);
}

bool overlap(const Bounds& a, const Bounds& b) {
    return (a.lower.array() <= b.upper.array()).all() && (b.lower.array() <= a.upper.array()).all();
}

/// floor(x); all that lies beyond counts as one cell, and so does what is not a number: the check of the
/// poses names it.
std::int64_t cell_index(double x) {
    constexpr double limit = 1e15;
    if (!(x < limit)) {
        return static_cast<std::int64_t>(limit);
    }
    return x > -limit ? static_cast<std::int64_t>(std::floor(x)) : -static_cast<std::int64_t>(limit);
}

std::array<std::int64_t, 3> cell_of(const Vec3& x, int level) {
    const Vec3 in_cells = x / cell_size(level);
    return {cell_index(in_cells.x()), cell_index(in_cells.y()), cell_index(in_cells.z())};
}

void put_in_order(std::vector<BodyPair>& pairs) {
    std::ranges::sort(pairs, {}, [](const BodyPair& pair) {
        return static_cast<std::uint64_t>(pair.a) << 32 | static_cast<std::uint64_t>(pair.b);
    });
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

} // namespace

BroadPhase::BroadPhase(std::span<const BodyProps> bodies, std::function<bool(const BodyPair&)> may_touch)
    : may_touch_(std::move(may_touch)), places_(bodies.size()), first_of_(std::bit_ceil(2 * bodies.size() + 1), -1) {
    for (const BodyProps& body : bodies) {
        is_static_.push_back(body.is_static());
    }
}

std::size_t BroadPhase::slot_of(std::int64_t key, int level) const {
    const auto mixed = (static_cast<std::uint64_t>(key) + static_cast<std::uint64_t>(level)) * 0x9E3779B97F4A7C15ull;
    return static_cast<std::size_t>(mixed >> 32) & (first_of_.size() - 1);
}

/// Into the level whose cells are as large as the box, or up to twice as large, and there into the cell of its lower
/// corner; what is not there, nowhere.
void BroadPhase::put(int body, const Bounds& box) {
    Place& place = places_[static_cast<std::size_t>(body)];
    if (box.lower.x() > box.upper.x()) {
        place.level = -1;
        return;
    }
    const double size = (box.upper - box.lower).maxCoeff();
    int exponent = level_count;
    if (size < cell_size(level_count - 2)) {
        std::frexp(size, &exponent);
        exponent -= lowest_exponent;
    }
    place.level = std::clamp(exponent, 0, level_count - 1);
    std::vector<int>& members = members_[static_cast<std::size_t>(place.level)];
    place.index = static_cast<int>(members.size());
    members.push_back(body);
    place.key = key_of(cell_of(box.lower, place.level));
    int& first = first_of_[slot_of(place.key, place.level)];
    place.next = first;
    first = body;
}

void BroadPhase::remove(int body) {
    const Place& place = places_[static_cast<std::size_t>(body)];
    if (place.level < 0) {
        return;
    }
    std::vector<int>& members = members_[static_cast<std::size_t>(place.level)];
    members[static_cast<std::size_t>(place.index)] = members.back();
    places_[static_cast<std::size_t>(members.back())].index = place.index;
    members.pop_back();
    int* link = &first_of_[slot_of(place.key, place.level)];
    while (*link != body) {
        link = &places_[static_cast<std::size_t>(*link)].next;
    }
    *link = place.next;
}

/// Calls f(body) for those in a cell.
template <typename F>
void BroadPhase::for_each_in_cell(const Cell& cell, int level, F&& f) const {
    const std::int64_t key = key_of(cell);
    for (int body = first_of_[slot_of(key, level)]; body >= 0;) {
        const Place& place = places_[static_cast<std::size_t>(body)];
        if (place.key == key && place.level == level) {
            f(body);
        }
        body = place.next;
    }
}

/// Calls f(body) for all of a level whose boxes may overlap the one given.
template <typename F>
void BroadPhase::for_each_in(int level, const Bounds& box, F&& f) const {
    const std::vector<int>& members = members_[static_cast<std::size_t>(level)];
    if (members.empty()) {
        return;
    }
    // The lower corner of a box that overlaps this one is at most a cell below it.
    Cell first = cell_of(box.lower, level);
    const Cell last = cell_of(box.upper, level);
    double cells = 1.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        --first[axis];
        cells *= static_cast<double>(last[axis] - first[axis]) + 1.0;
    }
    if (level == level_count - 1 || static_cast<double>(std::max(members.size(), few_members)) <= cells ||
        members.size() <= few_members) {
        std::ranges::for_each(members, f);
        return;
    }
    for (std::int64_t x = first[0]; x <= last[0]; ++x) {
        for (std::int64_t y = first[1]; y <= last[1]; ++y) {
            for (std::int64_t z = first[2]; z <= last[2]; ++z) {
                for_each_in_cell({x, y, z}, level, f);
            }
        }
    }
}

void BroadPhase::add_pair(int i, int j, std::span<const Bounds> boxes, std::vector<BodyPair>& pairs) const {
    const auto a = static_cast<std::size_t>(std::min(i, j));
    const auto b = static_cast<std::size_t>(std::max(i, j));
    const BodyPair pair{static_cast<int>(a), static_cast<int>(b)};
    if (!(is_static_[a] != 0 && is_static_[b] != 0) && overlap(boxes[a], boxes[b]) &&
        (!may_touch_ || may_touch_(pair))) {
        pairs.push_back(pair);
    }
}

void BroadPhase::find_pairs(std::span<const Bounds> boxes, std::vector<BodyPair>& pairs) {
    std::ranges::fill(first_of_, -1);
    for (std::vector<int>& members : members_) {
        members.clear();
    }
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        put(static_cast<int>(i), boxes[i]);
    }
    pairs.clear();
    for (int i = 0; i < static_cast<int>(boxes.size()); ++i) {
        const Bounds& box = boxes[static_cast<std::size_t>(i)];
        const int own = places_[static_cast<std::size_t>(i)].level;
        const auto test = [&](int j) {
            // Of two of the same level the later one finds the pair, of others the smaller one.
            if (places_[static_cast<std::size_t>(j)].level > own || j < i) {
                add_pair(i, j, boxes, pairs);
            }
        };
        for (int level = own; own >= 0 && level < level_count; ++level) {
            for_each_in(level, box, test);
        }
    }
    put_in_order(pairs);
}

void BroadPhase::find_pairs_of(std::span<const int> changed, std::span<const Bounds> boxes,
                               std::vector<BodyPair>& pairs) {
    for (const int i : changed) {
        remove(i);
        put(i, boxes[static_cast<std::size_t>(i)]);
    }
    pairs.clear();
    for (const int i : changed) {
        const Bounds& box = boxes[static_cast<std::size_t>(i)];
        const auto test = [&](int j) {
            if (j != i) {
                add_pair(i, j, boxes, pairs);
            }
        };
        for (int level = 0; level < level_count; ++level) {
            for_each_in(level, box, test);
        }
    }
    put_in_order(pairs);
}

} // namespace sim
