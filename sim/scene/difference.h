#pragma once
/// In which setting two scenes differ: what a run that is to be continued must not.
#include <span>
#include <string>

namespace sim {

/// A scene as it is stored: the text of its file, and the changes made to it.
struct SceneSource {
    std::string text;
    std::span<const std::string> overrides;   ///< "dotted.key=value", in the order applied
};

/// The first key whose value differs, as "simulation.tolerance is 1e-06, was 0.0001"; empty if there is none.
/// Comments, spaces and the order of keys do not count. Throws Error (usage) if one of them is no TOML.
std::string scene_difference(const SceneSource& now, const SceneSource& before);

} // namespace sim
