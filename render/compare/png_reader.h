#pragma once
/// PNG files of every colour type, depth and order of rows -> Picture.
#include "render/compare/picture.h"

#include <span>
#include <string>
#include <utility>

namespace diff {

/// True if the bytes begin as a PNG file does.
bool is_png(std::span<const std::uint8_t> bytes);

/// Checksums are checked and the size is held against the limits before memory is taken. `name` is for messages.
/// Throws Error (io).
void decode_png(std::span<const std::uint8_t> bytes, const std::string& name, const PictureLimits& limits,
                Picture& picture, ReaderMemory& memory);

/// Width and height of a file whose parts and checksums are right. Throws Error (io).
std::pair<int, int> size_of_png(std::span<const std::uint8_t> bytes, const std::string& name,
                                const PictureLimits& limits);

} // namespace diff
