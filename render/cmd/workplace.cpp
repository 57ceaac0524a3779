#include "render/cmd/workplace.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <string_view>
#include <sys/file.h>
#include <system_error>
#include <unistd.h>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// "frame_000000.png", and what lies beside it: "frame_000000.bodies.png", "frame_000000.bodies.json".
bool is_frame_name(std::string_view name) {
    constexpr std::string_view prefix = "frame_";
    for (const std::string_view suffix : {".bodies.json", ".bodies.png", ".png"}) {
        if (name.size() > prefix.size() + suffix.size() && name.starts_with(prefix) && name.ends_with(suffix)) {
            const std::string_view digits =
                name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
            return std::all_of(digits.begin(), digits.end(),
                               [](unsigned char c) { return std::isdigit(c) != 0; });
        }
    }
    return false;
}

void remove_parts_in(const fs::path& folder) {
    if (!fs::is_directory(folder)) {
        return;
    }
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        if (entry.path().extension() == ".part") {
            fs::remove(entry.path());
        }
    }
}

void make_folder(const fs::path& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
    }
}

} // namespace

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

Workplace::Workplace(const fs::path& folder, Sharing sharing) : folder_(folder), sharing_(sharing) {
    make_folder(folder);
    lock_.emplace(folder, sharing == Sharing::alone ? FolderLock::Kind::alone : FolderLock::Kind::shared,
                  false);
    remove_parts();
}

void Workplace::make_frames_folder() const {
    make_folder(folder_ / "frames");
}

void Workplace::remove_frames() const {
    const fs::path frames = folder_ / "frames";
    try {
        if (!fs::is_directory(frames)) {
            return;
        }
        for (const fs::directory_entry& entry : fs::directory_iterator(frames)) {
            if (is_frame_name(entry.path().filename().string())) {
                fs::remove(entry.path());
            }
        }
        std::error_code kept; // with other files in it, or where a disk is mounted
        fs::remove(frames, kept);
    } catch (const fs::filesystem_error& error) {
        throw Error(ExitCode::io, fmt::format("cannot remove old frames in {}: {}", frames.string(),
                                              error.code().message()));
    }
}

void Workplace::remove_file(const std::string& name) const {
    std::error_code error;
    fs::remove(folder_ / name, error);
    if (error) {
        throw Error(ExitCode::io,
                    fmt::format("cannot remove the old {}: {}", (folder_ / name).string(), error.message()));
    }
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
        remove_parts_in(folder_);
        remove_parts_in(folder_ / "frames");
    } catch (const std::exception&) {
        // A part file that will not go harms nobody: it is written over, or seen as what it is.
    }
}

} // namespace cmd
