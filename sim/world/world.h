#pragma once
/// The simulation: owns all bodies and joints and advances them step by step.
#include "sim/base/step_report.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <memory>

namespace sim {

struct WorldState;

class World {
public:
    /// threads >= 1: the result does not depend on it.
    explicit World(const SceneDef& scene, int threads = 1);
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    /// Advances by one time step. Throws Error (stopped) with body, step and stage when a state is not
    /// finite.
    StepReport step();

    std::int64_t step_index() const;
    /// t = step_index * h, never accumulated [s].
    double time() const;
    /// contacts: how much of them it holds.
    Snapshot take_snapshot(ContactDetail contacts = ContactDetail::none) const;

    /// From now on the impulses of impacts are kept.
    void record_impacts();
    /// Those kept since this was last asked, in the order of the steps.
    std::vector<ContactSnapshot> take_impacts();

private:
    std::unique_ptr<WorldState> state_;
};

} // namespace sim
