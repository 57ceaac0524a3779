#pragma once
/// The findings of a comparison -> one HTML page for a person. The page needs no network and nothing beside
/// it but films, and pictures beyond a limit.
#include <cstdint>
#include <filesystem>
#include <string>

namespace diff {

/// [bytes] of picture files that become part of the page, those of the worst cases first; more are linked, so
/// that a browser on a telephone still opens the page. Pixel values of linked pictures are shown over http
/// only: browsers do not give the pixels of one local file to another.
inline constexpr std::uintmax_t page_picture_bytes = 48u << 20;

/// Writes folder / index.html. result_json: as README.md in this folder describes it; the pictures and films
/// that it names lie in the folder. Same findings and pictures, same bytes. Throws Error (io).
void write_report_page(const std::filesystem::path& folder, const std::string& result_json,
                       std::uintmax_t picture_bytes = page_picture_bytes);

} // namespace diff
