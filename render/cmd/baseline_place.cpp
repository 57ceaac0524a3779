#include "render/cmd/baseline_place.h"

#include "render/cmd/workplace.h"
#include "render/gl/context.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

bool has_record(const fs::path& folder) {
    std::error_code error;
    return fs::exists(folder / "baseline.json", error);
}

/// Names of a scene's baselines, without renderers, and a folder of each; those under way end in .part.
std::map<std::string, fs::path> names_in(const fs::path& folder) {
    std::map<std::string, fs::path> names;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (!name.ends_with(".part") && has_record(entry.path())) {
            names.emplace(name.substr(0, name.find('@')), entry.path());
        }
    }
    return names;
}

/// The file that the baseline's record names; empty if it does not.
fs::path scene_file_of(const fs::path& baselines, const fs::path& folder) {
    try {
        const std::optional<BaselineRecord> record = read_baseline_record(folder);
        return record && !record->scene_file.empty() ? (baselines / record->scene_file).lexically_normal() : fs::path();
    } catch (const Error&) {
        return {}; // told where it is compared
    }
}

/// Of what was a baseline's folder: its own files go, others move to where they lay.
void keep_others(const fs::path& old, const fs::path& folder) {
    remove_baseline(old);
    std::error_code error;
    std::vector<fs::path> paths;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(old, error)) {
        paths.push_back(entry.path());
    }
    for (const fs::path& path : paths) {
        const fs::path target = folder / path.lexically_relative(old);
        if (!fs::is_directory(path, error) && !fs::exists(target, error)) {
            fs::create_directories(target.parent_path(), error);
            fs::rename(path, target, error);
        }
    }
    for (auto path = paths.rbegin(); path != paths.rend(); ++path) { // a folder's entries come after it
        remove_if_empty(*path);
    }
    remove_if_empty(old);
}

} // namespace

fs::path renderer_folder(const fs::path& baselines, const BaselinePlace& place, const std::string& gl) {
    std::string suffix = render::renderer_string(gl);
    for (char& c : suffix) {
        const bool is_kept = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.';
        c = is_kept ? c : '_';
    }
    return baselines / place.scene / (place.name + "@" + suffix);
}

fs::path machine_folder(const fs::path& baselines, const BaselinePlace& place, const std::string& gl) {
    const fs::path own = renderer_folder(baselines, place, gl);
    return has_record(own) ? own : place.folder;
}

std::vector<BaselinePlace> places_of(const fs::path& baselines, const std::string& scene_file,
                                     const std::string& name) {
    if (!name.empty() && !sim::is_file_name(name)) {
        throw Error(ExitCode::usage, fmt::format("--name '{}': expected a name that a folder can have", name));
    }
    const std::string scene = sim::scene_name_of(scene_file);
    std::map<std::string, fs::path> names = names_in(baselines / scene);
    if (!name.empty() || names.empty()) {
        names = {{name.empty() ? common_name : name, ""}};
    }
    std::vector<BaselinePlace> places;
    for (const auto& [each, folder] : names) {
        places.push_back({scene_file, scene, each, baselines / scene / each});
    }
    return places;
}

std::vector<BaselinePlace> all_places(const fs::path& baselines, const std::string& name) {
    std::set<std::string> scenes;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(baselines, error)) {
        scenes.insert(entry.path().filename().string());
    }
    std::vector<BaselinePlace> places;
    for (const std::string& scene : scenes) {
        for (const auto& [each, folder] : names_in(baselines / scene)) {
            if (name.empty() || name == each) {
                places.push_back({scene_file_of(baselines, folder), scene, each, baselines / scene / each});
            }
        }
    }
    if (places.empty()) {
        throw Error(ExitCode::missing_or_size,
                    fmt::format("there are no baselines{} in {}: tumble baseline update SCENE.toml makes them",
                                name.empty() ? "" : " of the name " + name, baselines.string()));
    }
    return places;
}

std::vector<fs::path> baseline_files(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const fs::path name = entry.path().filename();
        if (name == "baseline.json" || is_frame_name(name.string())) {
            files.push_back(name);
        }
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(folder / "masks", error)) {
        const std::string stem = entry.path().stem().string();
        if (!stem.empty() && stem.find_first_not_of("0123456789") == std::string::npos) {
            files.push_back(fs::path("masks") / entry.path().filename());
        }
    }
    return files;
}

void remove_baseline(const fs::path& folder) noexcept {
    std::error_code kept; // what will not go
    for (const fs::path& file : baseline_files(folder)) {
        fs::remove(folder / file, kept);
    }
    remove_if_empty(folder / "masks");
    remove_if_empty(folder);
}

void replace_folder(const fs::path& fresh, const fs::path& folder) {
    const fs::path old = folder.string() + ".old.part";
    std::error_code error;
    keep_others(old, folder); // of an update that was killed
    fs::rename(folder, old, error);
    if (error && error != std::errc::no_such_file_or_directory) {
        throw Error(ExitCode::io, fmt::format("cannot replace {}: {}", folder.string(), error.message()));
    }
    fs::rename(fresh, folder, error);
    if (error) {
        const std::string reason = error.message();
        fs::rename(old, folder, error);
        throw Error(ExitCode::io, fmt::format("cannot replace {}: {}", folder.string(), reason));
    }
    keep_others(old, folder);
}

void remove_fresh(const fs::path& fresh) noexcept {
    remove_baseline(fresh / "frames");
    remove_baseline(fresh);
}

} // namespace cmd
