#pragma once
/// What lies together in the folder of a run belongs together: simulation, frames, film, stills, and the summary that
/// lists them.
#include "render/cmd/workplace.h"
#include "sim/base/file_io.h"

#include <filesystem>
#include <string>
#include <vector>

namespace cmd {

/// Throws Error: usage if the folder holds another simulation than this trajectory, io if its summary is damaged.
void require_same_simulation(const std::filesystem::path& folder, const std::filesystem::path& trajectory);

/// Throws Error (usage) if the file is one of a run that has been made there: its summary would no longer be true.
void require_no_file_of_run(const std::filesystem::path& file);

/// Before a run: removes all that an earlier one has left but its frames, and its checkpoint if that is gone on from.
/// Throws Error (io).
void forget_run(const Workplace& workplace, const std::string& scene, bool keeps_checkpoint = false);

/// Before pictures change: film and stills are removed, and the summary lists the trajectory only, and frames if they
/// stay. Throws Error (io).
void forget_products(const Workplace& workplace, const std::string& scene, bool keeps_frames);

/// The summary's text; empty if there is none. Throws Error (io) if it is damaged.
std::string read_summary(const std::filesystem::path& folder);

} // namespace cmd
