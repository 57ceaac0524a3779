#include "sim/scene/inlined.h"

#include "sim/base/base64.h"
#include "sim/base/file_io.h"
#include "sim/model/obj_file.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <string_view>
#include <utility>
#include <vector>

namespace sim {

namespace {

constexpr std::string_view png_text = "data:image/png;base64,";
constexpr std::string_view png_signature = "\x89PNG\r\n\x1a\n";

/// Index of a place's first byte: lines and columns count from 1, a column is one character of UTF-8.
std::size_t offset_of(const std::string& text, const TextPlace& place) {
    std::size_t at = 0;
    for (int line = 1; line < place.line; ++line) {
        at = text.find('\n', at) + 1;
    }
    const auto continues = [&](std::size_t i) { return (static_cast<unsigned char>(text[i]) & 0xC0u) == 0x80u; };
    for (int column = 1; column < place.column; ++column) {
        for (++at; at < text.size() && continues(at);) {
            ++at;
        }
    }
    return at;
}

/// A value that names a file.
struct NamedFile {
    enum class Kind { points, groups, logo } kind;
    const TreeNode* name;
};

/// All values of the key "file" in shapes of kind "hull" and "compound" below a node.
void find_obj_files(const TreeNode& node, std::vector<NamedFile>& files) {
    const TreeNode* kind = node.find("kind");
    const TreeNode* file = node.find("file");
    if (kind != nullptr && (kind->text == "hull" || kind->text == "compound") && file != nullptr) {
        files.push_back({kind->text == "compound" ? NamedFile::Kind::groups : NamedFile::Kind::points, file});
    }
    for (const TreeNode& child : node.children) {
        find_obj_files(child, files);
    }
}

std::vector<NamedFile> named_files(const TreeNode& root) {
    std::vector<NamedFile> files;
    find_obj_files(root, files);
    const TreeNode* overlay = root.find("overlay");
    const TreeNode* logo = overlay != nullptr ? overlay->find("logo") : nullptr;
    if (logo != nullptr && !logo->text.starts_with(png_text)) {
        files.push_back({NamedFile::Kind::logo, logo});
    }
    return files;
}

/// "points = [[0, 0, 0], ...]"
std::string points_text(const std::vector<Vec3>& points) {
    std::vector<std::string> texts;
    for (const Vec3& x : points) {
        texts.push_back(fmt::format("[{}, {}, {}]", x.x(), x.y(), x.z()));
    }
    return fmt::format("points = [{}]", fmt::join(texts, ", "));
}

/// Key and value that stand in the scene's text for the file.
std::string text_of_file(const TextSource& source, const NamedFile& named) {
    const FileBeside file = file_beside(source, named.name->text);
    switch (named.kind) {
    case NamedFile::Kind::logo:
        return fmt::format("logo = \"{}{}\"", png_text, base64(file.bytes));
    case NamedFile::Kind::points:
        return points_text(obj_points(file.bytes, file.path));
    case NamedFile::Kind::groups:
        break;
    }
    std::vector<std::string> parts;
    for (const std::vector<Vec3>& group : obj_groups(file.bytes, file.path)) {
        parts.push_back(fmt::format("{{ kind = \"hull\", {} }}", points_text(group)));
    }
    return fmt::format("parts = [{}]", fmt::join(parts, ", "));
}

} // namespace

FileBeside file_beside(const TextSource& source, const std::string& name) {
    const std::filesystem::path path = std::filesystem::path(source.file).parent_path() / name;
    std::error_code error;
    if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: not a file", path.string())); // a pipe may never end
    }
    return {path.string(), read_text_file(path)};
}

std::string read_logo(Section& section) {
    const std::string text = section.text("logo");
    std::optional<std::string> png;
    if (text.starts_with(png_text)) {
        png = bytes_of_base64(std::string_view(text).substr(png_text.size()));
    } else {
        png = read_beside(section, "logo", [](const std::string& bytes, const std::string&) { return bytes; });
    }
    if (!png || !png->starts_with(png_signature)) {
        section.fail("logo", "logo is another file, expected PNG");
    }
    return *png;
}

std::string text_with_files(std::string text, const TreeNode& root, const TextSource& source) {
    std::vector<NamedFile> files = named_files(root);
    std::ranges::sort(files, std::ranges::greater{}, [](const NamedFile& file) {
        return std::pair(file.name->place.line, file.name->place.column);
    });
    for (const NamedFile& file : files) {
        const std::string& key_name = file.name->key;
        const std::size_t key = offset_of(text, file.name->key_place);
        const std::size_t value = offset_of(text, file.name->place);
        const std::size_t end = text.find(text[value], value + 1);
        if (text.compare(key, key_name.size(), key_name) != 0 || end == std::string::npos ||
            text.substr(value + 1, end - value - 1) != file.name->text) {
            fail_at(source, file.name->place,
                    fmt::format("the file's name is written in an unusual way, expected {} = \"NAME\"", key_name));
        }
        text.replace(key, end + 1 - key, text_of_file(source, file));
    }
    return text;
}

} // namespace sim
