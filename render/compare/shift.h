#pragma once
/// The same frames, some frames earlier or later.
#include "render/compare/sequence.h"

#include <cstdint>
#include <optional>

namespace diff {

/// k != 0 if candidate frame i + k is about reference frame i, for all they share, at least half of the frames; none
/// if there is no such k, or frame i itself fits nearly as well. Both are folders of frames. Throws Error (io).
std::optional<std::int64_t> find_shift(const Source& reference, const Source& candidate, const Settings& settings);

} // namespace diff
