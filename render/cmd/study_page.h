#pragma once
/// The page of a study.
#include "render/study/table.h"

#include <filesystem>

namespace cmd {

/// Writes folder / index.html, which holds diagram.svg, statistics.svg and film/film.mp4 of the folder, where
/// they are: it can be sent as one file. Throws Error (io).
void write_study_page(const study::Plan& plan, const study::Table& table, const std::filesystem::path& folder);

} // namespace cmd
