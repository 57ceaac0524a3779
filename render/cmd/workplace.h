#pragma once
/// The folder of one scene's results.
#include <filesystem>
#include <string>

namespace cmd {

/// Locked against a second run into the same folder for as long as it lives.
class Workplace {
public:
    /// Creates the folder, and removes part files that a killed run has left.
    /// Throws Error (io) if that fails or another run uses it.
    explicit Workplace(const std::filesystem::path& folder);
    Workplace(const Workplace&) = delete;
    Workplace& operator=(const Workplace&) = delete;
    ~Workplace();

    const std::filesystem::path& folder() const { return folder_; }

    /// Creates frames/ in it. Throws Error (io).
    void make_frames_folder() const;
    /// Removes frames/frame_NNNNNN.png of an earlier run, and frames/ if nothing else is in it. Throws Error
    /// (io).
    void remove_frames() const;
    /// Removes a file of an earlier run, if there is one. Throws Error (io).
    void remove_file(const std::string& name) const;
    /// Removes files that are not whole.
    void remove_parts() const noexcept;

private:
    std::filesystem::path folder_;
    int lock_ = -1; ///< descriptor of the folder
};

} // namespace cmd
