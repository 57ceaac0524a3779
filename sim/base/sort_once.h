#pragma once
#include <algorithm>
#include <vector>

namespace sim {

/// Ascending, each value once.
template <typename T>
void sort_once(std::vector<T>& values) {
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
}

} // namespace sim
