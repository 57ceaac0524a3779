#pragma once
/// A film of two sequences: reference | candidate | difference, frame by frame.
#include "render/compare/sequence.h"

#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace diff {

/// Made while the pairs are compared, of cases that turn out not to be identical. Frames of folders are shown at 30 a
/// second, films at the reference's rate. Panels are made smaller by whole factors so that the film is at most 1920 pixels
/// wide, and have the size of the first pair. Where a side has no such frame its panel is black.
class SideBySide {
public:
    /// All must outlive it. name: of the case.
    SideBySide(const Sides& sides, const FilmTools& films, const std::filesystem::path& folder, const std::string& name);

    /// As SeePair. Throws Error (io).
    void add(std::size_t i, const PairMemory& memory, const Frame& frame);

    /// The film folder / CASE.mp4, if there is one, and enters it. Throws Error (io).
    void finish(Case& result);

private:
    /// A frame of the film that is not written yet.
    struct Part {
        bool is_same = false;          ///< of both sides: read again when it is wanted
        std::optional<Picture> panels; ///< none: the same, or black
    };
    void set_size(const Frame& frame);
    Picture same_panels(std::size_t i) const;
    void write_ready();

    const Sides& sides_;
    const FilmTools& films_;
    std::filesystem::path path_;
    double fps_;
    std::vector<std::string> names_; ///< of files; empty of films, whose frames cannot be read again
    std::atomic<bool> is_wanted_;    ///< something differs
    std::mutex mutex_;               ///< of what follows
    int width_ = 0;                  ///< [px] of a picture; 0 until one is known
    int height_ = 0;                 ///< [px]
    std::map<std::size_t, Part> waiting_; ///< by frame
    std::size_t next_ = 0;
    std::unique_ptr<FilmWriter> film_;
};

} // namespace diff
