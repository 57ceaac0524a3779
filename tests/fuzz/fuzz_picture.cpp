/// libFuzzer: any bytes are a picture or a sim::Error. Checksums of a PNG's chunks are set right too, or no changed
/// byte would get past them.
#include "render/compare/picture.h"
#include "sim/base/error.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace {

constexpr diff::PictureLimits limits{.file_bytes = 1u << 20, .pixels = 1u << 18};
constexpr std::size_t signature = 8, around = 12; // bytes: before the chunks, and of a chunk beside its data

std::uint32_t big_endian(const std::uint8_t* at) {
    return std::uint32_t{at[0]} << 24 | std::uint32_t{at[1]} << 16 | std::uint32_t{at[2]} << 8 | at[3];
}

void set_checksums(diff::Bytes& png) {
    for (std::size_t at = signature; at + around <= png.size();) {
        const std::size_t length = big_endian(&png[at]);
        if (length > png.size() - at - around) {
            return;
        }
        const std::uint32_t crc = libdeflate_crc32(0, &png[at + 4], length + 4);
        for (std::size_t i = 0; i < 4; ++i) {
            png[at + 8 + length + i] = static_cast<std::uint8_t>(crc >> (24 - 8 * i));
        }
        at += around + length;
    }
}

void decode(const diff::Bytes& bytes) {
    diff::Picture picture;
    diff::ReaderMemory memory;
    try {
        diff::decode_picture(bytes, "fuzz", limits, picture, memory);
        const auto pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
        CHECK(pixels > 0 && pixels <= limits.pixels);
        CHECK(picture.rgb.size() == 3 * pixels);
        CHECK(picture.alpha.empty() || picture.alpha.size() == pixels);
        CHECK(diff::size_of_picture(bytes, "fuzz", limits) == std::pair(picture.width, picture.height));
    } catch (const sim::Error& error) {
        CHECK(error.code() == sim::ExitCode::io);
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    diff::Bytes bytes(data, data + size);
    decode(bytes);
    set_checksums(bytes);
    decode(bytes);
    return 0;
}
