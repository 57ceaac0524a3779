#include "render/cmd/workplace.h"

#include "sim/error.h"

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

bool is_frame_name(std::string_view name) {
    constexpr std::string_view prefix = "frame_";
    constexpr std::string_view suffix = ".png";
    if (name.size() <= prefix.size() + suffix.size() || !name.starts_with(prefix) ||
        !name.ends_with(suffix)) {
        return false;
    }
    const std::string_view digits = name.substr(prefix.size(), name.size() - prefix.size() - suffix.size());
    return std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
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

Workplace::Workplace(const fs::path& folder) : folder_(folder) {
    make_folder(folder);
    lock_ = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (lock_ < 0) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: {}", folder.string(), std::strerror(errno)));
    }
    if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
        const int reason = errno;
        ::close(lock_);
        throw Error(ExitCode::io,
                    reason == EWOULDBLOCK
                        ? fmt::format("another run is writing into {}", folder.string())
                        : fmt::format("cannot lock {}: {}", folder.string(), std::strerror(reason)));
    }
    remove_parts();
}

Workplace::~Workplace() {
    ::close(lock_); // which unlocks it
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
        if (fs::is_empty(frames)) {
            fs::remove(frames);
        }
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

void Workplace::remove_parts() const noexcept {
    try {
        remove_parts_in(folder_);
        remove_parts_in(folder_ / "frames");
    } catch (const std::exception&) {
        // A part file that will not go harms nobody: it is written over, or seen as what it is.
    }
}

} // namespace cmd
