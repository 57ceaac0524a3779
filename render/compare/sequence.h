#pragma once
/// Reference and candidate, whatever they are -> Case; pairs in parallel, in memory that does not depend on their
/// number.
#include "render/compare/pair.h"
#include "render/compare/result.h"
#include "render/compare/source.h"

#include <filesystem>
#include <functional>
#include <string>

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

/// Compares. films: null if none of the two is a film: CHECK. Throws Error: missing_or_size or usage if the two are
/// of different kinds, io if a folder cannot be read, interrupted.
Case compare_sources(const std::string& name, const Source& reference, const Source& candidate,
                     const Settings& settings, const FilmTools* films);

/// Writes pictures for review of what is not identical, and enters their paths. Throws Error (io).
void write_review(const Sides& sides, const Settings& settings,
                  const ReviewSettings& review, const FilmTools* films, Case& result);

/// Calls use(memory, has_a, has_b, frame) for all pairs in order, with their pictures in memory.a and memory.b and
/// what differs in memory.map, unless frame.tier is identical. Throws Error (io).
using UsePair = std::function<void(const PairMemory&, bool has_a, bool has_b, const Frame& frame)>;
void visit_pairs(const Source& reference, const Source& candidate, const Settings& settings, const FilmTools* films,
                 const UsePair& use);

/// Counts, and the exit code of the whole.
void sum_up(Comparison& comparison);

} // namespace diff
