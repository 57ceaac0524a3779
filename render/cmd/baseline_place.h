#pragma once
/// Where baselines lie: BASELINES/SCENE/NAME/, and BASELINES/SCENE/NAME@RENDERER/ for machines with that OpenGL.
#include "render/cmd/baseline_record.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace cmd {

inline constexpr const char* common_name = "common"; ///< of the baseline that a scene has without --name

struct BaselinePlace {
    std::filesystem::path scene_file; ///< empty if it is not known
    std::string scene;             ///< name
    std::string name;              ///< of the baseline
    std::filesystem::path folder;  ///< of all machines, whether it is there or not

    /// "funnel", or "funnel/top"
    std::string case_name() const { return name == common_name ? scene : scene + "/" + name; }
};

/// The baselines of a scene's file: that of the name, or all; at least one, which may not be there. Throws Error (usage)
/// for names that no folder can have.
std::vector<BaselinePlace> places_of(const std::filesystem::path& baselines, const std::string& scene_file,
                                     const std::string& name);

/// All baselines in a folder. Throws Error: missing_or_size if there are none, io.
std::vector<BaselinePlace> all_places(const std::filesystem::path& baselines, const std::string& name);

/// The folder for machines with this renderer only. gl: what draws. Throws Error as GlContext does.
std::filesystem::path renderer_folder(const std::filesystem::path& baselines, const BaselinePlace& place,
                                      const std::string& gl);

/// That folder if it is there, else the place's own.
std::filesystem::path machine_folder(const std::filesystem::path& baselines, const BaselinePlace& place,
                                     const std::string& gl);

/// Files of a folder that a baseline consists of: record, pictures, what lies beside them, and masks. Relative to it.
std::vector<std::filesystem::path> baseline_files(const std::filesystem::path& folder);

/// Removes these, and the folder if nothing else is in it.
void remove_baseline(const std::filesystem::path& folder) noexcept;

/// Puts `fresh` in the place of `folder`; what was there goes only once the other is in its place, and what is not of
/// a baseline stays. Throws Error (io).
void replace_folder(const std::filesystem::path& fresh, const std::filesystem::path& folder);

/// What an update was about to put in a baseline's place; accept has no frames/ in it.
void remove_fresh(const std::filesystem::path& fresh) noexcept;

} // namespace cmd
