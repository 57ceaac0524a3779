#pragma once
/// What earlier runs of a comparison found, in a file of JSON lines that grows by a line a case and run.
#include "render/compare/result.h"

#include <filesystem>
#include <string>

namespace diff {

/// Appends a line for each case; runs at the same time do not mix theirs. time: of the run, "2026-01-31T12:00:00Z".
/// Throws Error (io).
void append_history(const std::filesystem::path& path, const Comparison& comparison, const std::string& time);

/// Enters into each case the last runs of the file that name it, oldest first. Throws Error (io) for a line that is no
/// record.
void read_history(const std::filesystem::path& path, Comparison& comparison);

/// True if the verdict of the last runs has changed more often than breaking and mending something changes it.
bool is_flaky(const Case& result);

} // namespace diff
