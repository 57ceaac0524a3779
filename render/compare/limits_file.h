#pragma once
/// Limits of the gates as a JSON file: what `tumble compare --calibrate` prints and --limits reads.
#include "render/compare/judge.h"
#include "render/compare/result.h"

#include <filesystem>
#include <string>

namespace diff {

/// {"edge shift": 0.9, ...}: for each gate 1.25 times the largest value found in the comparison, but no less than
/// `least` says.
std::string proposed_limits(const Comparison& comparison, const Limits& least);

/// The file's limits; gates that it does not name keep their defaults. Throws Error: io if it cannot be read, usage
/// if it has another form.
Limits read_limits(const std::filesystem::path& path);

} // namespace diff
