#pragma once
/// The simulation: owns all bodies and joints and advances them step by step.
#include "sim/base/step_report.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <memory>
#include <vector>

namespace sim {

struct WorldState;
class ByteReader;
class ByteWriter;

class World {
public:
    /// threads >= 1: the result does not depend on it.
    explicit World(const SceneDef& scene, int threads = 1);
    /// The world of this scene that was saved: all further steps are those that it would have made. Throws Error (io) if
    /// there are too few bytes; they are trusted otherwise.
    static World restored(const SceneDef& scene, int threads, ByteReader& from);
    ~World();
    World(World&&) noexcept;
    World& operator=(World&&) noexcept;

    /// Advances by one time step. Throws Error (stopped) with body, step and stage when a state is not finite, or a body in
    /// contact or in a joint turns by more than `largest_turn_in_step` in it.
    StepReport step();

    /// All that further steps depend on, between two of them. Only the same build of the program understands it.
    void save(ByteWriter& to) const;

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
    explicit World(std::unique_ptr<WorldState> state);

    std::unique_ptr<WorldState> state_;
};

} // namespace sim
