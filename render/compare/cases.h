#pragma once
/// What of two folders is compared with what: which pictures are a sequence, and which are a case of their own.
#include "render/compare/source.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace diff {

/// The two sides of a case; one of them may be missing.
struct CasePaths {
    std::string name; ///< of the case, within the folders that were named; empty for these themselves
    std::filesystem::path reference;
    std::filesystem::path candidate;
};

/// One for each run, film or sequence in the two folders and the folders in them, and for each picture that belongs to no
/// sequence; what is no pair of folders is one case. Reports are left out. In order of their names. Throws Error (io).
std::vector<CasePaths> find_cases(const std::filesystem::path& reference, const std::filesystem::path& candidate);

/// The numbers that the files of a sequence end in, "frame_000012.png": 12. Empty if the names differ in more than that.
std::vector<std::int64_t> frame_numbers(const std::vector<std::string>& names);

/// Names of a sequence by their numbers; others as they are sorted.
void sort_frames(std::vector<std::string>& names);

} // namespace diff
