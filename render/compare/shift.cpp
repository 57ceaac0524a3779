#include "render/compare/shift.h"

#include "sim/base/error.h"
#include "sim/base/workers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace diff {

namespace {

constexpr int side = 16; ///< of a thumbnail [px]
using Thumbnail = std::array<float, side * side * 3>; ///< mean colours [levels]

/// Shifts up to this are looked for.
constexpr std::int64_t most_shift = 600;
/// Shifted frames are the same if thumbnails differ by no more than this [levels] (mean over a frame).
constexpr double same_levels = 0.25;
/// And the frames without shift differ by this many times more.
constexpr double least_gain = 4.0;

/// First row or column of a picture in cell k of the thumbnail.
int cell_start(int k, int size) {
    return static_cast<int>((std::int64_t{k} * size + side - 1) / side);
}

Thumbnail thumbnail_of(const Picture& picture) {
    Thumbnail means{};
    std::vector<std::uint32_t> sums; // of the rows of a cell
    for (int row = 0; row < side; ++row) {
        const int top = cell_start(row, picture.height);
        const int bottom = cell_start(row + 1, picture.height);
        sum_rows(picture, top, bottom, sums);
        for (int column = 0; column < side; ++column) {
            const int left = cell_start(column, picture.width);
            const int right = cell_start(column + 1, picture.width);
            const int count = std::max((bottom - top) * (right - left), 1);
            for (int c = 0; c < 3; ++c) {
                std::uint64_t sum = 0;
                for (int x = left; x < right; ++x) {
                    sum += sums[static_cast<std::size_t>(3 * x + c)];
                }
                means[static_cast<std::size_t>((row * side + column) * 3 + c)] =
                    static_cast<float>(sum) / static_cast<float>(count);
            }
        }
    }
    return means;
}

/// Of all frames; black for one that cannot be read, which fits nothing.
std::vector<Thumbnail> thumbnails_of(const Source& source, const Settings& settings) {
    std::vector<Thumbnail> thumbnails(source.names.size());
    sim::Workers workers(settings.threads);
    workers.run(thumbnails.size(), [&](std::size_t first, std::size_t last) {
        PairMemory memory;
        for (std::size_t i = first; i < last && !settings.is_interrupted(); ++i) {
            try {
                const std::filesystem::path path = source.path / source.names[i];
                read_file(path, settings.pair.accepted, memory.file_a);
                decode_picture(memory.file_a, path.string(), settings.pair.accepted, memory.a, memory.reader);
                thumbnails[i] = thumbnail_of(memory.a);
            } catch (const sim::Error&) {
                // The frame has its own status.
            }
        }
    });
    return thumbnails;
}

double distance(const Thumbnail& a, const Thumbnail& b) {
    float sum = 0.0f;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += std::abs(a[i] - b[i]);
    }
    return static_cast<double>(sum) / static_cast<double>(a.size());
}

/// Largest distance of the frames that are shared at a shift, as far as it is below `limit`.
double worst_distance(const std::vector<Thumbnail>& a, const std::vector<Thumbnail>& b, std::int64_t shift,
                      double limit) {
    double worst = 0.0;
    const auto count = static_cast<std::int64_t>(a.size());
    for (std::int64_t i = std::max<std::int64_t>(0, -shift);
         worst < limit && i < count && i + shift < static_cast<std::int64_t>(b.size()); ++i) {
        worst = std::max(worst, distance(a[static_cast<std::size_t>(i)], b[static_cast<std::size_t>(i + shift)]));
    }
    return worst;
}

} // namespace

std::optional<std::int64_t> find_shift(const Source& reference, const Source& candidate, const Settings& settings) {
    const std::vector<Thumbnail> a = thumbnails_of(reference, settings);
    const std::vector<Thumbnail> b = thumbnails_of(candidate, settings);
    const auto least_shared = static_cast<std::int64_t>(std::max<std::size_t>(2, (std::max(a.size(), b.size()) + 1) / 2));
    const double unshifted = worst_distance(a, b, 0, std::numeric_limits<double>::max());
    std::optional<std::int64_t> best;
    double least = std::min(same_levels, unshifted / least_gain);
    for (std::int64_t size = 1; size <= most_shift; ++size) {
        for (const std::int64_t shift : {size, -size}) {
            const std::int64_t shared = std::min(static_cast<std::int64_t>(a.size()), static_cast<std::int64_t>(b.size()) - shift) -
                                        std::max<std::int64_t>(0, -shift);
            if (shared < least_shared) {
                continue;
            }
            const double now = worst_distance(a, b, shift, least);
            if (now < least) {
                least = now;
                best = shift;
            }
        }
    }
    return best;
}

} // namespace diff
