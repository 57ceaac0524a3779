/// Bodies that wait until they are released: no mass, no box for the search, and so no part in anything.
#include "sim/base/error.h"
#include "sim/world/state.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace sim {

void WorldState::let_wait(const SceneDef& scene) {
    for (std::size_t i = 0; i < reported_count; ++i) {
        if (!scene.bodies[i].is_there(0.0)) {
            waiting.push_back({i, scene.bodies[i].release, std::exchange(bodies.props[i].inverse_mass, 0.0)});
            bodies.props[i].is_waiting = true;
        }
    }
    std::ranges::stable_sort(waiting, std::ranges::greater{}, &Waiting::release);
}

/// Gives those whose time has come their mass; from now on they are like all others. Returns them, ascending.
std::vector<std::size_t> WorldState::take_due() {
    std::vector<std::size_t> due;
    while (!waiting.empty() && waiting.back().release <= bodies.time) {
        const Waiting& next = waiting.back();
        bodies.props[next.body].inverse_mass = next.inverse_mass;
        bodies.props[next.body].is_waiting = false;
        due.push_back(next.body);
        waiting.pop_back();
    }
    std::ranges::sort(due);
    return due;
}

/// At the end of a step.
std::vector<std::size_t> WorldState::release() {
    if (progress < 1.0) {
        return {};
    }
    const std::vector<std::size_t> released = take_due();
    for (const std::size_t body : released) {
        search.candidates.release(body);
        energy.admit(bodies, body, settings);
    }
    return released;
}

/// Once contacts are found: is the place of each their own? Throws Error(stopped).
void WorldState::check_places_of(std::span<const std::size_t> released) const {
    if (released.empty()) {
        return;
    }
    const auto is_new = [&](int body) { return std::ranges::binary_search(released, static_cast<std::size_t>(body)); };
    for (const PairContacts& pair : search.pairs) {
        const auto [other, body] = is_new(pair.manifold.body_b) ? std::pair(pair.manifold.body_a, pair.manifold.body_b)
                                                                : std::pair(pair.manifold.body_b, pair.manifold.body_a);
        for (const Contact& contact : pair.manifold.contacts) {
            if (is_new(body) && contact.at.gap < -settings.tolerance) {
                throw Error(ExitCode::stopped,
                            fmt::format("body '{}' is released at {:.6g} s, but '{}' is in its place, {:.3g} m deep, expected at "
                                        "most the tolerance, {:g} m; release it later or elsewhere",
                                        names[static_cast<std::size_t>(body)], time(), names[static_cast<std::size_t>(other)],
                                        -contact.at.gap, settings.tolerance));
            }
        }
    }
}

} // namespace sim
