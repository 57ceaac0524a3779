#include "sim/world/state.h"

#include "sim/collide/narrow_phase.h"
#include "sim/model/integrate.h"

#include <algorithm>

namespace sim {
namespace {

/// Halvings of the bracket of a time of touch: to rounding.
constexpr int bisections = 60;

/// A body that moves beyond what its pairs were searched for is searched again with this much [-] to spare.
constexpr double reach_growth = 1.5;

/// Pairs are looked at again in a later round of repair where a body moved by more than this share [-] of the
/// tolerance.
constexpr double recheck_share = 0.02;

/// A contact whose features changed is taken for the one that was within this share [-] of the body's size.
constexpr double match_reach = 1e-2;

std::uint64_t id_of(const Contact& contact) {
    return contact.feature.id;
}

BodyPair bodies_of(const PairContacts& pair) {
    return {pair.manifold.body_a, pair.manifold.body_b};
}

/// Before the contacts of a pair are found anew: where they are, for those whose features change.
void keep_cores(PairContacts& pair) {
    for (std::size_t i = 0; i < std::min(pair.memory.size(), pair.manifold.contacts.size()); ++i) {
        pair.memory[i].core_a = pair.manifold.contacts[i].feature.core_a;
    }
}

/// A contact found at the planned poses, as it is at t0: the same material points and the same normal. The
/// impulse acts at t0, but along the normal that the bodies will have where they meet.
ContactGeometry moved_back(const ContactGeometry& at, const Pose& planned_a, const Pose& planned_b,
                           const Pose& a, const Pose& b) {
    ContactGeometry before;
    before.n = at.n;
    before.a = a * (planned_a.orientation.conjugate() * (at.a - planned_a.position));
    before.b = b * (planned_b.orientation.conjugate() * (at.b - planned_b.position));
    before.gap = at.n.dot(before.a - before.b);
    return before;
}

} // namespace

/// How near two bodies may be and still touch within the step [m].
double WorldState::margin_of(int a, int b) const {
    const auto ia = static_cast<std::size_t>(a);
    const auto ib = static_cast<std::size_t>(b);
    const double approach = (bodies.velocity[ia].v - bodies.velocity[ib].v).norm() + rim_speed[ia] + rim_speed[ib];
    return h * (approach + h * settings.gravity.norm()) + margin_tolerances * settings.tolerance;
}

/// How far a contact may have moved on its bodies and still be the same one [m].
double WorldState::reach_of(const BodyPair& pair) const {
    return match_reach * std::min(bodies.props[static_cast<std::size_t>(pair.a)].bounding_radius,
                                  bodies.props[static_cast<std::size_t>(pair.b)].bounding_radius);
}

/// Index of a pair in `pairs`; pairs.size() if it has no contacts.
std::size_t WorldState::pair_index(const BodyPair& pair) const {
    const auto sorted_end = pairs.begin() + static_cast<std::ptrdiff_t>(sorted_pairs);
    const auto place = std::ranges::lower_bound(pairs.begin(), sorted_end, pair, {}, bodies_of);
    if (place != sorted_end && bodies_of(*place) == pair) {
        return static_cast<std::size_t>(place - pairs.begin());
    }
    const auto added = std::ranges::find(sorted_end, pairs.end(), pair, bodies_of);
    return static_cast<std::size_t>(added - pairs.begin());
}

bool WorldState::are_boxes(const BodyPair& pair) const {
    return is_box[static_cast<std::size_t>(pair.a)] != 0 && is_box[static_cast<std::size_t>(pair.b)] != 0;
}

/// A lower bound of the distance of two bodies at these poses, by what the last look found [m].
double WorldState::least_separation(const BodyPair& pair, std::size_t slot, const Pose& pose_a,
                                    const Pose& pose_b) const {
    const Separation& found = separations[slot];
    return found.distance < 0.0
               ? found.distance
               : found.distance -
                     moved_by(bodies.props[static_cast<std::size_t>(pair.a)], found.a, pose_a, Vec3::Zero()) -
                     moved_by(bodies.props[static_cast<std::size_t>(pair.b)], found.b, pose_b, Vec3::Zero());
}

/// Where the candidate bodies that are boxes stand, at `poses`; is_moved(i): has body i moved since its pairs were
/// looked at, or were they not yet?
template <typename F>
void WorldState::place_boxes(std::span<const Pose> poses, F&& is_moved) {
    moved.resize(reported_count);
    box_pose.resize(reported_count);
    box_rows.resize(reported_count);
    workers.run(
        candidate_bodies.size(),
        [&](std::size_t first, std::size_t last) {
            for (std::size_t k = first; k < last; ++k) {
                const std::size_t i = candidate_bodies[k];
                moved[i] = is_moved(i);
                is_unseen[i] = 0;
                if (is_box[i] == 0) {
                    continue;
                }
                const Mat3 rotation = poses[i].orientation.toRotationMatrix();
                const Vec3& half = std::get<Box>(bodies.props[i].shape).half_extents;
                std::copy_n(rotation.data(), 9, box_rows[i].axes);
                std::copy_n(poses[i].position.data(), 3, box_rows[i].centre);
                std::copy_n(half.data(), 3, box_rows[i].half);
                if (moved[i] != 0) {
                    box_pose[i] = poses[i]; // all axes of body i are of this pose
                }
            }
        },
        least_shared);
}

/// Separating axes of the pairs of boxes among the candidates first..last with a body that has `moved`.
void WorldState::update_axes(std::size_t first, std::size_t last) {
    std::vector<int> a;
    std::vector<int> b;
    std::vector<int> result;
    for (std::size_t k = first; k < last; ++k) {
        const auto& [pair, slot] = candidates[k];
        if (are_boxes(pair) &&
            (moved[static_cast<std::size_t>(pair.a)] != 0 || moved[static_cast<std::size_t>(pair.b)] != 0)) {
            a.push_back(pair.a);
            b.push_back(pair.b);
            result.push_back(static_cast<int>(slot));
        }
    }
    find_axes({box_rows.data(), a.data(), b.data(), result.data(), a.size(), axes.data()});
}

/// The candidates whose bodies may touch within the step.
void WorldState::find_near() {
    constexpr double is_far = -1.0;
    near_margin.resize(candidates.size());
    workers.run(
        candidates.size(),
        [&](std::size_t first, std::size_t last) {
            update_axes(first, last);
            for (std::size_t k = first; k < last; ++k) {
                const auto& [pair, slot] = candidates[k];
                const auto [a, b] = pair;
                const double apart = are_boxes(pair)
                                         ? axes[slot].separation()
                                         : least_separation(pair, slot, bodies.pose[static_cast<std::size_t>(a)],
                                                            bodies.pose[static_cast<std::size_t>(b)]);
                const double farthest = reach[static_cast<std::size_t>(a)] + reach[static_cast<std::size_t>(b)] +
                                        margin_tolerances * settings.tolerance;
                // Most are farther: margin_of() is no larger than that.
                const double margin = apart > farthest ? is_far : margin_of(a, b);
                near_margin[k] = apart > margin ? is_far : margin;
            }
        },
        least_shared);
    near.clear();
    for (std::size_t k = 0; k < candidates.size(); ++k) {
        if (near_margin[k] != is_far) {
            near.push_back({k, near_margin[k]});
        }
    }
}

void WorldState::find_contacts(StepReport& report) {
    {
        const StageClock clock(report, Stage::broad_phase);
        find_reach();
        find_candidates();
    }
    const StageClock clock(report, Stage::narrow_phase);
    place_boxes(bodies.pose, [&](std::size_t i) {
        return is_unseen[i] != 0 ||
               (is_box[i] != 0 && (box_pose[i].position != bodies.pose[i].position ||
                                   box_pose[i].orientation.coeffs() != bodies.pose[i].orientation.coeffs()));
    });
    find_near();
    if (sorted_pairs < pairs.size()) {
        std::ranges::sort(pairs, {}, bodies_of);
    }
    std::vector<PairContacts> found(near.size());
    workers.run(
        near.size(),
        [&](std::size_t first, std::size_t last) {
            take_known_pairs(first, last, found);
            std::vector<Contact> contacts;
            for (std::size_t i = first; i < last; ++i) {
                if (i + prefetch_pairs < last) {
                    const PairContacts& pair = found[i + prefetch_pairs];
                    prefetch(pair.memory.data(), pair.memory.size() * sizeof(ContactMemory));
                    prefetch(pair.manifold.contacts.data(), pair.manifold.contacts.size() * sizeof(Contact));
                }
                find_pair_contacts(near[i], contacts, found[i]);
            }
        },
        least_shared);
    std::erase_if(found, [](const PairContacts& pair) { return pair.manifold.contacts.empty(); });
    pairs = std::move(found);
    sorted_pairs = pairs.size();
    replaced.clear();
    report.pairs = static_cast<int>(candidates.size());
    report.manifolds = static_cast<int>(pairs.size());
}

/// What the last step remembers of the pairs first..last in `near` goes from `pairs` to `found` [near]; nothing where
/// it remembers nothing.
void WorldState::take_known_pairs(std::size_t first, std::size_t last, std::vector<PairContacts>& found) {
    auto pair = std::ranges::lower_bound(pairs, candidates[near[first].candidate].bodies, {}, bodies_of);
    for (std::size_t i = first; i < last; ++i) {
        const BodyPair& candidate = candidates[near[i].candidate].bodies;
        while (pair != pairs.end() && bodies_of(*pair) < candidate) {
            ++pair;
        }
        if (pair != pairs.end() && bodies_of(*pair) == candidate) {
            found[i] = std::move(*pair++);
        }
    }
}

/// Contacts of one pair at the present poses; pair: what the last step remembers of it. contacts: memory.
void WorldState::find_pair_contacts(const NearPair& of, std::vector<Contact>& contacts, PairContacts& pair) {
    const auto& [k, margin] = of;
    const auto& [candidate, slot] = candidates[k];
    const auto a = static_cast<std::size_t>(candidate.a);
    const auto b = static_cast<std::size_t>(candidate.b);
    const Shape& shape_a = bodies.props[a].shape;
    const Shape& shape_b = bodies.props[b].shape;
    contacts.clear();
    if (are_boxes(candidate)) {
        find_box_contacts(std::get<Box>(shape_a), bodies.pose[a], std::get<Box>(shape_b), bodies.pose[b], axes[slot],
                          margin, contacts);
    } else {
        sim::find_contacts(shape_a, bodies.pose[a], shape_b, bodies.pose[b], margin, contacts);
        if (contacts.empty()) {
            separations[slot] = {separation(shape_a, bodies.pose[a], shape_b, bodies.pose[b]), bodies.pose[a],
                                 bodies.pose[b]};
        }
    }
    if (pair.manifold.contacts.empty()) {
        pair.manifold.body_a = candidate.a;
        pair.manifold.body_b = candidate.b;
        pair.material = pair_material(bodies.props[a], bodies.props[b]);
    }
    const bool same_features = std::ranges::equal(contacts, pair.memory, {}, id_of, &ContactMemory::id);
    if (!same_features) {
        keep_cores(pair);
    }
    pair.manifold.contacts.assign(contacts.begin(), contacts.end());
    if (contacts.empty()) {
        return;
    }
    if (same_features) {
        pair.blocks = block_count(pair.manifold.contacts);
    } else {
        match_memory(pair, reach_of(candidate));
    }
    sum_up(pair);
}

/// Depth of penetration of all candidate pairs at the planned poses, by their shapes and not by the contacts
/// of the solve. In later rounds only pairs of bodies that moved since are looked at.
void WorldState::check_pairs() {
    const std::span<const Pose> planned = contact_solver.predicted();
    // An impulse may throw a body farther than its velocity before told.
    const Vec3 drift = search_drift_in(interval);
    escaped.clear();
    for (const std::size_t i : contact_solver.solved_bodies()) {
        if (i >= reported_count) {
            continue;
        }
        const double throw_of = moved_by(bodies.props[i], bodies.pose[i], planned[i], drift);
        if (throw_of > reach[i]) {
            reach[i] = reach_growth * throw_of;
            if (has_escaped(i)) {
                escaped.push_back(static_cast<int>(i));
            }
        }
    }
    have_many_escaped() ? find_all_candidates() : find_candidates_of_escaped();
    checked_pose.resize(reported_count);
    place_boxes(planned, [&](std::size_t i) {
        const bool is_moved =
            check_all || is_unseen[i] != 0 ||
            moved_by(bodies.props[i], checked_pose[i], planned[i], Vec3::Zero()) > recheck_share * settings.tolerance;
        if (is_moved) {
            checked_pose[i] = planned[i];
        }
        return is_moved;
    });
    check_all = false;
    workers.run(
        candidates.size(),
        [&](std::size_t first, std::size_t last) {
            update_axes(first, last);
            for (std::size_t k = first; k < last; ++k) {
                const auto& [pair, slot] = candidates[k];
                const auto a = static_cast<std::size_t>(pair.a);
                const auto b = static_cast<std::size_t>(pair.b);
                if (are_boxes(pair)) {
                    pair_penetration[slot] = -axes[slot].separation();
                } else if (moved[a] != 0 || moved[b] != 0) {
                    pair_penetration[slot] = -least_separation(pair, slot, planned[a], planned[b]);
                    if (pair_penetration[slot] >= 0.0) {
                        pair_penetration[slot] =
                            -separation(bodies.props[a].shape, planned[a], bodies.props[b].shape, planned[b]);
                    }
                }
            }
        },
        least_shared);
}

/// Gives each pair that would overlap by more than the tolerance the contacts found at the planned poses.
/// Where the step stops at impacts, pairs that are apart now are left to overlap_time(). Returns the number
/// of pairs repaired.
int WorldState::repair() {
    check_pairs();
    const std::span<const Pose> planned = contact_solver.predicted();
    verified_penetration = 0.0;
    meeting.clear();
    int repaired = 0;
    std::vector<Contact> contacts;
    std::vector<PairContacts> added;
    std::vector<int> changed; // pairs whose contacts go into the solve
    for (const auto& [candidate, slot] : candidates) {
        verified_penetration = std::max(verified_penetration, pair_penetration[slot]);
        if (pair_penetration[slot] <= settings.tolerance) {
            continue;
        }
        const auto a = static_cast<std::size_t>(candidate.a);
        const auto b = static_cast<std::size_t>(candidate.b);
        if (stops_at_impacts() && separation(bodies.props[a].shape, bodies.pose[a], bodies.props[b].shape,
                                             bodies.pose[b]) > touch_gap(settings)) {
            meeting.push_back(candidate);
            continue;
        }
        ++repaired;
        sim::find_contacts(bodies.props[a].shape, planned[a], bodies.props[b].shape, planned[b], 0.0,
                           contacts);
        for (Contact& contact : contacts) {
            contact.at = moved_back(contact.at, planned[a], planned[b], bodies.pose[a], bodies.pose[b]);
        }
        const std::size_t index = pair_index(candidate);
        if (index < pairs.size()) {
            if (!contacts.empty()) {
                replace_contacts(index, contacts);
                changed.push_back(static_cast<int>(index));
            }
            continue;
        }
        PairContacts fresh;
        fresh.manifold = {candidate.a, candidate.b, contacts};
        fresh.material = pair_material(bodies.props[a], bodies.props[b]);
        match_memory(fresh, 0.0);
        added.push_back(std::move(fresh));
    }
    for (PairContacts& pair : added) {
        changed.push_back(static_cast<int>(pairs.size()));
        pairs.push_back(std::move(pair));
    }
    contact_solver.add_contacts(bodies, pairs, changed, after_collisions);
    return repaired;
}

/// When the first of the pairs in `meeting` touches, the bodies moving freely with the velocities found [s];
/// just before.
std::optional<double> WorldState::overlap_time() const {
    std::optional<double> earliest;
    const std::span<const Velocity> velocity = contact_solver.velocity();
    for (const BodyPair& pair : meeting) {
        const auto a = static_cast<std::size_t>(pair.a);
        const auto b = static_cast<std::size_t>(pair.b);
        const auto separation_at = [&](double t) {
            return separation(bodies.props[a].shape,
                              free_motion(bodies.props[a], bodies.pose[a], velocity[a], settings.gravity, t),
                              bodies.props[b].shape,
                              free_motion(bodies.props[b], bodies.pose[b], velocity[b], settings.gravity, t));
        };
        double early = 0.0;
        double late = earliest.value_or(interval);
        if (separation_at(late) >= 0.0) {
            continue;
        }
        for (int i = 0; i < bisections; ++i) {
            const double middle = 0.5 * (early + late);
            (separation_at(middle) >= 0.0 ? early : late) = middle;
        }
        earliest = early;
    }
    return earliest;
}

/// Undoes all repair: contacts found at the end of one interval tell nothing about a shorter one, within which the bodies
/// need not get there.
void WorldState::put_back_replaced() {
    for (auto& [index, pair] : replaced) {
        pairs[index] = std::move(pair);
    }
    replaced.clear();
    pairs.resize(sorted_pairs);
}

/// Takes the contacts of a pair out of the solve; others take their place.
void WorldState::replace_contacts(std::size_t index, const std::vector<Contact>& contacts) {
    PairContacts& pair = pairs[index];
    if (index < sorted_pairs && std::ranges::find(replaced, index, &decltype(replaced)::value_type::first) == replaced.end()) {
        replaced.emplace_back(index, pair);
    }
    contact_solver.drop_contacts(bodies, static_cast<int>(index));
    keep_cores(pair);
    pair.manifold.contacts = contacts;
    match_memory(pair, reach_of({pair.manifold.body_a, pair.manifold.body_b}));
}

} // namespace sim
