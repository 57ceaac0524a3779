#pragma once
/// Films whose work is done on a cluster.
#include "render/cmd/options.h"

#include <filesystem>
#include <vector>

namespace cmd {

/// tumble run --on slurm: scenes[i] is of options.inputs[i]. Throws Error as run_batches does.
void run_scenes_elsewhere(const std::vector<sim::SceneDef>& scenes, const Options& options);

/// tumble render --on slurm: the scene as the pictures are to show it. Throws Error as run_batches does.
void render_elsewhere(const sim::SceneDef& scene, const std::filesystem::path& folder,
                      const Options& options);

} // namespace cmd
