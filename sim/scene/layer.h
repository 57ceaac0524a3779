#pragma once
/// What a scene file says on text, contacts, paths and plots over its pictures.
#include "sim/model/scene_def.h"
#include "sim/scene/section.h"

#include <functional>
#include <string>

namespace sim {

/// Index of a body by its name, -1 for the world; the other arguments are for the message: the name's place
/// and the table's title. Throws Error (usage).
using BodyFinder = std::function<int(const std::string&, const TextPlace&, const std::string&)>;

/// [overlay].
OverlayDef read_overlay(const TextSource& source, const TreeNode& node, const BodyFinder& find);

/// One [[caption]].
CaptionDef read_caption(const TextSource& source, const TreeNode& node, const std::string& title);

/// One [[plot]]. `scene`: its bodies are known.
PlotDef read_plot(const TextSource& source, const TreeNode& node, const std::string& title,
                  const SceneDef& scene, const BodyFinder& find);

} // namespace sim
