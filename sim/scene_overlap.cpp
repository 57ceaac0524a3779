#include "sim/scene_overlap.h"

#include "sim/narrow_phase.h"

#include <algorithm>
#include <set>
#include <utility>

namespace sim {

namespace {

bool are_apart(const Bounds& a, const Bounds& b) {
    return (a.lower.array() > b.upper.array()).any() || (b.lower.array() > a.upper.array()).any();
}

/// Pairs held by a joint do not collide.
std::set<std::pair<int, int>> jointed_pairs(const SceneDef& scene) {
    std::set<std::pair<int, int>> pairs;
    for (const JointDef& joint : scene.joints) {
        pairs.emplace(std::min(joint.body_a, joint.body_b), std::max(joint.body_a, joint.body_b));
    }
    return pairs;
}

} // namespace

std::optional<StartOverlap> find_start_overlap(const SceneDef& scene) {
    const auto at = [](auto& values, int i) -> auto& {
        return values[static_cast<std::size_t>(i)];
    };
    const std::set<std::pair<int, int>> jointed = jointed_pairs(scene);
    std::vector<Bounds> boxes;
    std::vector<int> order;
    for (const BodyDef& body : scene.bodies) {
        order.push_back(static_cast<int>(boxes.size()));
        boxes.push_back(bounds(body.shape, body.pose));
    }
    // Sweep along x: only bodies whose x intervals meet are looked at.
    std::ranges::stable_sort(order, {}, [&](int i) { return at(boxes, i).lower.x(); });
    StartOverlap worst;
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (std::size_t j = i + 1; j < order.size(); ++j) {
            if (at(boxes, order[j]).lower.x() > at(boxes, order[i]).upper.x()) {
                break;
            }
            const auto [a, b] = std::minmax(order[i], order[j]);
            const BodyDef& body_a = at(scene.bodies, a);
            const BodyDef& body_b = at(scene.bodies, b);
            if ((body_a.is_static() && body_b.is_static()) || are_apart(at(boxes, a), at(boxes, b)) ||
                jointed.contains({a, b})) {
                continue;
            }
            const double penetration = -separation(body_a.shape, body_a.pose, body_b.shape, body_b.pose);
            if (penetration <= scene.step.tolerance) {
                continue;
            }
            ++worst.pair_count;
            // Of equal depths the first pair in the order of the bodies.
            if (penetration > worst.penetration ||
                (penetration == worst.penetration &&
                 std::pair(a, b) < std::pair(worst.body_a, worst.body_b))) {
                worst.body_a = a;
                worst.body_b = b;
                worst.penetration = penetration;
            }
        }
    }
    return worst.pair_count > 0 ? std::optional(worst) : std::nullopt;
}

} // namespace sim
