#pragma once
/// A comparison as text for machines: JSON, JUnit, Markdown, and the manifest of a report's folder. README.md in
/// this folder has the JSON's schema.
#include "render/compare/report_page.h"
#include "render/compare/result.h"
#include "sim/base/file_io.h"

#include <filesystem>
#include <string>
#include <vector>

namespace diff {

std::string to_json(const Comparison& comparison);

/// One test case a case; the numbers of the exceeded gates are in the failure's message.
std::string to_junit(const Comparison& comparison);

/// A table of the cases that are not identical, at most 50, worst first.
std::string to_markdown(const Comparison& comparison);

/// What a person reads on the terminal: a line a case.
std::string to_text(const Comparison& comparison);

/// Removes the files of an earlier report, which its manifest lists, if they are still as it wrote them. Throws
/// Error (io).
void remove_report(const std::filesystem::path& folder);

/// Part of a report's folder that holds pictures for review.
inline constexpr const char* pictures_folder = "pictures";

/// Part of a report's folder in which somebody else keeps pictures: what baselines were compared with.
inline constexpr const char* candidates_folder = "candidates/";

/// What a manifest is of.
inline constexpr const char* report_kind = "report";
inline constexpr const char* gallery_kind = "gallery";

/// folder / manifest.json: its kind, and name, size and SHA-256 of the files, in this order; empty names are left out.
/// Throws Error (io).
void write_manifest(const std::filesystem::path& folder, const char* kind, const std::vector<std::string>& names);

/// The files that the manifest of a folder lists, if there is one of this kind.
std::vector<sim::WrittenFile> read_manifest(const std::filesystem::path& folder, const char* kind);

/// True if the file is there with the size and SHA-256 that are listed.
bool is_as_written(const std::filesystem::path& folder, const sim::WrittenFile& file);

/// What a run is about to change is no longer what the gallery in the folder above shows: removes that one's manifest,
/// and its poster of the run.
void forget_in_gallery(const std::filesystem::path& run);

/// index.html, result.json, junit.xml, summary.md, and last manifest.json: size and SHA-256 of all files of the folder. The
/// pictures are there already; those inside the page go. Throws Error (io).
void write_report(const std::filesystem::path& folder, Comparison comparison, PagePictures pictures);

} // namespace diff
