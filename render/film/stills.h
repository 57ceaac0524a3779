#pragma once
/// What shows a film on a page, made from its frames: a poster, a sheet of frames side by side, an animation
/// (WebP or GIF, played for ever; sole user of libwebp).
#include "sim/base/file_io.h"
#include "sim/model/scene_def.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace render {

struct StillsSettings {
    std::optional<double> poster_time; ///< [s] >= 0; SCENE_poster.png is the frame nearest to it
    int sheet_count = 0;               ///< frames in SCENE_sheet.png, from the first to the last; 0: no sheet
    bool has_webp = false;             ///< SCENE.webp
    bool has_gif = false;              ///< SCENE.gif
    int animation_width = 480;         ///< [px] of both; of the frames, if they are no wider
    double animation_rate = 15.0;      ///< [1/s] pictures in both; all frames, if there are no more

    bool is_needed() const { return poster_time || sheet_count > 0 || has_webp || has_gif; }
};

/// The files' names for a scene of this name, whether they are made or not.
std::array<std::string, 4> stills_names(const std::string& scene);

/// Makes them in a folder from the PNG files of the whole film; same frames, same bytes. Throws Error (io).
std::vector<sim::WrittenFile>
make_stills(const sim::SceneDef& scene, const StillsSettings& settings,
            const std::function<std::filesystem::path(std::int64_t)>& frame_path,
            const std::filesystem::path& folder);

} // namespace render
