#pragma once
/// Bounding boxes -> pairs of bodies that may touch.
#include "sim/body.h"

#include <span>
#include <vector>

namespace sim {

/// Indices of two bodies, a < b, at least one of them dynamic.
struct BodyPair {
    int a = -1;
    int b = -1;
    friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

/// Pairs whose boxes overlap, ascending. Bodies of about the same size are sorted into a grid of their size,
/// the few larger ones (plates, floors) are compared with all: n log n for a heap of similar bodies. boxes
/// [body_count]: already enlarged by what the bodies may move.
class BroadPhase {
public:
    explicit BroadPhase(std::span<const BodyProps> bodies);

    /// `pairs` is overwritten.
    void find_pairs(std::span<const Bounds> boxes, std::vector<BodyPair>& pairs);

private:
    struct Cell {
        std::int64_t key;
        int body;
    };
    std::size_t slot_of(std::int64_t key) const;
    std::vector<int> small_; ///< bodies that fit the grid
    std::vector<int> large_;
    std::vector<char> is_static_;        ///< [body_count]
    std::vector<Cell> cells_;            ///< sorted by key, then body
    std::vector<std::int32_t> first_of_; ///< hash table: slot of a key -> index of its first cell, or -1
};

} // namespace sim
