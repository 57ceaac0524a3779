/// study_trade SCENE... [options of `tumble study`]
///
/// `tumble study` with Bullet and ODE in the same run and the same diagrams. Their knobs: time step, sweeps of the
/// solver, Bullet's warm starting and split impulses, ODE's direct solver. Their overlaps are those of the independent check, at the
/// instants that are compared.
#include "render/cmd/guard.h"
#include "render/cmd/study.h"
#include "sim/base/error.h"
#include "sim/scene/study.h"
#include "tests/bench/engine.h"
#include "tests/laws/law_solids.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <memory>

namespace {

using Make = bench::Engine (*)(const sim::SceneDef&, const bench::PeerSettings&);

reference::ExcludedPairs jointed_pairs(const sim::SceneDef& scene) {
    reference::ExcludedPairs pairs;
    for (const sim::JointDef& joint : scene.joints) {
        pairs.insert(std::minmax(joint.body_a, joint.body_b));
    }
    return pairs;
}

double split_depth(const std::string& variant) {
    constexpr double usual = 0.04; // [m] Bullet's default
    return variant == "split" ? 0.0 : variant == "unsplit" ? std::numeric_limits<double>::infinity() : usual;
}

/// variant: "cold" (no warm start), "exact" (the direct solver), "split" (every overlap by split impulses) or "unsplit".
study::Engine make_peer(Make make, const sim::SceneDef& scene, const std::string& variant) {
    const bench::PeerSettings settings{.iterations = scene.step.iteration_limit,
                                       .warm_start = variant != "cold",
                                       .split_depth = split_depth(variant),
                                       .solves_exactly = variant == "exact"};
    const auto engine = std::make_shared<bench::Engine>(make(scene, settings));
    const auto solids = std::make_shared<std::vector<reference::Solid>>(laws::solids(scene));
    const reference::ExcludedPairs excluded = jointed_pairs(scene);
    study::Engine peer;
    peer.step = [engine, iterations = settings.iterations] {
        engine->step();
        sim::StepReport report;
        report.contacts = engine->counts().contacts;
        report.contact_iterations = iterations;
        return report;
    };
    peer.snapshot = [engine] {
        sim::Snapshot state;
        state.bodies = engine->bodies();
        return state;
    };
    peer.overlap = [engine, solids, excluded] {
        double deepest = 0.0;
        for (const reference::PairGap& pair : reference::near_pairs(*solids, engine->placements(), 0.0, excluded)) {
            deepest = std::max(deepest, -pair.gap);
        }
        return deepest;
    };
    return peer;
}

std::string sweeps(int count) {
    return fmt::format("simulation.iteration_limit={}", count);
}

bool is_statistical(const sim::SceneDef& scene) {
    return !sim::study_of(scene).seed_key.empty();
}

/// Sweeps of the solver; of statistical scenes the first two alone: they cost hours, and what they show is overlaps.
study::Knob iteration_knob(const sim::SceneDef& scene, std::vector<int> counts) {
    counts.resize(is_statistical(scene) ? 2 : counts.size());
    study::Knob knob{"iterations", {}, true};
    for (const int count : counts) {
        knob.settings.push_back({fmt::format("{} sweeps", count), {sweeps(count)}, ""});
    }
    return knob;
}

/// variant: of the engine; with its base's sweeps and without a variant the scene's own step is the base.
study::Knob step_knob(const std::string& name, const sim::SceneDef& scene, int count, const std::string& variant) {
    const bool starts_at_base = name == "time step";
    std::vector<sim::Rational> factors{{8, 1}, {4, 1}, {2, 1}};
    const std::vector<sim::Rational> finer{{1, 2}, {1, 4}};
    if (!starts_at_base) {
        factors.push_back({1, 1});
    }
    if (!is_statistical(scene)) {
        factors.insert(factors.end(), finer.begin(), finer.end());
    }
    study::Knob knob{name, study::time_steps(scene, factors, {sweeps(count)}), starts_at_base};
    for (study::Setting& setting : knob.settings) {
        setting.variant = variant;
    }
    return knob;
}

study::Knob split_knob() {
    return {"split impulses", {{"of no overlap", {sweeps(10)}, "unsplit"}, {"of every overlap", {sweeps(10)}, "split"}}, true};
}

study::EngineKind bullet() {
    study::EngineKind kind;
    kind.name = "Bullet";
    kind.base = {"10 sweeps, its default", {sweeps(10)}, ""};
    kind.make = [](const sim::SceneDef& scene, const std::string& variant) {
        return make_peer(&bench::make_bullet, scene, variant);
    };
    kind.knobs = [](const sim::SceneDef& scene) {
        return std::vector{iteration_knob(scene, {3, 30, 100, 300}), step_knob("time step", scene, 10, ""),
                           step_knob("time step, 50 sweeps", scene, 50, ""),
                           step_knob("no warm start", scene, 10, "cold"), split_knob()};
    };
    return kind;
}

study::EngineKind ode() {
    study::EngineKind kind;
    kind.name = "ODE";
    kind.base = {"20 sweeps, its default", {sweeps(20)}, ""};
    kind.make = [](const sim::SceneDef& scene, const std::string& variant) {
        return make_peer(&bench::make_ode, scene, variant);
    };
    kind.knobs = [](const sim::SceneDef& scene) {
        return std::vector{iteration_knob(scene, {5, 60, 200}), step_knob("time step", scene, 20, ""),
                           step_knob("time step, 100 sweeps", scene, 100, ""),
                           step_knob("direct solver", scene, 20, "exact")};
    };
    return kind;
}

int run(int argc, char** argv) {
    CLI::App app("tumble study, with Bullet and ODE in the same run", "study_trade");
    cmd::StudyOptions options;
    options.request.seeds = 8; // that means over them tell engines apart
    cmd::add_study_options(app, options);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        throw sim::Error(sim::ExitCode::usage, error.what());
    }
    cmd::study_scenes(options, std::array{study::our_engine(), bullet(), ode()});
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return cmd::guarded([&] { return run(argc, argv); });
}
