#include "render/compare/cases.h"

#include "sim/base/error.h"

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>

namespace diff {

namespace fs = std::filesystem;

namespace {

constexpr int most_levels = 16; ///< of folders in folders: links may lead in circles

struct Numbered {
    std::string rest; ///< of the name
    std::int64_t number = 0;
};

std::optional<Numbered> numbered(const std::string& name) {
    const fs::path path = name;
    const std::string stem = path.stem().string();
    const std::size_t begin = stem.find_last_not_of("0123456789") + 1; // of no such letter: 0
    Numbered result{stem.substr(0, begin) + path.extension().string(), 0};
    const auto [end, error] = std::from_chars(stem.data() + begin, stem.data() + stem.size(), result.number);
    return error == std::errc() ? std::optional(result) : std::nullopt;
}

bool is_report(const fs::path& folder) {
    std::error_code error;
    return fs::exists(folder / "result.json", error) && fs::exists(folder / "manifest.json", error);
}

/// Names in a folder that may hold runs, and of its pictures.
struct Content {
    std::set<std::string> folders;
    std::vector<std::string> pictures;
    bool is_run = false;
};

/// Nothing of what is no folder. Throws Error (io).
Content content_of(const fs::path& folder) {
    Content content;
    std::error_code error;
    if (!fs::is_directory(folder, error)) {
        return content;
    }
    content.is_run = fs::is_directory(folder / "frames", error);
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (entry.is_directory(error) && !entry.path().filename().string().starts_with(".") && !is_report(entry.path())) {
            content.folders.insert(entry.path().filename().string());
        }
    }
    content.pictures = picture_names(folder);
    return content;
}

/// Whether pictures, films or runs are somewhere in a folder.
bool has_pictures(const fs::path& folder, int levels) {
    const Content content = content_of(folder);
    return content.is_run || !content.pictures.empty() || film_in(folder) ||
           (levels > 0 && std::any_of(content.folders.begin(), content.folders.end(), [&](const std::string& name) {
                return has_pictures(folder / name, levels - 1);
            }));
}

void add_cases(const CasePaths& at, int levels, std::vector<CasePaths>& cases) {
    const Content a = content_of(at.reference);
    const Content b = content_of(at.candidate);
    const auto inside = [&at](const std::string& name) {
        return CasePaths{at.name.empty() ? name : at.name + "/" + name, at.reference / name, at.candidate / name};
    };
    std::vector<CasePaths> in_folders;
    if (!a.is_run && !b.is_run && levels > 0) {
        std::set<std::string> folders = a.folders;
        folders.insert(b.folders.begin(), b.folders.end());
        for (const std::string& name : folders) {
            const CasePaths next = inside(name);
            if (has_pictures(next.reference, levels - 1) || has_pictures(next.candidate, levels - 1)) {
                add_cases(next, levels - 1, in_folders);
            }
        }
    }
    std::vector<std::string> pictures;
    std::set_union(a.pictures.begin(), a.pictures.end(), b.pictures.begin(), b.pictures.end(),
                   std::back_inserter(pictures));
    const bool are_unrelated = !a.is_run && !b.is_run && pictures.size() > 1 && frame_numbers(pictures).empty();
    for (const std::string& name : are_unrelated ? pictures : std::vector<std::string>()) {
        cases.push_back(inside(name));
    }
    if (!are_unrelated && (in_folders.empty() || !pictures.empty())) {
        cases.push_back(at);
    }
    std::move(in_folders.begin(), in_folders.end(), std::back_inserter(cases));
}

} // namespace

std::vector<CasePaths> find_cases(const fs::path& reference, const fs::path& candidate) {
    const CasePaths whole{{}, reference, candidate};
    std::error_code error;
    if (!fs::is_directory(reference, error) || !fs::is_directory(candidate, error)) {
        return {whole};
    }
    std::vector<CasePaths> cases;
    add_cases(whole, most_levels, cases);
    return cases;
}

std::vector<std::int64_t> frame_numbers(const std::vector<std::string>& names) {
    std::vector<std::int64_t> numbers;
    std::set<std::int64_t> seen;
    std::string rest;
    for (const std::string& name : names) {
        const std::optional<Numbered> found = numbered(name);
        if (!found || !seen.insert(found->number).second || (!numbers.empty() && found->rest != rest)) {
            return {};
        }
        rest = found->rest;
        numbers.push_back(found->number);
    }
    return numbers;
}

void sort_frames(std::vector<std::string>& names) {
    if (!frame_numbers(names).empty()) {
        std::sort(names.begin(), names.end(),
                  [](const std::string& a, const std::string& b) { return numbered(a)->number < numbered(b)->number; });
    }
}

} // namespace diff
