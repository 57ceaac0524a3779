#pragma once
/// The same frames, some frames earlier or later.
#include "render/compare/sequence.h"
#include "render/compare/thumbnail.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace diff {

/// Of the frames of two folders, in the order of their names; those of files that were decoded for something else.
struct Thumbnails {
    std::vector<std::optional<Thumbnail>> reference;
    std::vector<std::optional<Thumbnail>> candidate;
};

/// Of a name among the source's; their number if it has none.
std::size_t place_in(const Source& source, const std::string& name);

/// k != 0 if candidate frame i + k is about reference frame i, for all they share, at least half of the frames; none
/// if there is no such k, or frame i itself fits nearly as well. Both are folders of frames. Missing thumbnails are taken;
/// a frame of both that has none has equal files.
std::optional<std::int64_t> find_shift(const Source& reference, const Source& candidate, const Settings& settings,
                                       Thumbnails& thumbnails);

} // namespace diff
