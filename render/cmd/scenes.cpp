/// tumble scenes, tumble new: which scenes there are, and a first one of one's own.
#include "render/cmd/options.h"
#include "render/cmd/scene_path.h"
#include "render/cmd/scene_texts.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

void list_scenes(const Options& options) {
    const fs::path folder = options.inputs.empty() ? scene_folder() : fs::path(options.inputs.front());
    std::error_code error;
    std::vector<fs::path> paths;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".toml") {
            paths.push_back(entry.path());
        }
    }
    if (error) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: {}", folder.string(), error.message()));
    }
    if (paths.empty()) {
        throw Error(ExitCode::io,
                    fmt::format("{} has no scene, no file that ends in .toml", folder.string()));
    }
    std::sort(paths.begin(), paths.end());
    std::size_t width = 0;
    for (const fs::path& path : paths) {
        width = std::max(width, path.string().size());
    }
    for (const fs::path& path : paths) {
        fmt::print("{:<{}}  {}\n", path.string(), width, sim::load_scene(path, {}).title);
    }
}

void new_scene(const Options& options) {
    const fs::path path = options.inputs.front();
    if (path.extension() != ".toml") {
        throw Error(ExitCode::usage, fmt::format("'{}': expected a name that ends in .toml", path.string()));
    }
    std::error_code error;
    if (fs::exists(path, error)) {
        throw Error(ExitCode::usage, fmt::format("{} is there already; choose another name", path.string()));
    }
    sim::write_file(path, std::string(scene_texts[0].text));
    if (!options.is_quiet) {
        fmt::print("{0} written; tumble run {0} makes its film\n", path.string());
    }
}

} // namespace cmd
