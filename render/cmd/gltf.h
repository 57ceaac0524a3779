#pragma once
/// A run as glTF 2.0: what is seen of its bodies, and how they move.
#include "sim/model/scene_def.h"
#include "sim/record/trajectory.h"

#include <cstddef>
#include <filesystem>

namespace cmd {

/// What a file holds.
struct GltfSummary {
    std::size_t nodes = 0;
    std::size_t records = 0; ///< poses of moving bodies in the trajectory
    std::size_t keys = 0;    ///< poses that are kept of them
};

/// Writes the bodies, their materials without patterns, the scene's camera and sun, and one animation of all recorded
/// poses as a binary glTF file. A pose is left out where a straight interpolation between its neighbours stays within a
/// tenth of the scene's tolerance [m] everywhere on the body. The camera's opening is that at the start. The root
/// node turns z up to glTF's y up. Throws Error (io).
GltfSummary write_gltf(const std::filesystem::path& path, const sim::SceneDef& scene,
                       const sim::TrajectoryReader& trajectory);

} // namespace cmd
