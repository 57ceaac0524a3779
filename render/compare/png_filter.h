#pragma once
/// The prediction that PNG applies to each row (PNG specification, sec. 9).
#include <cstddef>
#include <cstdint>

namespace diff {

/// Undoes filter `type` 0..4 of one row in place. above: the row above without filter, zeros for the first one;
/// pixel_bytes: 1..8, distance of the neighbour to the left. False for another type.
bool undo_filter(int type, std::uint8_t* row, const std::uint8_t* above, std::size_t row_bytes,
                 std::size_t pixel_bytes);

} // namespace diff
