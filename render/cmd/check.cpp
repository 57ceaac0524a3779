/// tumble check: reads and validates scenes, and prints what they contain.
#include "render/cmd/options.h"
#include "sim/scene_file.h"
#include "sim/scene_summary.h"

#include <cstdio>

namespace cmd {

void check_scenes(const Options& options) {
    const std::vector<std::string> overrides = overrides_of(options);
    for (const std::string& input : options.inputs) {
        const sim::SceneDef scene = sim::load_scene(input, overrides);
        if (!options.is_quiet) {
            std::fputs(sim::describe_scene(scene).c_str(), stdout);
        }
    }
}

} // namespace cmd
