#include "tests/bench/engine.h"

#include "sim/base/error.h"
#include "sim/world/world.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>

namespace bench {

Surface surface_of(const sim::MaterialDef& a, const sim::MaterialDef& b) {
    const auto mean = [](const std::optional<double>& x, const std::optional<double>& y) {
        return x && y ? std::sqrt(*x * *y) : x.value_or(y.value_or(0.0));
    };
    return {mean(a.restitution, b.restitution), mean(a.mu_d, b.mu_d)};
}

void check_peer_can(const sim::SceneDef& scene) {
    const auto refuse = [](const char* what, const std::string& name) {
        throw sim::Error(sim::ExitCode::usage, fmt::format("the peers are not given {}: '{}'", what, name));
    };
    for (const sim::BodyDef& body : scene.bodies) {
        if (body.is_kinematic()) {
            refuse("bodies that keys move", body.name);
        }
    }
    for (const sim::JointDef& joint : scene.joints) {
        if (joint.kind == sim::JointKind::slider || joint.spring || joint.motor) {
            refuse("sliders, springs and motors", joint.name);
        }
    }
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
