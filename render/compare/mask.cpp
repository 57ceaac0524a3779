#include "render/compare/mask.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>

namespace diff {

namespace {

using sim::Error;
using sim::ExitCode;

/// "10,20,300,40": four whole numbers.
std::optional<Box> parse_box(const std::string& text) {
    int values[4];
    const char* at = text.data();
    const char* end = at + text.size();
    for (int i = 0; i < 4; ++i) {
        const auto [next, error] = std::from_chars(at, end, values[i]);
        if (error != std::errc() || (i < 3 ? next == end || *next != ',' : next != end)) {
            return std::nullopt;
        }
        at = next + 1;
    }
    return Box{values[0], values[1], values[2], values[3]};
}

/// Pixels begin .. end - 1 of one row.
void take_over(const Picture& reference, Picture& candidate, int y, int begin, int end) {
    const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(reference.width) +
                              static_cast<std::size_t>(begin);
    const auto count = static_cast<std::size_t>(end - begin);
    std::memcpy(&candidate.rgb[first * 3], &reference.rgb[first * 3], count * 3);
    if (!reference.alpha.empty()) {
        std::memcpy(&candidate.alpha[first], &reference.alpha[first], count);
    }
}

} // namespace

void add_to_mask(const std::string& text, const PictureLimits& accepted, Mask& mask) {
    if (const std::optional<Box> box = parse_box(text)) {
        if (box->width <= 0 || box->height <= 0) {
            throw Error(ExitCode::usage, fmt::format("--mask '{}': expected a width and a height > 0", text));
        }
        mask.boxes.push_back(*box);
        return;
    }
    if (!std::filesystem::exists(text)) {
        throw Error(
            ExitCode::usage,
            fmt::format("--mask '{}': neither X,Y,WIDTH,HEIGHT in pixels nor a picture that is there", text));
    }
    Bytes bytes;
    read_file(text, accepted, bytes);
    ReaderMemory memory;
    Picture picture;
    decode_picture(bytes, text, accepted, picture, memory);
    mask.pictures.push_back(std::move(picture));
}

namespace {

/// Throws Error (usage) if no pixel is left to compare. covered: [height * width] pixels that a mask hides.
void require_rest(const std::vector<bool>& covered) {
    if (std::find(covered.begin(), covered.end(), false) == covered.end()) {
        throw Error(ExitCode::usage, "the masks leave no pixel to compare");
    }
}

/// covered: as above, of a picture `width` pixels wide.
void mask_texts(const std::vector<bool>& covered, Picture& picture) {
    for (TextLine& line : picture.texts) {
        const int right = std::min(line.x + line.width, picture.width);
        for (int y = std::max(line.y, 0); y < std::min(line.y + line.height, picture.height); ++y) {
            for (int x = std::max(line.x, 0); x < right; ++x) {
                line.is_masked = line.is_masked || covered[static_cast<std::size_t>(y * picture.width + x)];
            }
        }
    }
}

} // namespace

void apply_mask(const Mask& mask, Picture& reference, Picture& candidate) {
    if (mask.is_empty()) {
        return;
    }
    const auto width = static_cast<std::size_t>(reference.width);
    std::vector<bool> covered(width * static_cast<std::size_t>(reference.height));
    const auto cover = [&](int y, int begin, int end) {
        take_over(reference, candidate, y, begin, end);
        const auto row = covered.begin() + static_cast<std::ptrdiff_t>(width * static_cast<std::size_t>(y));
        std::fill(row + begin, row + end, true);
    };
    // Both get an alpha if one has: a masked pixel takes it over.
    if (candidate.alpha.empty() && !reference.alpha.empty()) {
        candidate.alpha.assign(reference.alpha.size(), 255);
    }
    for (const Box& box : mask.boxes) {
        const std::int64_t right = std::int64_t{box.x} + box.width;
        const std::int64_t bottom = std::int64_t{box.y} + box.height;
        if (box.x >= reference.width || box.y >= reference.height || right <= 0 || bottom <= 0) {
            throw Error(ExitCode::missing_or_size,
                        fmt::format("--mask '{},{},{},{}' lies outside the picture of {}x{} pixels", box.x,
                                    box.y, box.width, box.height, reference.width, reference.height));
        }
        const int begin = std::clamp(box.x, 0, reference.width);
        const auto end = static_cast<int>(std::clamp<std::int64_t>(right, begin, reference.width));
        for (int y = std::max(box.y, 0); y < std::min<std::int64_t>(bottom, reference.height); ++y) {
            cover(y, begin, end);
        }
    }
    for (const Picture& picture : mask.pictures) {
        if (picture.width != reference.width || picture.height != reference.height) {
            throw Error(ExitCode::missing_or_size,
                        fmt::format("the mask has {}x{} pixels, the picture {}x{}", picture.width,
                                    picture.height, reference.width, reference.height));
        }
        for (int y = 0; y < reference.height; ++y) {
            const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(reference.width);
            for (int x = 0; x < reference.width; ++x) {
                const std::uint8_t* rgb = &picture.rgb[(row + static_cast<std::size_t>(x)) * 3];
                if (rgb[0] != 0 || rgb[1] != 0 || rgb[2] != 0) {
                    cover(y, x, x + 1);
                }
            }
        }
    }
    require_rest(covered);
    mask_texts(covered, reference);
    mask_texts(covered, candidate);
}

} // namespace diff
