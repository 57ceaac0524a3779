#pragma once
/// Pictures -> a pipe, as they are, for programs that encode by themselves.
///
/// rgb24: R, G, B of each pixel, top row first, nothing between frames. y4m: YUV4MPEG2, a line at the head with size and frame
/// rate, then planes Y, Cb, Cr of each frame, all of the picture's size (4:4:4), by BT.709, limited range.
#include "render/picture/image.h"
#include "sim/base/rational.h"

#include <cstdint>
#include <cstdio>
#include <vector>

namespace render {

enum class RawFormat { rgb24, y4m };

class RawWriter {
public:
    /// Writes the head. `file` must outlive it. Throws Error, as all: io; good where standard output
    /// is read no more, which ends the film quietly.
    RawWriter(std::FILE* file, RawFormat format, const Image& first, const sim::Rational& fps);

    /// A picture of the size of the first.
    void add(const Image& image);

    void finish();

private:
    void write(const void* bytes, std::size_t count);

    std::FILE* file_;
    RawFormat format_;
    std::vector<std::uint8_t> planes_;
};

} // namespace render
