#include "render/compare/shift.h"

#include "sim/base/error.h"
#include "sim/base/workers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace diff {

namespace {

/// Shifts up to this are looked for.
constexpr std::int64_t most_shift = 600;
/// Shifted frames are the same if thumbnails differ by no more than this [levels] (mean over a frame).
constexpr double same_levels = 0.25;
/// And the frames without shift differ by this many times more.
constexpr double least_gain = 4.0;

/// Of a file; black for one that cannot be read, which fits nothing.
Thumbnail read_thumbnail(const std::filesystem::path& path, const Settings& settings, PairMemory& memory) {
    try {
        read_file(path, settings.pair.accepted, memory.file_a);
        decode_picture(memory.file_a, path.string(), settings.pair.accepted, memory.a, memory.reader);
        return thumbnail_of(memory.a);
    } catch (const sim::Error&) {
        return {}; // the frame has its own status
    }
}

/// Of all frames of the candidate, and in the same way of the reference: those not taken yet are read. Where neither side's
/// was taken, the files are equal.
void take_missing(const Source& reference, const Source& candidate, const Settings& settings, Thumbnails& thumbnails) {
    sim::Workers workers(settings.threads);
    const auto take = [&](const Source& source, std::vector<std::optional<Thumbnail>>& of) {
        workers.run(of.size(), [&](std::size_t first, std::size_t last) {
            PairMemory memory;
            for (std::size_t i = first; i < last && !settings.is_interrupted(); ++i) {
                if (!of[i]) {
                    of[i] = read_thumbnail(source.path / source.names[i], settings, memory);
                }
            }
        });
    };
    std::vector<bool> was_taken(thumbnails.reference.size());
    std::transform(thumbnails.reference.begin(), thumbnails.reference.end(), was_taken.begin(),
                   [](const std::optional<Thumbnail>& thumbnail) { return thumbnail.has_value(); });
    take(reference, thumbnails.reference);
    for (std::size_t i = 0; i < thumbnails.candidate.size(); ++i) {
        const std::size_t same = place_in(reference, candidate.names[i]);
        if (!thumbnails.candidate[i] && same < was_taken.size() && !was_taken[same]) {
            thumbnails.candidate[i] = thumbnails.reference[same];
        }
    }
    take(candidate, thumbnails.candidate);
}

double distance(const Thumbnail& a, const Thumbnail& b) {
    float sum = 0.0f;
    for (std::size_t i = 0; i < a.size(); ++i) {
        sum += std::abs(a[i] - b[i]);
    }
    return static_cast<double>(sum) / static_cast<double>(a.size());
}

/// Largest distance of the frames that are shared at a shift, as far as it is below `limit`.
double worst_distance(const Thumbnails& thumbnails, std::int64_t shift, double limit) {
    const auto &a = thumbnails.reference, &b = thumbnails.candidate;
    double worst = 0.0;
    const auto count = static_cast<std::int64_t>(a.size());
    for (std::int64_t i = std::max<std::int64_t>(0, -shift);
         worst < limit && i < count && i + shift < static_cast<std::int64_t>(b.size()); ++i) {
        worst = std::max(worst, distance(*a[static_cast<std::size_t>(i)], *b[static_cast<std::size_t>(i + shift)]));
    }
    return worst;
}

} // namespace

std::size_t place_in(const Source& source, const std::string& name) {
    const auto found = std::lower_bound(source.names.begin(), source.names.end(), name);
    return found != source.names.end() && *found == name ? static_cast<std::size_t>(found - source.names.begin())
                                                         : source.names.size();
}

std::optional<std::int64_t> find_shift(const Source& reference, const Source& candidate, const Settings& settings,
                                       Thumbnails& thumbnails) {
    take_missing(reference, candidate, settings, thumbnails);
    if (settings.is_interrupted()) {
        return std::nullopt;
    }
    const auto &a = thumbnails.reference, &b = thumbnails.candidate;
    const auto least_shared = static_cast<std::int64_t>(std::max<std::size_t>(2, (std::max(a.size(), b.size()) + 1) / 2));
    const double unshifted = worst_distance(thumbnails, 0, std::numeric_limits<double>::max());
    std::optional<std::int64_t> best;
    double least = std::min(same_levels, unshifted / least_gain);
    for (std::int64_t size = 1; size <= most_shift; ++size) {
        for (const std::int64_t shift : {size, -size}) {
            const std::int64_t shared = std::min(static_cast<std::int64_t>(a.size()), static_cast<std::int64_t>(b.size()) - shift) -
                                        std::max<std::int64_t>(0, -shift);
            if (shared < least_shared) {
                continue;
            }
            const double now = worst_distance(thumbnails, shift, least);
            if (now < least) {
                least = now;
                best = shift;
            }
        }
    }
    return best;
}

} // namespace diff
