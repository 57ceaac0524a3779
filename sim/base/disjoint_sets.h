#pragma once
/// Sets of numbers that grow together, each told by its first one. nearer: of each number one of its set that is nearer to the first,
/// or is it.
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace sim {

inline int first_of(std::vector<int>& nearer, int i) {
    for (;;) {
        int& next = nearer[static_cast<std::size_t>(i)];
        if (next == i) {
            return i;
        }
        next = nearer[static_cast<std::size_t>(next)];
        i = next;
    }
}

inline void unite(std::vector<int>& nearer, int a, int b) {
    a = first_of(nearer, a);
    b = first_of(nearer, b);
    nearer[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
}

/// Of a set each.
inline std::vector<int> sets_of_one(std::size_t count) {
    std::vector<int> nearer(count);
    std::iota(nearer.begin(), nearer.end(), 0);
    return nearer;
}

/// Each number's first one.
inline void find_firsts(std::vector<int>& nearer) {
    for (int& of : nearer) {
        of = nearer[static_cast<std::size_t>(of)]; // that one, earlier, is right
    }
}

} // namespace sim
