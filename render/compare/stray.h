#pragma once
/// Pixels that differ where no edge is near: sampling cannot do that.
#include "render/compare/difference.h"

namespace diff {

/// Pixels that differ by more than 40 levels and of which one picture is flat within two pixels; x, y: the first of
/// them. Counting ends at `most`.
Peak count_strays(const Picture& a, const Picture& b, const std::vector<std::uint8_t>& raw, int most);

} // namespace diff
