#pragma once
/// The findings of a comparison -> one HTML page for a person. The page needs no network.
#include <filesystem>
#include <string>

namespace diff {

/// Where the pictures of a page are.
enum class PagePictures {
    linked, ///< files beside it. Their pixel values are shown over http only: browsers keep those of one local file from another
    inside, ///< in the page itself, which then needs nothing beside it but films
};

/// Writes folder / index.html. result_json: as README.md in this folder describes it; the pictures and films
/// that it names lie in the folder. Same findings and pictures, same bytes. Throws Error (io).
void write_report_page(const std::filesystem::path& folder, const std::string& result_json, PagePictures pictures);

} // namespace diff
