#pragma once
/// The folder of one scene's results.
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace cmd {

/// Files of a run beside its frames: trajectory, summary, film and stills. Relative to its folder.
inline constexpr const char* trajectory_name = "trajectory.h5";
inline constexpr const char* summary_name = "summary.json";
/// Beside them until the run is whole; see checkpoint.h.
inline constexpr const char* checkpoint_name = "checkpoint.bin";
inline constexpr const char* states_name = "checkpoint.states";
/// Films of all encoders, and stills.
std::vector<std::string> product_names(const std::string& scene);
/// All of them.
std::vector<std::string> run_names(const std::string& scene);

/// Creates a folder and those above it. Throws Error (io).
void make_folder(const std::filesystem::path& folder);
/// "frame_000000.png", and what lies beside it: "frame_000000.bodies.png", "frame_000000.bodies.json", "frame_000000.exr", ...
bool is_frame_name(std::string_view name);
/// Removes frame_NNNNNN.png and what lies beside them from a folder, but those of these names. Throws Error (io).
void remove_frame_files(const std::filesystem::path& folder, const std::set<std::string>& kept = {});
/// Removes a folder if nothing is in it.
void remove_if_empty(const std::filesystem::path& folder) noexcept;

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

/// Locked against a second run into the same folder for as long as it lives. Removes nothing but files of the names it
/// was given, and frames.
class Workplace {
public:
    /// Creates the folder, and removes what a killed run has left of files of these names (alone).
    /// Throws Error (io) if that fails or another run uses it.
    Workplace(const std::filesystem::path& folder, std::vector<std::string> names, Sharing sharing = Sharing::alone);
    Workplace(const Workplace&) = delete;
    Workplace& operator=(const Workplace&) = delete;
    ~Workplace() { remove_parts(); }

    const std::filesystem::path& folder() const { return folder_; }

    /// Creates frames/ in it. Throws Error (io).
    void make_frames_folder() const;
    /// Removes frames/frame_NNNNNN.png of an earlier run, and frames/ if nothing else is in it. Throws Error
    /// (io).
    void remove_frames() const;
    /// Removes a file of an earlier run, if there is one. Throws Error (io).
    void remove_file(const std::string& name) const;
    /// True if an interrupted simulation can go on.
    bool has_checkpoint() const;
    /// True if frames/ has one.
    bool has_frames() const;
    /// Removes files that are not whole, and states that no checkpoint tells of, unless others may be writing them.
    void remove_parts() const noexcept;

private:
    std::filesystem::path folder_;
    std::vector<std::string> names_;
    Sharing sharing_;
    std::optional<FolderLock> lock_;
};

} // namespace cmd
