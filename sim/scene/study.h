#pragma once
/// What a scene says for `tumble study`: its table [study].
#include "sim/model/scene_def.h"
#include "sim/scene/tree.h"

#include <string>
#include <vector>

namespace sim {

/// A closed form of the scene's motion, which a study takes as the truth.
enum class Law { none, sliding_block, bouncing_ball, rolling_ball, tower, free_rotation };

/// Of preview, standard, accurate.
inline constexpr std::size_t preset_count = 3;

struct StudyDef {
    Law law = Law::none;
    std::string seed_key;     ///< varied from run to run; empty: the motion is not chaotic
    double gate_height = 0.0; ///< [m] bodies below it have passed
    /// Error and cost [s/s] that studies found of the presets preview, standard, accurate; empty: not known.
    std::vector<Eigen::Vector2d> promises;
};

/// Throws Error (usage) for what is wrong with the table.
StudyDef read_study(const TextSource& source, const TreeNode& node);

/// That of a scene that has been read.
StudyDef study_of(const SceneDef& scene);

} // namespace sim
