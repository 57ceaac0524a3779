#pragma once
/// Room in the vectors that are as long as a scene has contacts: those of a heap are most of its memory.
#include <cstddef>
#include <vector>

namespace sim {

/// A vector that has to grow gets one part in so many [-] more than it needs; the library's own growth gives up to all of it
/// more. A heap that settles seldom grows.
inline constexpr std::size_t spare_part = 16;

template <typename T>
void make_room(std::vector<T>& values, std::size_t size) {
    if (size > values.capacity()) {
        values.reserve(size + size / spare_part);
    }
}

template <typename T>
void grow(std::vector<T>& values, std::size_t size) {
    make_room(values, size);
    values.resize(size);
}

} // namespace sim
