#pragma once
/// Sets of numbers that grow together, each told by its first one. nearer: of each number one of its set that is nearer to the first,
/// or is it.
#include <algorithm>
#include <cstddef>
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

} // namespace sim
