#pragma once
/// The film of a study: some of its points side by side, at the same time, each with its name.
#include "render/cmd/study_crew.h"
#include "render/study/table.h"

#include <filesystem>
#include <span>
#include <vector>

namespace cmd {

/// One panel of the film.
struct Panel {
    int row = 0;                  ///< index into the table
    std::string name;             ///< of its folder
    std::vector<std::string> labels; ///< lines
};

/// At most four rows worth seeing: the cheapest on the front, the settings as given, the most exact, and the
/// settings as given of each other engine.
std::vector<Panel> choose_panels(const study::Plan& plan, const study::Table& table);

/// Draws the frames of one panel into folder / frames. Throws Error.
void draw_panel(const study::Plan& plan, const study::Task& task, const study::EngineKind& engine,
                const std::filesystem::path& folder, std::atomic<std::int64_t>& steps_done);

/// Joins the frames in folder / <panel> to folder / film.mp4. Throws Error (io).
void join_panels(const study::Plan& plan, std::span<const Panel> panels, const std::filesystem::path& folder);

} // namespace cmd
