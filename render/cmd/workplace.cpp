#include "render/cmd/workplace.h"

#include "render/film/stills.h"
#include "render/film/video_writer.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>
#include <utility>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// Frames that are not whole.
void remove_frame_parts(const fs::path& folder) {
    if (!fs::is_directory(folder)) {
        return;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        const fs::path name = entry.path().filename();
        if (name.extension() == ".part" && is_frame_name(name.stem().string())) {
            fs::remove(entry.path());
        }
    }
}

} // namespace

bool is_frame_name(std::string_view name) {
    constexpr std::string_view prefix = "frame_";
    for (const std::string_view suffix : {".bodies.json", ".bodies.png", ".rgba.png", ".depth.png", ".rgb16.png", ".exr", ".png"}) {
        if (name.size() > prefix.size() + suffix.size() && name.starts_with(prefix) && name.ends_with(suffix)) {
            const std::string_view digits =
                name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
            return std::all_of(digits.begin(), digits.end(),
                               [](unsigned char c) { return std::isdigit(c) != 0; });
        }
    }
    return false;
}

FolderLock::FolderLock(const fs::path& folder, Kind kind, bool waits) {
    descriptor_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor_ < 0) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: {}", folder.string(), std::strerror(errno)));
    }
    const int operation = (kind == Kind::alone ? LOCK_EX : LOCK_SH) | (waits ? 0 : LOCK_NB);
    while (::flock(descriptor_, operation) != 0) {
        const int reason = errno;
        if (reason == EINTR) {
            continue;
        }
        ::close(descriptor_);
        throw Error(ExitCode::io,
                    reason == EWOULDBLOCK
                        ? fmt::format("another run is writing into {}", folder.string())
                        : fmt::format("cannot lock {}: {}", folder.string(), std::strerror(reason)));
    }
}

FolderLock::~FolderLock() {
    ::close(descriptor_); // which unlocks it
}

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
    }
}

std::vector<std::string> product_names(const std::string& scene) {
    std::vector<std::string> names;
    for (const char* extension : render::film_extensions) {
        names.push_back(scene + extension);
    }
    for (const std::string& name : render::stills_names(scene)) {
        names.push_back(name);
    }
    return names;
}

std::vector<std::string> run_names(const std::string& scene) {
    std::vector<std::string> names = product_names(scene);
    names.insert(names.end(), {trajectory_name, summary_name, checkpoint_name, states_name});
    return names;
}

void remove_frame_files(const fs::path& folder, const std::set<std::string>& kept) {
    try {
        if (!fs::is_directory(folder)) {
            return;
        }
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            const std::string name = entry.path().filename().string();
            if (is_frame_name(name) && !kept.contains(name)) {
                fs::remove(entry.path());
            }
        }
    } catch (const fs::filesystem_error& error) {
        throw Error(ExitCode::io, fmt::format("cannot remove old frames in {}: {}", folder.string(),
                                              error.code().message()));
    }
}

void remove_if_empty(const fs::path& folder) noexcept {
    std::error_code kept; // with other files in it, or where a disk is mounted
    if (fs::is_directory(folder, kept)) {
        fs::remove(folder, kept);
    }
}

Workplace::Workplace(const fs::path& folder, std::vector<std::string> names, Sharing sharing)
    : folder_(folder), names_(std::move(names)), sharing_(sharing) {
    make_folder(folder);
    lock_.emplace(folder, sharing == Sharing::alone ? FolderLock::Kind::alone : FolderLock::Kind::shared,
                  false);
    remove_parts();
}

void Workplace::make_frames_folder() const {
    make_folder(folder_ / "frames");
}

void Workplace::remove_frames() const {
    remove_frame_files(folder_ / "frames");
    remove_if_empty(folder_ / "frames");
}

void Workplace::remove_file(const std::string& name) const {
    std::error_code error;
    fs::remove(folder_ / name, error);
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot remove the old {}: {}", (folder_ / name).string(), error.message()));
    }
}

bool Workplace::has_checkpoint() const {
    std::error_code error;
    return fs::exists(folder_ / checkpoint_name, error);
}

bool Workplace::has_frames() const {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_ / "frames", error)) {
        if (is_frame_name(entry.path().filename().string())) {
            return true;
        }
    }
    return false;
}

void Workplace::remove_parts() const noexcept {
    if (sharing_ == Sharing::with_slices) {
        return;
    }
    try {
        for (const std::string& name : names_) {
            fs::remove(sim::part_path(folder_ / name));
        }
        fs::remove(sim::part_path(folder_ / "frames" / "run.json"));
        remove_frame_parts(folder_ / "frames");
        remove_frame_parts(folder_);
        if (std::ranges::find(names_, states_name) != names_.end() && !has_checkpoint()) {
            fs::remove(folder_ / states_name);
        }
    } catch (const std::exception&) {
        // A part file that will not go harms nobody: it is written over, or seen as what it is.
    }
}

} // namespace cmd
