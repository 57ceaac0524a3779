#pragma once
/// Pictures of a check that a cluster draws.
#include "render/cmd/baseline.h"
#include "render/cmd/baseline_place.h"
#include "sim/base/error.h"

#include <filesystem>
#include <vector>

namespace cmd {

/// Where a check draws what is compared with the baseline.
std::filesystem::path drawn_folder(const std::filesystem::path& report, const BaselinePlace& place);

/// Draws what is missing: pictures are there that no report has shown yet, and that are newer than their
/// scene, their baseline and the program. False if the jobs are left to themselves. Throws Error as
/// run_batches does.
bool draw_elsewhere(const BaselineOptions& options, const std::filesystem::path& report,
                    const std::vector<BaselinePlace>& places);

/// In a task: nothing is there of an earlier drawing, or why there are no pictures. Throw Error (io).
void begin_drawing(const std::filesystem::path& drawn);
void keep_failure(const std::filesystem::path& drawn, const sim::Error& error);

/// In the caller: throws what was kept, if anything was. Throws Error (io) if it is damaged.
void throw_failure(const std::filesystem::path& drawn);

} // namespace cmd
