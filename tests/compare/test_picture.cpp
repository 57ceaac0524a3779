// The reader of PNG files against stb's, on files of every kind; damaged files are refused.
#include "render/compare/picture.h"
#include "render/compare/png_reader.h"
#include "sim/base/error.h"
#include "tests/compare/painter.h"

#include <gtest/gtest.h>
#include <libdeflate.h>
#include <stb_image.h>
#include <stb_image_write.h>

#include <cstring>
#include <string>

namespace {

using diff::Bytes;
using diff::Picture;

void put_u32(Bytes& bytes, std::uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        bytes.push_back(static_cast<std::uint8_t>(value >> shift));
    }
}

void append_chunk(Bytes& file, const char* type, const Bytes& data) {
    put_u32(file, static_cast<std::uint32_t>(data.size()));
    Bytes typed(type, type + 4);
    typed.insert(typed.end(), data.begin(), data.end());
    file.insert(file.end(), typed.begin(), typed.end());
    put_u32(file, libdeflate_crc32(0, typed.data(), typed.size()));
}

Bytes deflated(const Bytes& raw) {
    libdeflate_compressor* compressor = libdeflate_alloc_compressor(6);
    Bytes packed(libdeflate_zlib_compress_bound(compressor, raw.size()));
    packed.resize(libdeflate_zlib_compress(compressor, raw.data(), raw.size(), packed.data(), packed.size()));
    libdeflate_free_compressor(compressor);
    return packed;
}

struct Kind {
    int type;
    int depth;
    bool is_interlaced;
    bool has_transparency; ///< tRNS
};

/// A file of random samples and random filters: any bytes are a picture.
Bytes random_png(const Kind& kind, int width, int height, std::uint32_t seed) {
    test::Random random(seed);
    const int channels[] = {1, 0, 3, 1, 2, 0, 4};
    const int bits = channels[kind.type] * kind.depth;
    Bytes raw;
    const auto add_rows = [&](int columns, int rows) {
        for (int y = 0; columns > 0 && y < rows; ++y) {
            raw.push_back(static_cast<std::uint8_t>(5 * random()));
            for (int i = 0; i < (columns * bits + 7) / 8; ++i) {
                // Indices stay below 16 entries of the palette.
                raw.push_back(static_cast<std::uint8_t>(kind.type == 3 && kind.depth == 8 ? 0 : 256 * random()));
            }
        }
    };
    if (kind.is_interlaced) {
        constexpr int adam7[][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4}, {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
        for (const auto& [x, y, dx, dy] : adam7) {
            add_rows((width - x + dx - 1) / dx, (height - y + dy - 1) / dy);
        }
    } else {
        add_rows(width, height);
    }
    Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    Bytes header;
    put_u32(header, static_cast<std::uint32_t>(width));
    put_u32(header, static_cast<std::uint32_t>(height));
    header.insert(header.end(), {static_cast<std::uint8_t>(kind.depth), static_cast<std::uint8_t>(kind.type), 0, 0,
                                 static_cast<std::uint8_t>(kind.is_interlaced)});
    append_chunk(file, "IHDR", header);
    if (kind.type == 3) {
        Bytes palette;
        for (int i = 0; i < 3 * (1 << kind.depth); ++i) {
            palette.push_back(static_cast<std::uint8_t>(256 * random()));
        }
        append_chunk(file, "PLTE", palette);
    }
    if (kind.has_transparency) {
        append_chunk(file, "tRNS", kind.type == 3 ? Bytes{0, 128} : Bytes(kind.type == 0 ? 2u : 6u, 0));
    }
    const Bytes packed = deflated(raw);
    const auto half = packed.begin() + static_cast<long>(packed.size() / 2);
    append_chunk(file, "IDAT", Bytes(packed.begin(), half));
    append_chunk(file, "IDAT", Bytes(half, packed.end()));
    append_chunk(file, "IEND", {});
    return file;
}

Picture decoded(const Bytes& bytes) {
    Picture picture;
    diff::ReaderMemory memory;
    diff::decode_picture(bytes, "test", {}, picture, memory);
    return picture;
}

std::string refusal(const Bytes& bytes, const diff::PictureLimits& limits = {}) {
    try {
        Picture picture;
        diff::ReaderMemory memory;
        diff::decode_picture(bytes, "test", limits, picture, memory);
        return {};
    } catch (const sim::Error& error) {
        EXPECT_EQ(error.code(), sim::ExitCode::io);
        return error.what();
    }
}

} // namespace

TEST(picture, png_files_of_every_kind_are_read_as_by_stb) {
    std::vector<Kind> kinds;
    const std::vector<int> depths[] = {{1, 2, 4, 8, 16}, {}, {8, 16}, {1, 2, 4, 8}, {8, 16}, {}, {8, 16}};
    for (int type = 0; type <= 6; ++type) {
        for (const int depth : depths[type]) {
            for (const bool is_interlaced : {false, true}) {
                kinds.push_back({type, depth, is_interlaced, false});
                if (type <= 3) {
                    kinds.push_back({type, depth, is_interlaced, true});
                }
            }
        }
    }
    for (const Kind& kind : kinds) {
        for (const auto& [width, height] : {std::pair{1, 1}, {3, 5}, {37, 23}}) {
            const Bytes file = random_png(kind, width, height, static_cast<std::uint32_t>(kind.type * 100 + kind.depth));
            const Picture picture = decoded(file);
            int w = 0, h = 0, n = 0;
            stbi_us* stb = stbi_load_16_from_memory(file.data(), static_cast<int>(file.size()), &w, &h, &n, 4);
            ASSERT_NE(stb, nullptr) << stbi_failure_reason();
            ASSERT_EQ(picture.width, w);
            ASSERT_EQ(picture.height, h);
            for (int i = 0; i < w * h; ++i) {
                const auto to8 = [](unsigned v) { return (v * 255 + 32895) >> 16; };
                const unsigned alpha = to8(stb[4 * i + 3]);
                EXPECT_EQ(picture.alpha.empty() ? 255u : picture.alpha[static_cast<std::size_t>(i)], alpha);
                for (int c = 0; c < 3; ++c) {
                    ASSERT_EQ(picture.rgb[static_cast<std::size_t>(3 * i + c)], (to8(stb[4 * i + c]) * alpha + 127) / 255)
                        << "type " << kind.type << ", depth " << kind.depth << ", pixel " << i << " of " << w << "x" << h;
                }
            }
            stbi_image_free(stb);
        }
    }
}

TEST(picture, what_8_bits_do_not_hold_is_not_lost) {
    const Bytes a = random_png({2, 16, false, false}, 20, 20, 1);
    Picture fine = decoded(a);
    EXPECT_NE(fine.fine_hash, 0u);
    Picture other = fine;
    other.fine_hash ^= 1;
    EXPECT_FALSE(diff::is_equal(fine, other));
    EXPECT_EQ(decoded(random_png({2, 8, false, false}, 20, 20, 1)).fine_hash, 0u);
}

TEST(picture, damaged_files_are_refused_at_every_byte) {
    const Bytes whole = random_png({6, 8, false, false}, 9, 9, 3);
    ASSERT_EQ(refusal(whole), "");
    for (std::size_t length = 0; length < whole.size(); ++length) {
        EXPECT_NE(refusal(Bytes(whole.begin(), whole.begin() + static_cast<long>(length))), "") << length;
    }
    // Every byte of a chunk is under its checksum or decides where the next begins.
    for (std::size_t i = 0; i < whole.size(); ++i) {
        Bytes damaged = whole;
        damaged[i] ^= 0x55;
        EXPECT_NE(refusal(damaged), "") << i;
    }
    EXPECT_NE(refusal({'G', 'I', 'F', '8', '9', 'a'}).find("neither a PNG nor a JPEG"), std::string::npos);
}

TEST(picture, sizes_beyond_the_limits_and_bombs_are_refused_before_memory_is_taken) {
    Bytes header;
    put_u32(header, 20000);
    put_u32(header, 4000);
    header.insert(header.end(), {16, 6, 0, 0, 0});
    Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    append_chunk(file, "IHDR", header);
    append_chunk(file, "IDAT", deflated({0, 1, 2}));
    append_chunk(file, "IEND", {});
    EXPECT_NE(refusal(file).find("too few pixels"), std::string::npos);
    EXPECT_NE(refusal(file, {.pixels = 1000000}).find("20000x4000 pixels are more than the 1000000 accepted"), std::string::npos);
}

TEST(picture, jpeg_files_are_read_and_damaged_ones_refused) {
    const Picture picture = test::paint(test::make_scene(1, 5, 0), test::grid_pattern(1));
    Bytes file;
    stbi_write_jpg_to_func(
        [](void* to, void* data, int size) {
            const auto* bytes = static_cast<std::uint8_t*>(data);
            static_cast<Bytes*>(to)->insert(static_cast<Bytes*>(to)->end(), bytes, bytes + size);
        },
        &file, picture.width, picture.height, 3, picture.rgb.data(), 95);
    const Picture read = decoded(file);
    EXPECT_EQ(read.width, picture.width);
    double sum = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i) {
        sum += std::abs(read.rgb[i] - picture.rgb[i]);
    }
    EXPECT_LT(sum / static_cast<double>(picture.rgb.size()), 3.0);
    EXPECT_NE(refusal(Bytes(file.begin(), file.begin() + 100)), "");
}

TEST(picture, what_is_written_is_read_again) {
    const Picture picture = test::paint(test::make_scene(2, 5, 0), test::grid_pattern(1));
    EXPECT_TRUE(diff::is_equal(decoded(diff::encode_png(picture)), picture));
    diff::IndexedPicture indexed{2, 1, {7, 9}, Bytes(256 * 3, 0)};
    indexed.palette[9 * 3 + 1] = 200;
    EXPECT_EQ(decoded(diff::encode_png(indexed)).rgb, (Bytes{0, 0, 0, 0, 200, 0}));
}
