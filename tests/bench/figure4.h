#pragma once
/// Figure 4 of Bender & Schmitt 2006, remade: time of each phase against what it solves, every step a point.
#include "tests/bench/engine.h"

#include <filesystem>
#include <span>

namespace bench {

/// Writes figure4.svg, figure4.png and figure4.txt into a folder and prints the last.
void write_figure4(std::span<const StepCounts> steps, const std::filesystem::path& folder);

} // namespace bench
