#pragma once
/// A scene's bodies and a snapshot's poses as the independent check of overlaps wants them.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"
#include "tests/laws/reference/overlap.h"

#include <vector>

namespace laws {

std::vector<reference::Solid> solids(const sim::SceneDef& scene);
std::vector<reference::Placement> placements(const sim::Snapshot& snapshot);

} // namespace laws
