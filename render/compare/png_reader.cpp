#include "render/compare/png_reader.h"

#include "render/compare/png_filter.h"
#include "sim/base/error.h"

#include <fmt/format.h>
#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

namespace diff {

namespace {

using ByteSpan = std::span<const std::uint8_t>;

constexpr std::array<std::uint8_t, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

/// Deflate makes at most this many bytes of one (RFC 1951: 258 bytes by two bits, and headers).
constexpr std::uint64_t largest_deflate_ratio = 1032;

/// Colour types (PNG specification, sec. 11.2.2).
enum ColorType { grey = 0, rgb = 2, palette = 3, grey_alpha = 4, rgb_alpha = 6 };

struct DecompressorDeleter {
    void operator()(libdeflate_decompressor* p) const noexcept { libdeflate_free_decompressor(p); }
};

/// What stands in the chunks of a file.
struct Chunks {
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    int depth = 0; ///< bits a sample
    int type = 0;
    bool is_interlaced = false;
    ByteSpan colors;       ///< PLTE
    ByteSpan transparency; ///< tRNS
    ByteSpan texts;        ///< iTXt of this program
    std::vector<ByteSpan> data; ///< IDAT

    std::size_t channels() const {
        constexpr std::size_t of_type[] = {1, 0, 3, 1, 2, 0, 4};
        return of_type[type];
    }
    std::size_t pixel_bits() const { return channels() * static_cast<std::size_t>(depth); }
    /// Distance of the neighbour to the left, for filters.
    std::size_t pixel_bytes() const { return std::max<std::size_t>(1, pixel_bits() / 8); }
    std::size_t row_bytes(std::uint32_t pixels) const { return (pixel_bits() * pixels + 7) / 8; }
};

/// Every dx-th pixel from x on, every dy-th row from y on: one of the pictures of Adam7, or the whole one.
struct Pass {
    std::uint32_t x, y, dx, dy;
    std::uint32_t columns(const Chunks& c) const { return c.width > x ? (c.width - x + dx - 1) / dx : 0; }
    std::uint32_t rows(const Chunks& c) const { return c.height > y ? (c.height - y + dy - 1) / dy : 0; }
    std::uint64_t raw_bytes(const Chunks& c) const {
        return columns(c) == 0 ? 0 : (c.row_bytes(columns(c)) + std::uint64_t{1}) * rows(c);
    }
};

std::span<const Pass> passes_of(const Chunks& chunks) {
    static constexpr Pass whole[] = {{0, 0, 1, 1}};
    static constexpr Pass adam7[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                     {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    return chunks.is_interlaced ? std::span<const Pass>(adam7) : std::span<const Pass>(whole);
}

std::uint32_t u32_at(const std::uint8_t* at) {
    return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 | at[3];
}

/// What begins the textual data that render/picture/image.cpp writes.
constexpr std::string_view texts_start("tumble:texts\0\0\0\0\0", 17);

bool is_texts(ByteSpan content) {
    return content.size() >= texts_start.size() && std::equal(texts_start.begin(), texts_start.end(), content.begin());
}

/// Lines "X Y WIDTH HEIGHT TEXT"; what is none is passed over, since anybody can write such a part.
std::vector<TextLine> parse_texts(ByteSpan content) {
    constexpr std::size_t most_lines = 1000;
    constexpr int farthest = 1'000'000; // [px]
    std::vector<TextLine> lines;
    std::string_view rest(reinterpret_cast<const char*>(content.data()), content.size());
    while (!rest.empty() && lines.size() < most_lines) {
        std::string_view text = rest.substr(0, rest.find('\n'));
        rest.remove_prefix(std::min(text.size() + 1, rest.size()));
        TextLine line;
        bool is_good = true;
        for (int* number : {&line.x, &line.y, &line.width, &line.height}) {
            const auto [next, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
            is_good = is_good && error == std::errc() && *number > -farthest && *number < farthest &&
                      next != text.data() + text.size() && *next == ' ';
            text.remove_prefix(is_good ? static_cast<std::size_t>(next - text.data()) + 1 : 0);
        }
        if (is_good) {
            line.text = text;
            lines.push_back(std::move(line));
        }
    }
    return lines;
}

class Reader {
public:
    Reader(const std::string& name, const PictureLimits& limits) : name_(name), limits_(limits) {}

    Chunks read_chunks(ByteSpan bytes) const {
        Chunks chunks;
        std::size_t at = signature.size();
        for (bool is_first = true;; is_first = false) {
            if (bytes.size() - at < 12) {
                fail("it ends early");
            }
            const std::uint32_t length = u32_at(bytes.data() + at);
            if (length > bytes.size() - at - 12) {
                fail("it ends early");
            }
            const ByteSpan typed = bytes.subspan(at + 4, length + 4u);
            if (libdeflate_crc32(0, typed.data(), typed.size()) != u32_at(typed.data() + typed.size())) {
                fail("a checksum is wrong");
            }
            const std::string type(typed.begin(), typed.begin() + 4);
            const ByteSpan content = typed.subspan(4);
            if (is_first != (type == "IHDR")) {
                fail("its header is not at the start");
            }
            if (type == "IHDR") {
                read_header(content, chunks);
            } else if (type == "PLTE") {
                chunks.colors = content;
            } else if (type == "tRNS") {
                chunks.transparency = content;
            } else if (type == "iTXt" && is_texts(content)) {
                chunks.texts = content.subspan(texts_start.size());
            } else if (type == "IDAT") {
                chunks.data.push_back(content);
            } else if (type == "IEND") {
                break;
            } else if ((type[0] & 32) == 0) {
                fail("it has a part '" + type + "' that is not known");
            }
            at += 12 + std::size_t{length};
        }
        check(chunks);
        return chunks;
    }

    /// Inflates all pixels into memory.raw.
    void inflate(const Chunks& chunks, ReaderMemory& memory) const {
        std::uint64_t raw_bytes = 0;
        for (const Pass& pass : passes_of(chunks)) {
            raw_bytes += pass.raw_bytes(chunks);
        }
        ByteSpan packed = chunks.data.front();
        if (chunks.data.size() > 1) {
            memory.packed.clear();
            for (const ByteSpan part : chunks.data) {
                memory.packed.insert(memory.packed.end(), part.begin(), part.end());
            }
            packed = memory.packed;
        }
        if (raw_bytes / largest_deflate_ratio > packed.size()) {
            fail("it has too few pixels");
        }
        memory.raw.resize(raw_bytes);
        const std::unique_ptr<libdeflate_decompressor, DecompressorDeleter> decompressor(
            libdeflate_alloc_decompressor());
        CHECK(decompressor != nullptr);
        if (libdeflate_zlib_decompress(decompressor.get(), packed.data(), packed.size(), memory.raw.data(),
                                       memory.raw.size(), nullptr) != LIBDEFLATE_SUCCESS) {
            fail("its pixels cannot be decompressed");
        }
    }

    [[noreturn]] void fail(const std::string& what) const {
        throw sim::Error(sim::ExitCode::io, name_ + ": damaged PNG file: " + what);
    }

private:
    void read_header(ByteSpan content, Chunks& chunks) const {
        if (content.size() != 13) {
            fail("its header has another length");
        }
        chunks.width = u32_at(content.data());
        chunks.height = u32_at(content.data() + 4);
        chunks.depth = content[8];
        chunks.type = content[9];
        chunks.is_interlaced = content[12] == 1;
        constexpr unsigned depths_of_type[] = {1 | 2 | 4 | 8 | 16, 0, 8 | 16, 1 | 2 | 4 | 8, 8 | 16, 0, 8 | 16};
        const bool is_known = chunks.type <= 6 && std::has_single_bit(static_cast<unsigned>(chunks.depth)) &&
                              (depths_of_type[chunks.type] & static_cast<unsigned>(chunks.depth)) != 0;
        if (!is_known || content[10] != 0 || content[11] != 0 || content[12] > 1) {
            fail("its kind is not known");
        }
        if (chunks.width == 0 || chunks.height == 0 || chunks.width > INT32_MAX || chunks.height > INT32_MAX) {
            fail("its size is not possible");
        }
        if (std::uint64_t{chunks.width} * chunks.height > limits_.pixels) {
            throw sim::Error(sim::ExitCode::io, fmt::format("{}: {}x{} pixels are more than the {} accepted", name_,
                                                            chunks.width, chunks.height, limits_.pixels));
        }
    }

    void check(const Chunks& chunks) const {
        if (chunks.data.empty()) {
            fail("it has no pixels");
        }
        if (chunks.type == palette && (chunks.colors.empty() || chunks.colors.size() % 3 != 0)) {
            fail("it has no palette");
        }
        const std::size_t key_bytes = chunks.type == grey ? 2 : 6;
        if ((chunks.type == grey || chunks.type == rgb) && !chunks.transparency.empty() &&
            chunks.transparency.size() != key_bytes) {
            fail("its transparent colour has another length");
        }
    }

    const std::string& name_;
    const PictureLimits& limits_;
};

/// Samples of one row -> colours of the picture.
class RowWriter {
public:
    RowWriter(const Chunks& chunks, const Reader& reader, Picture& picture)
        : chunks_(chunks), reader_(reader), picture_(picture) {}

    void write(const std::uint8_t* row, const Pass& pass, std::uint32_t y) {
        const std::size_t first = (std::size_t{pass.y} + std::size_t{y} * pass.dy) * chunks_.width + pass.x;
        const std::uint32_t columns = pass.columns(chunks_);
        if (chunks_.type == rgb && chunks_.depth == 8 && pass.dx == 1 && chunks_.transparency.empty()) {
            std::memcpy(&picture_.rgb[first * 3], row, std::size_t{columns} * 3);
            return;
        }
        if (chunks_.type == rgb_alpha && chunks_.depth == 8) {
            for (std::uint32_t x = 0; x < columns; ++x) {
                const std::uint8_t* from = row + 4 * std::size_t{x};
                put8(first + std::size_t{x} * pass.dx, from, from[3]);
            }
            return;
        }
        for (std::uint32_t x = 0; x < columns; ++x) {
            write_pixel(row, x, first + std::size_t{x} * pass.dx);
        }
    }

private:
    /// Sample i of a row, as it stands there.
    std::uint32_t sample(const std::uint8_t* row, std::size_t i) const {
        if (chunks_.depth == 16) {
            return std::uint32_t{row[2 * i]} << 8 | row[2 * i + 1];
        }
        const std::size_t bit = i * static_cast<std::size_t>(chunks_.depth);
        const int shift = 8 - chunks_.depth - static_cast<int>(bit % 8);
        return (static_cast<std::uint32_t>(row[bit / 8]) >> shift) & ((1u << chunks_.depth) - 1);
    }

    void write_pixel(const std::uint8_t* row, std::uint32_t x, std::size_t pixel) {
        const std::size_t channels = chunks_.channels();
        std::array<std::uint32_t, 4> samples{};
        for (std::size_t c = 0; c < channels; ++c) {
            samples[c] = sample(row, x * channels + c);
        }
        if (chunks_.type == palette) {
            const std::uint32_t index = samples[0];
            if (index * 3 >= chunks_.colors.size()) {
                reader_.fail("a pixel has no colour in the palette");
            }
            put8(pixel, chunks_.colors.data() + index * 3,
                 index < chunks_.transparency.size() ? chunks_.transparency[index] : 255);
            return;
        }
        const bool has_alpha = chunks_.type == grey_alpha || chunks_.type == rgb_alpha;
        const std::size_t colors = has_alpha ? channels - 1 : channels;
        std::uint8_t alpha = has_alpha ? to_8_bits(samples[colors], pixel, 3) : 255;
        if (!has_alpha && !chunks_.transparency.empty() && is_transparent(samples, colors)) {
            alpha = 0;
        }
        std::array<std::uint8_t, 3> color;
        for (std::size_t c = 0; c < 3; ++c) {
            color[c] = to_8_bits(samples[std::min(c, colors - 1)], pixel, c);
        }
        put8(pixel, color.data(), alpha);
    }

    bool is_transparent(const std::array<std::uint32_t, 4>& samples, std::size_t colors) const {
        for (std::size_t c = 0; c < colors; ++c) {
            const std::uint8_t* key = chunks_.transparency.data() + 2 * c;
            if (samples[c] != (std::uint32_t{key[0]} << 8 | key[1])) {
                return false;
            }
        }
        return true;
    }

    /// The nearest of 256 values; what is lost goes into the hash.
    std::uint8_t to_8_bits(std::uint32_t sample, std::size_t pixel, std::size_t channel) {
        if (chunks_.depth < 16) {
            return static_cast<std::uint8_t>(sample * 255 / ((1u << chunks_.depth) - 1));
        }
        const std::uint32_t value = (sample * 255 + 32895) >> 16;
        if (value * 257 != sample) {
            constexpr std::uint64_t fnv_prime = 0x100000001b3;
            picture_.fine_hash = (picture_.fine_hash ^ (pixel * 4 + channel) << 16 ^ sample) * fnv_prime;
        }
        return static_cast<std::uint8_t>(value);
    }

    void put8(std::size_t pixel, const std::uint8_t* color, std::uint8_t alpha) {
        std::uint8_t* to = &picture_.rgb[pixel * 3];
        if (alpha == 255) {
            std::memcpy(to, color, 3);
            return;
        }
        if (picture_.alpha.empty()) {
            picture_.alpha.assign(picture_.rgb.size() / 3, 255);
        }
        picture_.alpha[pixel] = alpha;
        for (int c = 0; c < 3; ++c) {
            to[c] = static_cast<std::uint8_t>((color[c] * alpha + 127) / 255);
        }
    }

    const Chunks& chunks_;
    const Reader& reader_;
    Picture& picture_;
};

} // namespace

bool is_png(ByteSpan bytes) {
    return bytes.size() >= signature.size() && std::equal(signature.begin(), signature.end(), bytes.begin());
}

std::pair<int, int> size_of_png(ByteSpan bytes, const std::string& name, const PictureLimits& limits) {
    const Chunks chunks = Reader(name, limits).read_chunks(bytes);
    return {static_cast<int>(chunks.width), static_cast<int>(chunks.height)};
}

void decode_png(ByteSpan bytes, const std::string& name, const PictureLimits& limits, Picture& picture,
                ReaderMemory& memory) {
    const Reader reader(name, limits);
    const Chunks chunks = reader.read_chunks(bytes);
    reader.inflate(chunks, memory);
    picture.width = static_cast<int>(chunks.width);
    picture.height = static_cast<int>(chunks.height);
    picture.rgb.resize(std::size_t{chunks.width} * chunks.height * 3);
    picture.alpha.clear();
    picture.fine_hash = 0;
    picture.texts = parse_texts(chunks.texts);
    RowWriter writer(chunks, reader, picture);
    const Bytes zeros(chunks.row_bytes(chunks.width));
    std::uint8_t* row = memory.raw.data();
    for (const Pass& pass : passes_of(chunks)) {
        const std::size_t row_bytes = chunks.row_bytes(pass.columns(chunks));
        const std::uint8_t* above = zeros.data();
        for (std::uint32_t y = 0; row_bytes > 0 && y < pass.rows(chunks); ++y) {
            if (!undo_filter(row[0], row + 1, above, row_bytes, chunks.pixel_bytes())) {
                reader.fail("a row has a filter that is not known");
            }
            writer.write(row + 1, pass, y);
            above = row + 1;
            row += row_bytes + 1;
        }
    }
}

} // namespace diff
