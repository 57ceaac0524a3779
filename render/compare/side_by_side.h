#pragma once
/// A film of two sequences: reference | candidate | difference, frame by frame.
#include "render/compare/sequence.h"

namespace diff {

/// Writes folder / CASE.mp4 if the two are sequences that are not identical, and enters it. Frames of folders are
/// shown at 30 a second, films at the reference's rate. Panels are made smaller by whole factors so that the film is
/// at most 1920 pixels wide. Where a side has no such frame its panel is black. Throws Error (io).
void write_side_by_side(const Sides& sides, const Settings& settings, const FilmTools& films,
                        const std::filesystem::path& folder, Case& result);

} // namespace diff
