#pragma once
/// Reference and candidate, whatever they are -> Case; pairs in parallel, in memory that does not depend on their
/// number.
#include "render/compare/pair.h"
#include "render/compare/result.h"
#include "render/compare/source.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace diff {

struct Settings {
    PairSettings pair;
    Tier fail_on = Tier::changed;
    int threads = 1;
    std::function<bool()> is_interrupted = [] { return false; };
};

inline constexpr std::size_t default_pictures = 16;

/// What is compared.
struct Sides {
    const Source& reference;
    const Source& candidate;
};

/// Where pictures for review go.
struct ReviewSettings {
    std::filesystem::path folder;              ///< of the report; exists
    std::size_t most_frames = default_pictures; ///< of one case that get pictures: the first bad one and the worst
};

/// Sees each pair as soon as it is compared, several at once and in any order, with its pictures and what differs in the
/// memory: of a missing side another's, of files with the same bytes none. i: its place in Case::frames.
using SeePair = std::function<void(std::size_t i, const PairMemory& memory, const Frame& frame)>;

/// Compares. films: null if none of the two is a film: CHECK. see: may be empty. Throws Error: missing_or_size or usage if
/// the two are of different kinds, io if a folder cannot be read, interrupted; and what `see` throws.
Case compare_sources(const std::string& name, const Sides& sides, const Settings& settings, const FilmTools* films,
                     const SeePair& see);

/// The frames of both, in the order of Case::frames; of two pictures the name of one.
std::vector<std::string> frame_names(const Sides& sides);
/// None where this side has no such frame.
std::optional<std::filesystem::path> path_in(const Source& source, const std::string& name);

/// Writes pictures for review of what is not identical, and enters their paths. Throws Error (io).
void write_review(const Sides& sides, const Settings& settings,
                  const ReviewSettings& review, const FilmTools* films, Case& result);

/// Counts, and the exit code of the whole.
void sum_up(Comparison& comparison);

} // namespace diff
