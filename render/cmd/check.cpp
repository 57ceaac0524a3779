/// tumble check: reads and validates scenes, and prints what they contain.
#include "render/cmd/options.h"
#include "render/overlay/overlay.h"
#include "render/study/law.h"
#include "sim/scene/summary.h"

#include <cstdio>

namespace cmd {

void check_scenes(const Options& options) {
    for (const std::string& input : options.inputs) {
        const sim::SceneDef scene = load_scene(input, options);
        study::require_study(scene);
        render::check_letters(scene);
        if (!options.is_quiet) {
            std::fputs(sim::describe_scene(scene).c_str(), stdout);
        }
    }
}

} // namespace cmd
