#pragma once
/// Which points a study of a scene computes: the scene's own settings, every knob's, and what they are held
/// against.
#include "render/study/engine.h"
#include "sim/scene/study.h"

#include <cstdint>
#include <span>

namespace study {

/// What the user asks for.
struct Request {
    std::string scene;                  ///< file
    std::vector<std::string> overrides; ///< "dotted.key=value"
    std::vector<std::string> knobs;     ///< names; empty: all
    int seeds = 3;                      ///< runs a point, of scenes with study.seed_key
};

/// One run.
struct Task {
    std::string name{};  ///< of its files
    int engine = 0;    ///< index
    std::string knob{};  ///< empty: the base
    Setting setting{};
    bool starts_at_base = true;         ///< as in Knob
    int seed = 0;                       ///< 0 .. seeds - 1
    std::vector<std::string> overrides{}; ///< all of them
    sim::Rational time_step{};            ///< [s]
    std::int64_t steps = 0;
    std::string refusal{}; ///< why the scene cannot be run so; empty: it can
};

struct Plan {
    std::string scene_file;
    sim::SceneDef scene;  ///< with the request's overrides
    sim::StudyDef def;    ///< of that scene
    int seeds = 1;        ///< 1 where errors are not statistical
    sim::Rational spacing; ///< [s] between the instants that are compared: a multiple of every time step
    int count = 0;         ///< of these instants, with the start
    std::vector<Task> references; ///< a seed each; empty where the scene names a law
    std::vector<Task> tasks;

    bool is_statistical() const { return !def.seed_key.empty(); }
    double duration() const { return (count - 1) * spacing.value(); } ///< [s]
    std::vector<double> times() const;                                ///< [count] of the instants [s]
};

/// Throws Error: io or usage for the scene, usage for a knob that does not exist and where the time steps have
/// no common multiple below a quarter of the duration.
Plan make_plan(const Request& request, std::span<const EngineKind> engines);

/// The scene of one task. Throws as load_scene does.
sim::SceneDef scene_of(const Plan& plan, const Task& task);

} // namespace study
