#include "render/cmd/scene_path.h"

#include "sim/scene/tree.h"

#include <algorithm>
#include <vector>

namespace cmd {

namespace fs = std::filesystem;

namespace {

// True for what may be the name of a scene of scene_folder(), such as "funnel".
bool is_scene_name(const std::string& input) {
    return input.find_first_of("/.") == std::string::npos;
}

} // namespace

fs::path scene_folder() {
    std::error_code error;
    if (fs::is_directory("scenes", error)) {
        return "scenes";
    }
    // This program is in PREFIX/libexec/tumble.
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    return program.parent_path().parent_path().parent_path() / "share" / "tumble" / "scenes";
}

std::string scene_path(const std::string& input) {
    std::error_code error;
    const fs::path path = scene_folder() / (input + ".toml");
    const bool is_name = is_scene_name(input) && !fs::exists(input, error);
    return is_name && fs::is_regular_file(path, error) ? path.string() : input;
}

std::string nearest_scene(const std::string& input) {
    std::error_code error;
    if (fs::exists(scene_path(input), error)) {
        return "";
    }
    const bool is_name = is_scene_name(input);
    const fs::path path = input;
    const fs::path folder = is_name ? scene_folder() : path.parent_path();
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.empty() ? "." : folder, error)) {
        const fs::path name = entry.path().filename();
        if (name.extension() == (is_name ? ".toml" : path.extension())) {
            names.push_back(is_name ? name.stem().string() : (path.parent_path() / name).string());
        }
    }
    std::sort(names.begin(), names.end());
    return sim::near_miss(input, names);
}

} // namespace cmd
