#pragma once
/// Patterns of a scene file: one table that stands for many bodies.
#include "sim/model/scene_def.h"
#include "sim/scene/section.h"

#include <vector>

namespace sim {

/// [[lattice]]: equal bodies in rows, columns and layers with seeded turns, all at once or layer by layer. Body (i, j, k) has number
/// i + count_x (j + count_y k).
std::vector<BodyDef> read_lattice(const TextSource& source, const TreeNode& node, const std::string& title);

/// [[funnel]]: four static plates.
std::vector<BodyDef> read_funnel(const TextSource& source, const TreeNode& node, const std::string& title);

} // namespace sim
