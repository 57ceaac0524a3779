#include "render/film/raw_writer.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <string>

namespace render {

namespace {

/// ITU-R BT.709-6, sec. 3: luma of gamma-encoded R, G, B; and how far B and R may be from it.
constexpr float luma_r = 0.2126f, luma_g = 0.7152f, luma_b = 0.0722f;
constexpr float most_cb = 2.0f * (1.0f - luma_b), most_cr = 2.0f * (1.0f - luma_r);

std::uint8_t rounded(float value) {
    return static_cast<std::uint8_t>(value + 0.5f);
}

[[noreturn]] void throw_unwritten() {
    throw sim::Error(sim::is_output_unread() ? sim::ExitCode::good : sim::ExitCode::io, "cannot write to standard output");
}

} // namespace

RawWriter::RawWriter(std::FILE* file, RawFormat format, const Image& first, const sim::Rational& fps)
    : file_(file), format_(format) {
    if (format_ == RawFormat::y4m) {
        const std::string head = fmt::format("YUV4MPEG2 W{} H{} F{}:{} Ip A1:1 C444 XCOLORRANGE=LIMITED\n", first.width,
                                             first.height, fps.num, fps.den);
        write(head.data(), head.size());
        planes_.resize(first.rgb.size());
    }
}

void RawWriter::add(const Image& image) {
    if (format_ == RawFormat::rgb24) {
        write(image.rgb.data(), image.rgb.size());
        return;
    }
    CHECK(image.rgb.size() == planes_.size());
    const std::size_t count = planes_.size() / 3;
    for (std::size_t i = 0; i < count; ++i) {
        const float r = image.rgb[3 * i], g = image.rgb[3 * i + 1], b = image.rgb[3 * i + 2];
        const float y = luma_r * r + luma_g * g + luma_b * b;
        planes_[i] = rounded(16.0f + 219.0f / 255.0f * y);
        planes_[count + i] = rounded(128.0f + 224.0f / 255.0f * (b - y) / most_cb);
        planes_[2 * count + i] = rounded(128.0f + 224.0f / 255.0f * (r - y) / most_cr);
    }
    write("FRAME\n", 6);
    write(planes_.data(), planes_.size());
}

void RawWriter::finish() {
    if (std::fflush(file_) != 0) {
        throw_unwritten();
    }
}

void RawWriter::write(const void* bytes, std::size_t count) {
    if (std::fwrite(bytes, 1, count, file_) != count) {
        throw_unwritten();
    }
}

} // namespace render
