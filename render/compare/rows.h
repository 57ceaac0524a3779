#pragma once
/// Rows of pictures, for loops over bytes that compilers turn into vector instructions: no branches, no wider numbers, three
/// arguments two by two.
#include "render/compare/picture.h"

#include <algorithm>
#include <cstdint>

namespace diff {

using Row = const std::uint8_t*;

inline std::size_t row_bytes(const Picture& picture) {
    return static_cast<std::size_t>(picture.width) * 3;
}

inline Row row_of(const Picture& picture, int y) {
    return picture.rgb.data() + row_bytes(picture) * static_cast<std::size_t>(std::clamp(y, 0, picture.height - 1));
}

inline std::uint8_t lesser(std::uint8_t a, std::uint8_t b) {
    return a < b ? a : b;
}
inline std::uint8_t greater(std::uint8_t a, std::uint8_t b) {
    return a > b ? a : b;
}

} // namespace diff
