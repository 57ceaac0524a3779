#pragma once
/// What a user names as reference or candidate: a picture, a folder of frames, a run's folder, or a film.
#include "render/compare/picture.h"
#include "render/compare/result.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace diff {

/// The frames of a film, one after the other.
class FilmReader {
public:
    virtual ~FilmReader() = default;
    /// The next frame; false at the end. Throws Error (io).
    virtual bool read(Picture& picture) = 0;
    /// [1/s]
    virtual double fps() const = 0;
};

/// Pictures -> film.
class FilmWriter {
public:
    virtual ~FilmWriter() = default;
    /// Throws Error (io).
    virtual void add(const Picture& picture) = 0;
    /// Without it nothing is left behind. Throws Error (io).
    virtual void finish() = 0;
};

/// Films are read and written by a codec that this library does not know.
struct FilmTools {
    std::function<std::unique_ptr<FilmReader>(const std::filesystem::path&)> open;
    /// width, height [px] of all pictures.
    std::function<std::unique_ptr<FilmWriter>(const std::filesystem::path&, int width, int height, double fps)> create;
};

enum class SourceKind { missing, picture, frames, film };

struct Source {
    SourceKind kind = SourceKind::missing;
    std::filesystem::path path;                ///< the picture, the film, or the folder that holds the frames
    std::vector<std::string> names;            ///< of frames: files in path, sorted
    Origin origin;                             ///< of a run's folder
    std::string scene_text;                    ///< of a run's folder
    std::vector<std::string> overrides;        ///< of a run's folder: changes to the scene, "dotted.key=value"
};

/// True for a film by its first bytes: MP4, Matroska, AVI. False if the file cannot be read.
bool is_film(const std::filesystem::path& path);

/// The pictures in a folder, but not those that tell which body a pixel shows; sorted. Throws Error (io).
std::vector<std::string> picture_names(const std::filesystem::path& folder);

/// The only film in a folder.
std::optional<std::filesystem::path> film_in(const std::filesystem::path& folder);

/// A folder with frames/ is a run: its frames are taken, or its film if it has none. Throws Error (io) if a folder
/// holds neither pictures nor a film.
Source find_source(const std::filesystem::path& path);

/// Why runs differ; sets cause and cause_text of `result` if the files beside them tell. Of equal pictures only what
/// should not be so: other scenes or states.
void find_cause(const Source& reference, const Source& candidate, Case& result);

} // namespace diff
