#include "sim/scene/overlap.h"

#include "sim/collide/narrow_phase.h"

#include <algorithm>
#include <array>
#include <numeric>
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

/// Indices of boxes by their lower ends along an axis.
std::vector<int> order_along(const std::vector<Bounds>& boxes, int axis) {
    std::vector<int> order(boxes.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, [&](int i) { return boxes[static_cast<std::size_t>(i)].lower[axis]; });
    return order;
}

/// Pairs of boxes whose intervals along an axis meet.
double meeting_along(const std::vector<Bounds>& boxes, int axis) {
    std::vector<double> lower;
    for (const Bounds& box : boxes) {
        lower.push_back(box.lower[axis]);
    }
    std::ranges::sort(lower);
    double count = 0.0;
    for (const Bounds& box : boxes) {
        count += static_cast<double>(std::ranges::upper_bound(lower, box.upper[axis]) -
                                     std::ranges::upper_bound(lower, box.lower[axis]));
    }
    return count;
}

/// Sweep along the axis on which fewest bodies meet: only they are looked at. visit(a, b), a < b, returns false to end
/// it.
template <class Visit>
void visit_near_pairs(const std::vector<Bounds>& boxes, const Visit& visit) {
    const std::array meeting{meeting_along(boxes, 0), meeting_along(boxes, 1), meeting_along(boxes, 2)};
    const auto axis = static_cast<int>(std::ranges::min_element(meeting) - meeting.begin());
    const std::vector<int> order = order_along(boxes, axis);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const Bounds& box = boxes[static_cast<std::size_t>(order[i])];
        for (std::size_t j = i + 1; j < order.size(); ++j) {
            const Bounds& other = boxes[static_cast<std::size_t>(order[j])];
            if (other.lower[axis] > box.upper[axis]) {
                break;
            }
            if (!are_apart(box, other) && !visit(std::min(order[i], order[j]), std::max(order[i], order[j]))) {
                return;
            }
        }
    }
}

} // namespace

std::optional<StartOverlap> find_start_overlap(const SceneDef& scene) {
    const std::set<std::pair<int, int>> jointed = jointed_pairs(scene);
    std::vector<Bounds> boxes;
    for (const BodyDef& body : scene.bodies) {
        boxes.push_back(bounds(body.shape, body.pose));
    }
    StartOverlap worst;
    visit_near_pairs(boxes, [&](int a, int b) {
        const BodyDef& body_a = scene.bodies[static_cast<std::size_t>(a)];
        const BodyDef& body_b = scene.bodies[static_cast<std::size_t>(b)];
        // Where bodies will be that are there when another one is released, its release tells.
        const bool meet = body_a.release == body_b.release || body_a.is_fixed() || body_b.is_fixed();
        if (!meet || (body_a.is_static() && body_b.is_static()) || jointed.contains({a, b})) {
            return true;
        }
        const double penetration = -separation({body_a.shape, body_a.pose}, {body_b.shape, body_b.pose});
        if (penetration <= scene.step.tolerance) {
            return true;
        }
        // Of equal depths the first pair in the order of the bodies.
        if (penetration > worst.penetration ||
            (penetration == worst.penetration && std::pair(a, b) < std::pair(worst.body_a, worst.body_b))) {
            worst.body_a = a;
            worst.body_b = b;
            worst.penetration = penetration;
        }
        return ++worst.pair_count < most_overlaps;
    });
    return worst.pair_count > 0 ? std::optional(worst) : std::nullopt;
}

} // namespace sim
