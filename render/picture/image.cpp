#include "render/picture/image.h"

#include "sim/base/error.h"

#include <isa-l.h>
#include <stb_image.h>
#include <stb_image_resize.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <string>

namespace render {

namespace {

constexpr std::array<std::uint8_t, 8> png_signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

/// Compression level of ISA-L: up to 2 its bytes do not depend on the processor.
constexpr int deflate_level = 1;

struct StbDeleter {
    void operator()(std::uint8_t* pixels) const noexcept { stbi_image_free(pixels); }
};

void put_u32(std::uint8_t* at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i) {
        at[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
    }
}

/// Appends one chunk: length, type, data, CRC of type and data (PNG specification, sec. 5.3).
void append_chunk(std::vector<std::uint8_t>& file, const char* type, std::span<const std::uint8_t> data) {
    const std::size_t start = file.size();
    file.resize(start + 12 + data.size());
    std::uint8_t* chunk = file.data() + start;
    put_u32(chunk, static_cast<std::uint32_t>(data.size()));
    std::memcpy(chunk + 4, type, 4);
    if (!data.empty()) {
        std::memcpy(chunk + 8, data.data(), data.size());
    }
    put_u32(chunk + 8 + data.size(), crc32_gzip_refl(0, chunk + 4, 4 + data.size()));
}

/// As zlib's format has it (RFC 1950).
std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> data) {
    CHECK(data.size() <= std::numeric_limits<std::uint32_t>::max());
    std::vector<std::uint8_t> work(ISAL_DEF_LVL1_DEFAULT);
    isal_zstream stream;
    isal_deflate_init(&stream);
    stream.level = deflate_level;
    stream.level_buf = work.data();
    stream.level_buf_size = static_cast<std::uint32_t>(work.size());
    stream.gzip_flag = IGZIP_ZLIB;
    stream.end_of_stream = 1;
    stream.next_in = const_cast<std::uint8_t*>(data.data()); // not written to
    stream.avail_in = static_cast<std::uint32_t>(data.size());
    std::vector<std::uint8_t> packed;
    constexpr std::size_t least_room = 1 << 16;
    while (stream.internal_state.state != ZSTATE_END) {
        packed.resize(stream.total_out + std::max(least_room, data.size() / 4));
        stream.next_out = packed.data() + stream.total_out;
        stream.avail_out = static_cast<std::uint32_t>(packed.size() - stream.total_out);
        CHECK(isal_deflate(&stream) == COMP_OK);
    }
    packed.resize(stream.total_out);
    return packed;
}

/// International textual data (PNG specification, sec. 11.3.4.5): a line of text each, "X Y WIDTH HEIGHT TEXT";
/// render/compare/png_reader.cpp reads it.
void append_texts(std::vector<std::uint8_t>& file, std::span<const TextLine> texts) {
    std::string content("tumble:texts\0\0\0\0\0", 17); // keyword, not compressed, no language, not translated
    for (const TextLine& line : texts) {
        content += std::to_string(line.x) + " " + std::to_string(line.y) + " " + std::to_string(line.width) + " " +
                   std::to_string(line.height) + " " + line.text + "\n";
    }
    append_chunk(file, "iTXt", {reinterpret_cast<const std::uint8_t*>(content.data()), content.size()});
}

} // namespace

std::vector<std::uint8_t> encode_png(const Image& image) {
    return encode_png(PngKind::rgb8, image.width, image.height, image.rgb, image.texts);
}

std::vector<std::uint8_t> encode_png(PngKind kind, int width, int height, std::span<const std::uint8_t> samples,
                                     std::span<const TextLine> texts) {
    CHECK(width > 0 && height > 0);
    /// Bytes a pixel, bits a channel, colour type (0: gray, 2: RGB, 6: RGBA).
    struct Format {
        std::size_t pixel_bytes;
        std::uint8_t bits;
        std::uint8_t type;
    };
    constexpr std::array<Format, 4> formats{{{3, 8, 2}, {4, 8, 6}, {2, 16, 0}, {6, 16, 2}}};
    const auto [pixel_bytes, bits, type] = formats.at(static_cast<std::size_t>(kind));
    const std::size_t row_bytes = static_cast<std::size_t>(width) * pixel_bytes;
    CHECK(samples.size() == row_bytes * static_cast<std::size_t>(height));

    // Each row is preceded by its filter type, 0: none.
    const std::size_t raw_bytes = (row_bytes + 1) * static_cast<std::size_t>(height);
    const auto raw = std::make_unique_for_overwrite<std::uint8_t[]>(raw_bytes);
    for (int y = 0; y < height; ++y) {
        std::uint8_t* row = raw.get() + static_cast<std::size_t>(y) * (row_bytes + 1);
        row[0] = 0;
        std::memcpy(row + 1, samples.data() + static_cast<std::size_t>(y) * row_bytes, row_bytes);
    }

    const std::vector<std::uint8_t> packed = deflated({raw.get(), raw_bytes});

    // After the size bits and type, deflate, adaptive filtering, not interlaced.
    std::array<std::uint8_t, 13> header{0, 0, 0, 0, 0, 0, 0, 0, bits, type, 0, 0, 0};
    put_u32(header.data(), static_cast<std::uint32_t>(width));
    put_u32(header.data() + 4, static_cast<std::uint32_t>(height));

    std::vector<std::uint8_t> file;
    file.reserve(packed.size() + 64);
    file.assign(png_signature.begin(), png_signature.end());
    append_chunk(file, "IHDR", header);
    if (!texts.empty()) {
        append_texts(file, texts);
    }
    append_chunk(file, "IDAT", packed);
    append_chunk(file, "IEND", {});
    return file;
}

Image read_image(const std::filesystem::path& path) {
    int width = 0;
    int height = 0;
    int channels = 0;
    const std::unique_ptr<std::uint8_t, StbDeleter> pixels(
        stbi_load(path.string().c_str(), &width, &height, &channels, 3));
    if (pixels == nullptr) {
        throw sim::Error(sim::ExitCode::io,
                         "cannot read " + path.string() + ": no picture, or not a whole one");
    }
    Image image(width, height);
    std::memcpy(image.rgb.data(), pixels.get(), image.rgb.size());
    return image;
}

AlphaImage decode_png(const std::string& bytes) {
    AlphaImage image;
    int channels = 0;
    const std::unique_ptr<std::uint8_t, StbDeleter> pixels(
        bytes.size() > std::numeric_limits<int>::max()
            ? nullptr
            : stbi_load_from_memory(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size()),
                                    &image.width, &image.height, &channels, 4));
    if (pixels == nullptr) {
        throw sim::Error(sim::ExitCode::usage, "no picture, or not a whole one");
    }
    image.rgba.assign(pixels.get(), pixels.get() + std::size_t{4} * image.width * image.height);
    return image;
}

AlphaImage resized(const AlphaImage& image, int height) {
    CHECK(height > 0);
    AlphaImage result;
    result.height = height;
    result.width = std::max(1, static_cast<int>(std::lround(static_cast<double>(image.width) * height / image.height)));
    result.rgba.resize(std::size_t{4} * result.width * result.height);
    CHECK(stbir_resize_uint8_srgb(image.rgba.data(), image.width, image.height, 0, result.rgba.data(), result.width,
                                  result.height, 0, 4, 3, 0) == 1);
    return result;
}

} // namespace render
