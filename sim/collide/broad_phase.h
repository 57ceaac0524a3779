#pragma once
/// Bounding boxes -> pairs of bodies that may touch.
#include "sim/model/body.h"

#include <array>
#include <functional>
#include <span>
#include <vector>

namespace sim {

/// Indices of two bodies, a < b, at least one of them dynamic.
struct BodyPair {
    int a = -1;
    int b = -1;
    friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

/// Pairs whose boxes overlap, ascending. Each box lies in a grid whose cells are up to twice its size; the few of a
/// size that is rare (plates, floors) are compared with all. Of a heap of similar bodies each is compared with its
/// neighbours, and a box that changes finds its pairs without a look at the others. boxes [body_count]: already
/// enlarged by what the bodies may move; no_bounds: not there.
class BroadPhase {
public:
    /// may_touch: tells of a pair whose boxes overlap whether it is one; none: all are.
    explicit BroadPhase(std::span<const BodyProps> bodies, std::function<bool(const BodyPair&)> may_touch = {});

    /// `pairs` is overwritten.
    void find_pairs(std::span<const Bounds> boxes, std::vector<BodyPair>& pairs);

    /// The pairs of the bodies in `changed`; the boxes of the others are those of the call before. `pairs` is
    /// overwritten.
    void find_pairs_of(std::span<const int> changed, std::span<const Bounds> boxes, std::vector<BodyPair>& pairs);

private:
    using Cell = std::array<std::int64_t, 3>;
    struct Place {
        std::int64_t key = 0; ///< of its cell, in the grid of its level
        int level = -1;       ///< none: it is not there
        int next = -1;        ///< body in the same slot
        int index = -1;       ///< in members_[level]
    };
    /// Levels of box sizes by powers of two; the last for what is larger than all of them, or no number.
    static constexpr int level_count = 64;

    std::size_t slot_of(std::int64_t key, int level) const;
    void add_pair(int i, int j, std::span<const Bounds> boxes, std::vector<BodyPair>& pairs) const;
    void put(int body, const Bounds& box);
    void remove(int body);
    template <typename F>
    void for_each_in(int level, const Bounds& box, F&& f) const;
    template <typename F>
    void for_each_in_cell(const Cell& cell, int level, F&& f) const;

    std::function<bool(const BodyPair&)> may_touch_;
    std::vector<char> is_static_; ///< [body_count]
    std::vector<Place> places_;   ///< [body_count]
    std::vector<int> first_of_;   ///< hash table: first body of each slot, or -1
    std::array<std::vector<int>, level_count> members_;
};

} // namespace sim
