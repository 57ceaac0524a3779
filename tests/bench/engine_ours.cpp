#include "tests/bench/engine.h"

#include "sim/error.h"
#include "sim/world.h"

#include <fmt/format.h>

#include <memory>

namespace bench {

Surface common_surface(const sim::SceneDef& scene) {
    const sim::MaterialDef& first = scene.bodies.at(0).material;
    for (const sim::BodyDef& body : scene.bodies) {
        if (body.material.restitution != first.restitution || body.material.mu_s != first.mu_s ||
            body.material.mu_d != first.mu_s) {
            throw sim::Error(sim::ExitCode::usage, "the benchmark needs one surface for all bodies; '" +
                                                       body.name + "' has another");
        }
    }
    return {first.restitution.value_or(0.0), first.mu_s.value_or(0.0)};
}

Engine make_ours(const sim::SceneDef& scene) {
    const auto world = std::make_shared<sim::World>(scene, 1);
    Engine engine;
    engine.name = "tumble";
    const auto last = std::make_shared<sim::StepReport>();
    engine.step = [world, last] { *last = world->step(); };
    engine.counts = [last] {
        const sim::StepReport& report = *last;
        const auto stage = [&](sim::Stage s) { return report.stage_ms[static_cast<std::size_t>(s)]; };
        return StepCounts{.contacts = report.contacts,
                          .collisions = report.collisions,
                          .iterations = report.contact_iterations + report.collision_iterations,
                          .unconverged = report.at_iteration_limit,
                          .collisions_ms = stage(sim::Stage::collisions),
                          .contacts_ms = stage(sim::Stage::contacts)};
    };
    engine.placements = [world] {
        std::vector<reference::Placement> all;
        for (const sim::BodySnapshot& body : world->take_snapshot().bodies) {
            all.push_back({body.position, body.orientation});
        }
        return all;
    };
    engine.state_hash = [world] { return fmt::format("{:016x}", sim::state_hash(world->take_snapshot())); };
    return engine;
}

} // namespace bench
