#pragma once
/// Room in the vectors that are as long as a scene has contacts: those of a heap are most of its memory.
#include <cstddef>
#include <vector>

namespace sim {

/// A vector that has to grow gets this share [-] more than it needs; the library's own growth gives up to all of it more.
inline constexpr std::size_t spare_share = 16; // one of so many

template <typename T>
void make_room(std::vector<T>& values, std::size_t size) {
    if (size > values.capacity()) {
        values.reserve(size + size / spare_share);
    }
}

template <typename T>
void grow(std::vector<T>& values, std::size_t size) {
    make_room(values, size);
    values.resize(size);
}

} // namespace sim
