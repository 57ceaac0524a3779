#pragma once
/// Beside a frame, on request: which body each of its pixels shows, so that a comparison can name bodies.
///
/// frame_000000.bodies.png: a pixel's number is R + 256 G + 65536 B, the index of the body plus 1; 0: none.
/// frame_000000.bodies.json: {"names": [...], "positions": [[x, y, z], ...], "orientations": [[w, x, y, z], ...]} of all
/// bodies: centres of mass [m], and world_from_body; and what they are seen by: "view": {"eye", "target", "fov_degrees"},
/// "light": {"to_sun", "sun", "zenith", "horizon"}, linear RGB.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace render {

/// A file's name and bytes.
using NamedBytes = std::pair<std::string, std::vector<std::uint8_t>>;

/// frame: the picture's file name, relative to the folder. ids: of the picture, see Renderer::body_ids().
/// The two files.
std::vector<NamedBytes> encode_body_image(const std::string& frame, const sim::SceneDef& scene,
                                          const sim::Snapshot& snapshot, const std::vector<std::uint32_t>& ids);

/// Writes them. Returns their names. Throws Error (io).
std::vector<std::string> write_body_image(const std::filesystem::path& folder, const std::string& frame,
                                          const sim::SceneDef& scene, const sim::Snapshot& snapshot,
                                          const std::vector<std::uint32_t>& ids);

} // namespace render
