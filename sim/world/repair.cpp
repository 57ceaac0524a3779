#include "sim/world/repair.h"

#include "sim/collide/narrow_phase.h"
#include "sim/model/integrate.h"
#include "sim/solve/time_of_impact.h"

#include <algorithm>
#include <utility>

namespace sim {
namespace {

/// Adds those of the contacts `old` whose features are not among the new ones; in the order of the ids, as blocks need it. a, b:
/// poses where the old ones were found.
void keep_others(const Manifold& old, const Pose& a, const Pose& b, std::vector<FoundContact>& contacts) {
    const auto id_of = [](const FoundContact& contact) { return contact.feature.id; };
    for (const Contact& contact : old.contacts) {
        if (std::ranges::find(contacts, contact.id, id_of) == contacts.end()) {
            contacts.push_back(old.found(contact, a, b));
        }
    }
    std::ranges::sort(contacts, {}, id_of);
}

} // namespace

ContactGeometry moved_back(const FoundContact& found, const Pose& planned_a, const Pose& planned_b, const Pose& a, const Pose& b) {
    if (found.feature.kind == FeatureKind::face_a || found.feature.kind == FeatureKind::face_b) {
        return contact_geometry(found.feature, a, b);
    }
    const ContactGeometry& at = found.at;
    ContactGeometry before;
    before.n = at.n;
    before.a = a * (planned_a.orientation.conjugate() * (at.a - planned_a.position));
    if (found.feature.kind != FeatureKind::edges) {
        before.gap = at.n.dot(before.a - b * (planned_b.orientation.conjugate() * (at.b() - planned_b.position)));
        return before;
    }
    const Vec3 measured_along = contact_geometry(found.feature, planned_a, planned_b).n; // n is a face's where they meet flat
    const Quat turn_b = planned_b.orientation * b.orientation.conjugate();
    const Vec3 moved_with_b = planned_b.position + turn_b * (before.a - b.position);
    before.gap = (at.gap - measured_along.dot(at.a - moved_with_b)) / measured_along.dot(turn_b * measured_along);
    return before;
}

void Repair::begin(double interval, bool stops_at_impacts) {
    search_.put_back();
    interval_ = interval;
    stops_at_impacts_ = stops_at_impacts;
    is_first_ = true;
    overlapping_.clear();
}

/// Is this pair, which will overlap, an impact that is waited for?
bool Repair::is_left(const BodyPair& pair) const {
    const auto a = static_cast<std::size_t>(pair.a);
    const auto b = static_cast<std::size_t>(pair.b);
    return stops_at_impacts_ && separation({bodies_.props[a].shape, bodies_.pose[a]},
                                           {bodies_.props[b].shape, bodies_.pose[b]}) > touch_gap(settings_);
}

/// As they are at the planned poses.
std::vector<FoundContact> Repair::contacts_of(const BodyPair& pair) const {
    const auto a = static_cast<std::size_t>(pair.a);
    const auto b = static_cast<std::size_t>(pair.b);
    const std::span<const Pose> planned = solver_.predicted();
    std::vector<FoundContact> contacts;
    find_contacts({bodies_.props[a].shape, planned[a]}, {bodies_.props[b].shape, planned[b]}, 0.0, contacts);
    for (FoundContact& contact : contacts) {
        contact.at = moved_back(contact, planned[a], planned[b], bodies_.pose[a], bodies_.pose[b]);
    }
    return contacts;
}

bool Repair::verify() {
    search_.candidates.find_thrown(solver_.solved_bodies(), solver_.predicted(), interval_);
    search_.distances.check(search_.candidates, solver_.predicted(), settings_.tolerance, std::exchange(is_first_, false));
    verified_penetration = 0.0;
    meeting_.clear();
    std::swap(before_, overlapping_);
    overlapping_.clear();
    pressed.reset();
    for (const Candidate& candidate : search_.candidates.all()) {
        const double known = std::min(verified_penetration, settings_.tolerance);
        const double depth = search_.distances.penetration(candidate, solver_.predicted(), known);
        verified_penetration = std::max(verified_penetration, depth);
        if (depth <= settings_.tolerance) {
            continue;
        }
        const std::size_t index = search_.index_of(candidate.bodies);
        const double before = index < search_.pairs.size() ? -search_.pairs[index].least_gap : 0.0;
        if (is_left(candidate.bodies)) {
            meeting_.push_back(candidate.bodies);
        } else if (depth <= before) {
            continue; // it parts: a solve that came to no end has left it
        } else if (depth <= std::max(before, settings_.tolerance) + solver_.given_way(static_cast<int>(index))) {
            pressed = {.a = candidate.bodies.a, .b = candidate.bodies.b, .error = depth, .is_pressed = true};
        } else {
            overlapping_.push_back({candidate.bodies, depth});
        }
    }
    return meeting_.empty() && overlapping_.empty();
}

bool Repair::repair(std::span<const Velocity> at_node) {
    const auto is_no_less = [&](const Overlap& overlap) {
        const auto found = std::ranges::find(before_, overlap.bodies, &Overlap::bodies);
        return found != before_.end() && overlap.depth >= found->depth;
    };
    if (std::ranges::any_of(overlapping_, is_no_less)) {
        return false; // its contacts have been there already, or take turns: only a shorter interval helps
    }
    std::vector<int> changed; // pairs whose contacts go into the solve
    std::vector<int> added;
    for (const auto& [pair, depth] : overlapping_) {
        const std::size_t index = search_.index_of(pair);
        const bool is_known = index < search_.pairs.size();
        std::vector<FoundContact> contacts = contacts_of(pair);
        if (is_known && contacts.empty()) {
            continue;
        }
        if (is_known) {
            keep_others(search_.pairs[index].manifold, bodies_.pose[static_cast<std::size_t>(pair.a)],
                        bodies_.pose[static_cast<std::size_t>(pair.b)], contacts);
            search_.keep(index);
            solver_.drop_contacts(bodies_, search_.pairs, static_cast<int>(index));
        }
        (is_known ? changed : added).push_back(static_cast<int>(search_.put(pair, contacts)));
    }
    changed.insert(changed.end(), added.begin(), added.end());
    solver_.add_contacts(bodies_, search_.pairs, changed, at_node);
    return !overlapping_.empty();
}

std::optional<double> Repair::overlap_time() const {
    std::optional<double> earliest;
    const std::span<const Velocity> velocity = solver_.velocity();
    for (const BodyPair& pair : meeting_) {
        const auto a = static_cast<std::size_t>(pair.a);
        const auto b = static_cast<std::size_t>(pair.b);
        const auto separation_at = [&](double t) {
            const Pose at_a = free_motion(bodies_.props[a], bodies_.pose[a], velocity[a], settings_.gravity, t);
            const Pose at_b = free_motion(bodies_.props[b], bodies_.pose[b], velocity[b], settings_.gravity, t);
            return separation({bodies_.props[a].shape, at_a}, {bodies_.props[b].shape, at_b});
        };
        const double late = earliest.value_or(interval_);
        const double apart = separation_at(late);
        if (apart < 0.0) {
            earliest = closing_time(separation_at, separation_at(0.0), late, apart);
        }
    }
    return earliest;
}

} // namespace sim
