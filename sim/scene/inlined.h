#pragma once
/// Files that a scene names, and what stands in its text instead of their names, so that a run says all by itself.
#include "sim/base/error.h"
#include "sim/scene/section.h"

#include <fmt/format.h>

#include <string>

namespace sim {

struct FileBeside {
    std::string path; ///< as messages call it
    std::string bytes;
};
/// A file relative to the scene's. Throws Error (io).
FileBeside file_beside(const TextSource& source, const std::string& name);

/// What read(bytes, path) makes of the file that the section's key names. Throws Error with the key's place.
template <class Read>
auto read_beside(Section& section, const char* key, const Read& read) {
    const std::string name = section.text(key);
    const TextPlace place = section.place_of(key);
    if (place.assignment >= 0) {
        section.fail(key, fmt::format("{} is set here, expected it in the scene file", key));
    }
    try {
        const FileBeside file = file_beside(section.source(), name);
        return read(file.bytes, file.path);
    } catch (const Error& error) {
        throw Error(error.code(), fmt::format("{}: {}: {}", section.source().describe(place), section.title(),
                                              error.what()));
    }
}

/// The bytes of the PNG file that the section's key `logo` names or holds.
std::string read_logo(Section& section);

/// The text of a scene with the points of its OBJ files and the bytes of its logo in place of their names. root: its tree, read
/// without an error. Throws Error (usage) for a name that is not a plain text.
std::string text_with_files(std::string text, const TreeNode& root, const TextSource& source);

} // namespace sim
