#pragma once
/// Scenes by name.
#include <filesystem>
#include <string>

namespace cmd {

/// scenes/ in the present folder, otherwise the scenes that were installed with the program.
std::filesystem::path scene_folder();

/// "funnel" -> "scenes/funnel.toml", if there is no file of the first name and one of the second.
std::string scene_path(const std::string& input);

/// "; did you mean 'scenes/funnel.toml'?" if the file is not there, and one with nearly its name is; for the name of a scene
/// "; did you mean 'funnel'?".
std::string nearest_scene(const std::string& input);

} // namespace cmd
