#pragma once
/// A picture in memory, and PNG files (sole user of stb).
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace render {

/// A line of text over a picture, and the pixels it covers.
struct TextLine {
    int x = 0;      ///< [px] upper left corner
    int y = 0;      ///< [px]
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
    std::string text;
};

/// 8-bit RGB, top row first, no padding between rows.
struct Image {
    int width = 0;                       ///< [px]
    int height = 0;                      ///< [px]
    std::vector<std::uint8_t> rgb;       ///< [height * width * 3]
    std::vector<TextLine> texts;         ///< what was written over it

    Image() = default;
    Image(int w, int h) : width(w), height(h), rgb(static_cast<std::size_t>(w) * h * 3) {}
};

/// The bytes of a PNG file, its texts too: a comparison reads them. Same picture, same bytes.
std::vector<std::uint8_t> encode_png(const Image& image);

/// Samples of a PNG file: 8 bits a channel, alpha not multiplied in; or 16 bits, the high byte first.
enum class PngKind { rgb8, rgba8, gray16, rgb16 };
std::vector<std::uint8_t> encode_png(PngKind kind, int width, int height, std::span<const std::uint8_t> samples,
                                     std::span<const TextLine> texts = {});

/// Reads a PNG (or JPEG) as 8-bit RGB. Throws Error (io).
Image read_image(const std::filesystem::path& path);

/// 8-bit red, green, blue and alpha, top row first; alpha not multiplied in.
struct AlphaImage {
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
    std::vector<std::uint8_t> rgba;
};
/// Of a PNG file's bytes. Throws Error (usage) for what is no whole picture.
AlphaImage decode_png(const std::string& bytes);
/// As high as asked for, and as wide as it was to its height.
AlphaImage resized(const AlphaImage& image, int height);

} // namespace render
