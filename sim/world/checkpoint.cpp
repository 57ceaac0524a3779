/// The state of a world as bytes: all that the next step depends on.
#include "sim/base/bytes.h"
#include "sim/base/error.h"
#include "sim/world/state.h"
#include "sim/world/world.h"

#include <memory>
#include <type_traits>
#include <utility>

namespace sim {
namespace {

/// One list for both directions. What it leaves out follows from it, or from the scene; candidates follow from where they
/// were searched for.
template <typename Archive, typename State>
void exchange(Archive& archive, State& state) {
    archive(state.step_index);
    archive(state.bodies.pose);
    archive(state.bodies.velocity);
    archive(state.energy);
    // The interval planned next.
    archive(state.interval);
    archive(state.divided);
    archive(state.begun_at_limit);
    archive(state.stopped_at_impact);
    archive(state.gives_way);
    archive(state.repair.verified_penetration);
    archive(state.joint_rate);
    archive(state.connected);
    state.contact_solver.exchange_plan(archive);
    // What contacts and joints remember.
    for (auto& joint : state.joints) {
        archive(joint.memory);
    }
    std::size_t pair_count = state.search.pairs.size();
    archive(pair_count);
    if constexpr (std::is_same_v<Archive, ByteReader>) {
        state.search.pairs.resize(pair_count);
    }
    for (auto& pair : state.search.pairs) {
        archive(pair.manifold.body_a);
        archive(pair.manifold.body_b);
        archive(pair.manifold.contacts);
        archive(pair.material);
    }
    archive(state.impacts);
    state.search.candidates.exchange(archive);
}

} // namespace

void World::save(ByteWriter& to) const {
    exchange(to, std::as_const(*state_));
}

World World::restored(const SceneDef& scene, int threads, ByteReader& from) {
    World world(std::make_unique<WorldState>(scene, threads));
    exchange(from, *world.state_);
    world.state_->resume();
    return world;
}

void WorldState::resume() {
    CHECK(bodies.pose.size() == bodies.props.size());
    find_inverse_inertia(bodies);
    bodies.time = time();
    take_due();
    velocity_at_node = contact_solver.velocity_at_node();
    progress = 1.0;
    search.candidates.resume();
}

} // namespace sim
