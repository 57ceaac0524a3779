#pragma once
/// The folder of one scene's results.
#include <filesystem>
#include <optional>
#include <string>

namespace cmd {

/// A lock on a folder, against other processes that lock it too, for as long as it lives.
class FolderLock {
public:
    enum class Kind { alone, shared };

    /// Waits for the others if `waits`. Throws Error (io) if the folder cannot be locked, or is by others.
    FolderLock(const std::filesystem::path& folder, Kind kind, bool waits);
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;
    ~FolderLock();

private:
    int descriptor_ = -1;
};

enum class Sharing {
    alone,       ///< no other run may use the folder
    with_slices, ///< runs that draw other frames of the same film may
};

/// Locked against a second run into the same folder for as long as it lives.
class Workplace {
public:
    /// Creates the folder, and removes part files that a killed run has left (alone).
    /// Throws Error (io) if that fails or another run uses it.
    explicit Workplace(const std::filesystem::path& folder, Sharing sharing = Sharing::alone);
    Workplace(const Workplace&) = delete;
    Workplace& operator=(const Workplace&) = delete;

    const std::filesystem::path& folder() const { return folder_; }

    /// Creates frames/ in it. Throws Error (io).
    void make_frames_folder() const;
    /// Removes frames/frame_NNNNNN.png of an earlier run, and frames/ if nothing else is in it. Throws Error
    /// (io).
    void remove_frames() const;
    /// Removes a file of an earlier run, if there is one. Throws Error (io).
    void remove_file(const std::string& name) const;
    /// True if frames/ has one.
    bool has_frames() const;
    /// Removes files that are not whole, unless others may be writing them.
    void remove_parts() const noexcept;

private:
    std::filesystem::path folder_;
    Sharing sharing_;
    std::optional<FolderLock> lock_;
};

} // namespace cmd
