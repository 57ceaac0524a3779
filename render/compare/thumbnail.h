#pragma once
/// A picture at a glance: mean colours of 16 x 16 parts.
#include "render/compare/picture.h"

#include <array>

namespace diff {

inline constexpr int thumbnail_side = 16;                                          ///< [px]
using Thumbnail = std::array<float, thumbnail_side * thumbnail_side * 3>; ///< [levels]

Thumbnail thumbnail_of(const Picture& picture);

} // namespace diff
