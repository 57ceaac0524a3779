#pragma once
/// Two picture files -> Frame, whatever is wrong with them.
#include "render/compare/judge.h"
#include "render/compare/mask.h"
#include "render/compare/picture.h"
#include "render/compare/result.h"
#include "render/compare/thumbnail.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace diff {

/// How pairs are compared.
struct PairSettings {
    Limits limits;
    PictureLimits accepted;
    Mask mask;
    std::vector<std::string> ignored_bodies; ///< names
    bool is_lossy = false; ///< films and JPEG, whose encoders blur and ring
    bool is_jpeg = false;  ///< one of them is a JPEG file, which has plain colours a little off; lossy
    bool takes_thumbnails = false; ///< of what is decoded
    bool judges = true; ///< false: only measured, for difference_picture(); the tier is then identical or changed
};

/// Memory of one thread, used again from pair to pair: about 60 bytes a pixel.
struct PairMemory {
    Bytes file_a;
    Bytes file_b;
    Picture a;
    Picture b;
    ReaderMemory reader;
    DifferenceMap map;
    std::optional<Thumbnail> thumbnail_a; ///< without masks
    std::optional<Thumbnail> thumbnail_b;
    Picture unmasked; ///< b without masks; of no size if there are none
};

/// The two files of a frame; none where a side has no such frame.
struct PairPaths {
    std::optional<std::filesystem::path> reference;
    std::optional<std::filesystem::path> candidate;
};

/// Fills all of `frame` but name, index and pictures. Equal files are not decoded. What is wrong with a file is a
/// status. Throws Error: usage if bodies are to be ignored and the images beside the pictures do not tell them,
/// missing_or_size if a mask has another size.
void compare_files(const PairPaths& paths, const PairSettings& settings, PairMemory& memory, Frame& frame);

/// The same for memory.a and memory.b, of any size.
void compare_pictures(const PairSettings& settings, PairMemory& memory, Frame& frame);

/// What differs, for the eye: the candidate in pale grey, noise in blue, what the gates count in orange to red.
/// Of pictures of two sizes: the area that only one of them has in violet. After compare_pictures().
IndexedPicture difference_picture(const PairMemory& memory);

} // namespace diff
