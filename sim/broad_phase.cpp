#include "sim/broad_phase.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace sim {
namespace {

/// A body belongs to the grid when it is at most this many times [-] as large as the median body.
constexpr double grid_size_ratio = 4.0;

/// Cells along one axis that a key can hold; coordinates wrap beyond (which only adds box tests).
constexpr std::int64_t key_range = std::int64_t{1} << 20;

std::int64_t key_of(std::int64_t x, std::int64_t y, std::int64_t z) {
    const auto wrap = [](std::int64_t i) { return i & (key_range - 1); };
    return (wrap(x) * key_range + wrap(y)) * key_range + wrap(z);
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

} // namespace

BroadPhase::BroadPhase(std::span<const BodyProps> bodies) {
    std::vector<double> radii;
    for (const BodyProps& body : bodies) {
        is_static_.push_back(body.is_static());
        if (!body.is_static()) {
            radii.push_back(body.bounding_radius);
        }
    }
    double limit = 0.0;
    if (!radii.empty()) {
        const auto middle = radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2);
        std::ranges::nth_element(radii, middle);
        limit = grid_size_ratio * *middle;
    }
    for (int i = 0; i < static_cast<int>(bodies.size()); ++i) {
        (bodies[static_cast<std::size_t>(i)].bounding_radius <= limit ? small_ : large_).push_back(i);
    }
}

/// Slot of the hash table that holds `key`, or the empty one where it belongs.
std::size_t BroadPhase::slot_of(std::int64_t key) const {
    const std::size_t mask = first_of_.size() - 1;
    std::size_t slot =
        static_cast<std::size_t>((static_cast<std::uint64_t>(key) * 0x9E3779B97F4A7C15ull) >> 32) & mask;
    while (first_of_[slot] >= 0 && cells_[static_cast<std::size_t>(first_of_[slot])].key != key) {
        slot = (slot + 1) & mask;
    }
    return slot;
}

void BroadPhase::find_pairs(std::span<const Bounds> boxes, std::vector<BodyPair>& pairs) {
    const auto box = [&](int i) -> const Bounds& { return boxes[static_cast<std::size_t>(i)]; };
    const auto test = [&](int i, int j) {
        if (!(is_static_[static_cast<std::size_t>(i)] && is_static_[static_cast<std::size_t>(j)]) &&
            overlap(box(i), box(j))) {
            pairs.push_back({std::min(i, j), std::max(i, j)});
        }
    };
    pairs.clear();
    double cell_size = 0.0; // [m], at least the largest enlarged box
    for (const int i : small_) {
        cell_size = std::max(cell_size, (box(i).upper - box(i).lower).maxCoeff());
    }
    const auto cell_of = [&](int i) {
        const Vec3 x = box(i).lower / cell_size;
        return std::array{cell_index(x.x()), cell_index(x.y()), cell_index(x.z())};
    };
    cells_.clear();
    for (const int i : small_) {
        const auto [x, y, z] = cell_of(i);
        cells_.push_back({key_of(x, y, z), i});
    }
    std::ranges::sort(cells_, [](const Cell& p, const Cell& q) {
        return p.key != q.key ? p.key < q.key : p.body < q.body;
    });
    first_of_.assign(std::bit_ceil(2 * cells_.size() + 1), -1);
    for (std::size_t i = 0; i < cells_.size(); ++i) {
        if (i == 0 || cells_[i].key != cells_[i - 1].key) {
            first_of_[slot_of(cells_[i].key)] = static_cast<std::int32_t>(i);
        }
    }
    // Lower corners of overlapping boxes are at most one cell apart along each axis.
    for (std::size_t first = 0; first < cells_.size();) {
        std::size_t last = first;
        while (last < cells_.size() && cells_[last].key == cells_[first].key) {
            ++last;
        }
        const auto [x, y, z] = cell_of(cells_[first].body);
        for (std::size_t i = first; i < last; ++i) {
            for (std::size_t j = i + 1; j < last; ++j) {
                test(cells_[i].body, cells_[j].body);
            }
        }
        for (int direction = 14; direction < 27;
             ++direction) { // the half of the neighbours with a larger index
            const std::int64_t key =
                key_of(x + direction / 9 - 1, y + direction / 3 % 3 - 1, z + direction % 3 - 1);
            const std::int32_t found = first_of_[slot_of(key)];
            if (found < 0) {
                continue;
            }
            for (auto k = static_cast<std::size_t>(found); k < cells_.size() && cells_[k].key == key; ++k) {
                for (std::size_t i = first; i < last; ++i) {
                    test(cells_[i].body, cells_[k].body);
                }
            }
        }
        first = last;
    }
    for (std::size_t i = 0; i < large_.size(); ++i) {
        for (const int body : small_) {
            test(large_[i], body);
        }
        for (std::size_t j = i + 1; j < large_.size(); ++j) {
            test(large_[i], large_[j]);
        }
    }
    std::ranges::sort(pairs);
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

} // namespace sim
