#pragma once
/// tumble study: what settings of a scene cost and how wrong they are.
#include "render/cmd/slurm.h"
#include "render/study/engine.h"
#include "render/study/plan.h"

#include <span>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct StudyOptions {
    std::vector<std::string> scenes;
    study::Request request; ///< scene: filled in for each
    std::string out;        ///< folder; empty: out/study
    std::string duration;   ///< [s]
    int jobs = 0;           ///< processes; 0: one a core
    int limit = 600;        ///< [s] of processor time a point
    std::string part;       ///< "points:K/N": every N-th, from K on, and no tables; empty: all
    Placement placement;    ///< of the work
    bool has_films = true;
    bool is_quiet = false;
};

/// Adds the options of the verb. `options` must outlive the parsing.
void add_study_options(CLI::App& verb, StudyOptions& options);

/// Studies each scene with all engines, the first of them ours; of several scenes fronts.svg and .png too, in the folder of
/// their folders. Throws Error.
void study_scenes(const StudyOptions& options, std::span<const study::EngineKind> engines);

} // namespace cmd
