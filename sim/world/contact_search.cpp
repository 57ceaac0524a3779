#include "sim/world/contact_search.h"

#include "sim/collide/narrow_phase.h"

#include <algorithm>
#include <array>

namespace sim {
namespace {

BodyPair bodies_of(const PairContacts& pair) {
    return {pair.manifold.body_a, pair.manifold.body_b};
}

void begin_pair(PairContacts& pair, const BodyPair& of, const Bodies& bodies) {
    pair.manifold.body_a = of.a;
    pair.manifold.body_b = of.b;
    pair.material = pair_material(bodies.props[static_cast<std::size_t>(of.a)], bodies.props[static_cast<std::size_t>(of.b)]);
}

} // namespace

ContactSearch::ContactSearch(const Bodies& bodies, std::size_t count, const StepSettings& settings,
                             std::vector<BodyPair> jointed, Workers& workers)
    : candidates(bodies, count, settings, std::move(jointed)), distances(bodies, count, workers), bodies_(bodies),
      workers_(workers) {}

std::size_t ContactSearch::index_of(const BodyPair& pair) const {
    const auto sorted_end = pairs.begin() + static_cast<std::ptrdiff_t>(sorted_pairs_);
    const auto place = std::ranges::lower_bound(pairs.begin(), sorted_end, pair, {}, bodies_of);
    if (place != sorted_end && bodies_of(*place) == pair) {
        return static_cast<std::size_t>(place - pairs.begin());
    }
    const auto added = std::ranges::find(sorted_end, pairs.end(), pair, bodies_of);
    return static_cast<std::size_t>(added - pairs.begin());
}

void ContactSearch::find() {
    near_ = distances.find_near(candidates);
    if (sorted_pairs_ < pairs.size()) {
        std::ranges::sort(pairs, {}, bodies_of);
    }
    std::vector<PairContacts> found(near_.size());
    const auto find_some = [&](std::size_t first, std::size_t last) {
        take_known(first, last, found);
        std::vector<FoundContact> contacts;
        std::array<const Candidate*, lane_count> near;
        std::array<FaceCorners, lane_count> corners;
        for (; first < last; first += lane_count) {
            const std::size_t count = std::min<std::size_t>(lane_count, last - first);
            for (std::size_t i = 0; i < count; ++i) {
                near[i] = &candidates.all()[near_[first + i]];
            }
            distances.clip(std::span(near).first(count), corners);
            for (std::size_t i = 0; i < count; ++i) {
                find_contacts_of(*near[i], corners[i], contacts, found[first + i]);
            }
        }
    };
    workers_.run(near_.size(), find_some, least_shared);
    std::erase_if(found, [](const PairContacts& pair) { return pair.manifold.contacts.empty(); });
    pairs = std::move(found);
    sorted_pairs_ = pairs.size();
    replaced_.clear();
}

/// What the last step remembers of the near pairs first..last goes from `pairs` to `found` [near]; nothing where it
/// remembers nothing.
void ContactSearch::take_known(std::size_t first, std::size_t last, std::vector<PairContacts>& found) {
    auto pair = std::ranges::lower_bound(pairs, candidates.all()[near_[first]].bodies, {}, bodies_of);
    for (std::size_t i = first; i < last; ++i) {
        const BodyPair& candidate = candidates.all()[near_[i]].bodies;
        while (pair != pairs.end() && bodies_of(*pair) < candidate) {
            ++pair;
        }
        if (pair != pairs.end() && bodies_of(*pair) == candidate) {
            found[i] = std::move(*pair++);
        }
    }
}

/// Contacts of one pair at the present poses; pair: what the last step remembers of it. corners: of boxes. contacts: memory.
void ContactSearch::find_contacts_of(const Candidate& candidate, const FaceCorners& corners, std::vector<FoundContact>& contacts,
                                     PairContacts& pair) {
    const auto a = static_cast<std::size_t>(candidate.bodies.a);
    const auto b = static_cast<std::size_t>(candidate.bodies.b);
    const Shape& shape_a = bodies_.props[a].shape;
    const Shape& shape_b = bodies_.props[b].shape;
    const double margin = candidates.margin_of(candidate.bodies);
    contacts.clear();
    if (candidate.are_boxes) {
        distances.find_box_contacts(candidate, corners, margin, contacts);
    } else {
        find_contacts({shape_a, bodies_.pose[a]}, {shape_b, bodies_.pose[b]}, margin, contacts, pair.manifold.contacts);
        distances.set_found(candidate, contacts);
    }
    if (pair.manifold.contacts.empty()) {
        begin_pair(pair, candidate.bodies, bodies_);
    }
    std::vector<Contact>& known = pair.manifold.contacts;
    const auto id_found = [](const FoundContact& contact) { return contact.feature.id; };
    if (std::ranges::equal(contacts, known, {}, id_found, &Contact::id)) {
        for (std::size_t i = 0; i < known.size(); ++i) {
            known[i].set(contacts[i]);
        }
        pair.manifold.keep_features(contacts);
        pair.blocks = block_count(known);
    } else {
        replace_contacts(pair, contacts);
    }
    pair.is_repaired = false;
    sum_up(pair);
}

void ContactSearch::keep(std::size_t index) {
    if (index < sorted_pairs_ && !pairs[index].is_repaired) {
        replaced_.emplace_back(index, pairs[index]);
    }
}

std::size_t ContactSearch::put(const BodyPair& of, std::span<const FoundContact> contacts) {
    const std::size_t index = index_of(of);
    if (index == pairs.size()) {
        begin_pair(pairs.emplace_back(), of, bodies_);
    }
    PairContacts& pair = pairs[index];
    replace_contacts(pair, contacts);
    pair.is_repaired = true;
    return index;
}

/// Contacts found at the end of one interval tell nothing about a shorter one, within which the bodies need not get there.
void ContactSearch::put_back() {
    for (auto& [index, pair] : replaced_) {
        pairs[index] = std::move(pair);
    }
    replaced_.clear();
    pairs.resize(sorted_pairs_);
}

} // namespace sim
