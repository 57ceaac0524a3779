#include "sim/scene/study.h"

#include "sim/scene/section.h"

#include <fmt/format.h>

namespace sim {

StudyDef read_study(const TextSource& source, const TreeNode& node) {
    Section section(source, node, scene_section("study"), "study");
    StudyDef study;
    study.law = static_cast<Law>(section.choice("law"));
    study.seed_key = section.has("seed_key") ? section.text("seed_key") : "";
    study.gate_height = section.number("gate_height");
    if (section.has("gate_height") && study.seed_key.empty()) {
        section.fail("gate_height", "gate_height has no effect without seed_key");
    }
    if (section.has("promises")) {
        study.promises = section.pairs("promises");
        if (study.promises.size() != preset_count) {
            section.fail("promises", fmt::format("promises has {} pairs, expected {}: preview, standard, accurate",
                                                 study.promises.size(), preset_count));
        }
    }
    return study;
}

StudyDef study_of(const SceneDef& scene) {
    const TextSource source{scene.name + ".toml", scene.overrides};
    TreeNode root = parse_tree(scene.text, source);
    for (std::size_t i = 0; i < scene.overrides.size(); ++i) {
        apply_assignment(root, source, static_cast<int>(i));
    }
    const TreeNode* table = root.find("study");
    return table != nullptr ? read_study(source, *table) : StudyDef{};
}

} // namespace sim
