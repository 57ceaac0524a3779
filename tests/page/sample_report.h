#pragma once
/// A report with known pictures: what the tests of the page look at.
#include "render/compare/report_page.h"

#include <filesystem>
#include <string>

/// Size of all pictures [px], and what is known of two pixels of the case "moved cube".
inline constexpr int sample_width = 320;
inline constexpr int sample_height = 180;
inline constexpr const char* hostile_name = "</script><img src=x onerror=document.title='broken'>";

/// Writes pictures, a film and index.html into the folder; cases 0..5: a moved cube, edge noise, equal
/// pictures, a sequence of 12 frames (5 to 7 changed, 6 the worst), a missing candidate, and one with a
/// hostile name.
void write_sample_report(const std::filesystem::path& folder, diff::PagePictures pictures);
