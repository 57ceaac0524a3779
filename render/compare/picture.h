#pragma once
/// Pictures of any program as 8-bit colours: PNG of every kind, JPEG. The reader refuses what is damaged or too
/// large before it takes memory for it.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace diff {

/// A line of text that the program which drew a picture has written over it.
struct TextLine {
    int x = 0;      ///< [px] upper left corner
    int y = 0;      ///< [px]
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
    std::string text;
    bool is_masked = false; ///< a pixel of it is
};

/// 8-bit RGB, top row first, no padding. A buffer that is used again costs no new memory.
struct Picture {
    int width = 0;                   ///< [px]
    int height = 0;                  ///< [px]
    std::vector<std::uint8_t> rgb;   ///< [height * width * 3], multiplied by alpha: as seen on black
    std::vector<std::uint8_t> alpha; ///< [height * width]; empty if every pixel is opaque
    std::uint64_t fine_hash = 0;     ///< of samples that 8 bits do not hold; 0 if there are none
    std::vector<TextLine> texts;     ///< of pictures that this program has drawn; empty if the file does not tell
};

/// What a reader accepts.
struct PictureLimits {
    std::uint64_t file_bytes = 256u << 20;
    std::uint64_t pixels = 100'000'000; ///< 8K is 33 million
};

using Bytes = std::vector<std::uint8_t>;

/// Memory of a reader, to be used again.
struct ReaderMemory {
    Bytes packed; ///< compressed pixels of a file that has them in several parts
    Bytes raw;    ///< rows with their filters
};

/// The whole file. Throws Error (io) if it cannot be read or is larger than the limit.
void read_file(const std::filesystem::path& path, const PictureLimits& limits, Bytes& bytes);

/// Decodes a PNG or JPEG file's bytes; `name` is for messages. Throws Error (io).
void decode_picture(std::span<const std::uint8_t> bytes, const std::string& name, const PictureLimits& limits,
                    Picture& picture, ReaderMemory& memory);

/// Width and height [px] of a PNG or JPEG file that is whole, without decompressing a PNG. Throws Error (io).
std::pair<int, int> size_of_picture(std::span<const std::uint8_t> bytes, const std::string& name,
                                    const PictureLimits& limits);

/// True if no pixel differs, in no bit.
bool is_equal(const Picture& a, const Picture& b);

/// A picture of 8-bit indices into a palette.
struct IndexedPicture {
    int width = 0;                       ///< [px]
    int height = 0;                      ///< [px]
    std::vector<std::uint8_t> indices;   ///< [height * width]
    std::vector<std::uint8_t> palette;   ///< [256 * 3] RGB
};

/// The bytes of a PNG file.
Bytes encode_png(const IndexedPicture& picture);
Bytes encode_png(const Picture& picture);

} // namespace diff
