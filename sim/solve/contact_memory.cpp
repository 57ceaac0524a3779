#include "sim/solve/contact_memory.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace sim {

void replace_contacts(PairContacts& pair, std::span<const FoundContact> found) {
    std::vector<Contact> contacts(found.begin(), found.end());
    const std::vector<Contact>& old = pair.manifold.contacts;
    std::vector<std::size_t> lost(old.size()); // indices of those not found again
    std::iota(lost.begin(), lost.end(), std::size_t{0});
    std::vector<std::size_t> added;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const auto known = std::ranges::find(lost, contacts[i].id, [&](std::size_t j) { return old[j].id; });
        if (known == lost.end()) {
            added.push_back(i);
        } else {
            contacts[i].memory = old[*known].memory;
            lost.erase(known);
        }
    }
    while (!added.empty() && !lost.empty()) {
        float nearest = std::numeric_limits<float>::infinity();
        auto to = added.begin();
        auto from = lost.begin();
        for (auto i = added.begin(); i != added.end(); ++i) {
            for (auto j = lost.begin(); j != lost.end(); ++j) {
                const float distance = (old[*j].core_a - contacts[*i].core_a).norm();
                if (distance < nearest) {
                    nearest = distance;
                    to = i;
                    from = j;
                }
            }
        }
        contacts[*to].memory = old[*from].memory;
        added.erase(to);
        lost.erase(from);
    }
    pair.blocks = block_count(contacts);
    pair.manifold.contacts = std::move(contacts);
    pair.manifold.keep_features(found);
}

Block block_like(const PairContacts& pair, int index) {
    Block block;
    block.a = pair.manifold.body_a;
    block.b = pair.manifold.body_b;
    block.pair = index;
    block.mu_s = pair.material.mu_s;
    block.mu_d = pair.material.mu_d;
    return block;
}

void sum_up(PairContacts& pair) {
    pair.least_gap = std::numeric_limits<double>::infinity();
    pair.was_ahead = false;
    pair.is_struck = false;
    // At one point of both bodies, so that the pair's angular momentum is kept.
    pair.owed_impulse.setZero();
    pair.owed_moment.setZero();
    for (const Contact& contact : pair.manifold.contacts) {
        const ContactMemory& memory = contact.memory;
        const ContactGeometry& at = contact.at;
        pair.least_gap = std::min(pair.least_gap, at.gap);
        pair.was_ahead = pair.was_ahead || memory.approach_speed > 0.0;
        if (memory.p_n == 0.0 || memory.last_interval == 0.0) {
            continue;
        }
        const Vec3 p = memory.owed() * (memory.p_n * at.n + memory.p_t);
        pair.owed_impulse += p;
        pair.owed_moment += at.middle().cross(p);
    }
}

} // namespace sim
