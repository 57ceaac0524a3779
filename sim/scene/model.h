#pragma once
/// Which parts of the model a scene switches on, and why: what a part needs must be there, and a setting may turn it
/// off. The others cost a branch a step.
#include "sim/model/scene_def.h"

#include <string>
#include <vector>

namespace sim {

struct ModelPart {
    std::string name;   ///< "friction"
    bool is_on = false;
    std::string reason; ///< of one that is on: "mu 0.1 in 1005 bodies"
};

/// All parts, in the order of a step.
std::vector<ModelPart> model_parts(const SceneDef& scene);

/// Bodies from this restitution [-] on are elastic. Held ahead, an impact gives its energy back up to a step late: rows of
/// elastic balls lose or gain a tenth of it in some seconds (law_cradle); one that loses more by itself shows nothing of it.
inline constexpr double elastic_restitution = 0.9;

/// How the impacts of the scene are handled, never `automatic`: that stops at impacts where a body is elastic.
ImpactHandling impact_handling(const SceneDef& scene);

} // namespace sim
