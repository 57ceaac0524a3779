#include "sim/solve/contact_memory.h"

#include "sim/collide/separating_direction.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

namespace sim {
namespace {

/// A contact that was found again, and the one that it was.
struct Kept {
    ContactMemory* memory;
    const Contact* before;
};

/// What a contact bore that is not found again goes to those left with its normal: linearly, so that force and moment stay, as far as
/// none has to pull. Of all of them the places `before` count, at one instant.
void hand_over(const Contact& lost, std::vector<Kept> left) {
    const double load = lost.memory.p_n;
    std::erase_if(left, [&](const Kept& k) { return k.before->at.n.dot(lost.at.n) < nearly_flat || k.memory->approach_speed > 0.0; });
    if (std::ranges::any_of(left, [](const Kept& k) { return k.memory->p_n > 0.0; })) {
        std::erase_if(left, [](const Kept& k) { return !(k.memory->p_n > 0.0); });
    }
    if (left.empty()) {
        return;
    }
    const auto count = static_cast<double>(left.size());
    Vec3 middle = Vec3::Zero();
    double sum = load;
    for (const Kept& k : left) {
        middle += k.before->at.a / count;
        sum += k.memory->p_n;
    }
    Mat3 spread = Mat3::Zero();
    for (const Kept& k : left) {
        const Vec3 arm = k.before->at.a - middle;
        spread += arm * arm.transpose();
    }
    const Vec3 aside = lost.at.a - middle;
    spread.diagonal().array() += collinear * (spread.trace() + aside.squaredNorm());
    const Vec3 slope = aside.isZero(0.0) ? Vec3::Zero() : Vec3(spread.inverse() * aside);
    const auto next = [&](const Kept& k) {
        return std::max(k.memory->p_n + load * (1.0 / count + slope.dot(k.before->at.a - middle)), 0.0);
    };
    double raised = 0.0; // the sum, where none pulls
    for (const Kept& k : left) {
        raised += next(k);
    }
    for (const Kept& k : left) {
        ContactMemory& to = *k.memory;
        const double p_n = sum / raised * next(k);
        to.p_t += (p_n - to.p_n) * (lost.memory.p_t / load);
        to.p_n = p_n;
        if (to.interval() == 0.0) {
            to.signed_interval = lost.memory.signed_interval;
            to.force_share = lost.memory.force_share;
        }
    }
}

/// How far a contact lies from where one was [m]: by their cores, of a rim's by its point, for its core is the centre.
double distance_of(const Contact& one, const Contact& other) {
    return is_rim(one.kind) || is_rim(other.kind) ? (one.at.a - other.at.a).norm() : (one.core_a - other.core_a).norm();
}

} // namespace

void replace_contacts(PairContacts& pair, std::span<const FoundContact> found) {
    std::vector<Contact> contacts(found.begin(), found.end());
    const std::vector<Contact>& old = pair.manifold.contacts;
    std::vector<std::size_t> lost(old.size()); // indices of those not found again
    std::iota(lost.begin(), lost.end(), std::size_t{0});
    std::vector<std::size_t> added;
    std::vector<Kept> kept;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const auto known = std::ranges::find(lost, contacts[i].id, [&](std::size_t j) { return old[j].id; });
        if (known == lost.end()) {
            added.push_back(i);
        } else {
            contacts[i].memory = old[*known].memory;
            kept.push_back({&contacts[i].memory, &old[*known]});
            lost.erase(known);
        }
    }
    while (!added.empty() && !lost.empty()) {
        double nearest = std::numeric_limits<double>::infinity();
        auto to = added.begin();
        auto from = lost.begin();
        for (auto i = added.begin(); i != added.end(); ++i) {
            for (auto j = lost.begin(); j != lost.end(); ++j) {
                const double distance = distance_of(old[*j], contacts[*i]);
                if (distance < nearest) {
                    nearest = distance;
                    to = i;
                    from = j;
                }
            }
        }
        contacts[*to].memory = old[*from].memory;
        kept.push_back({&contacts[*to].memory, &old[*from]});
        added.erase(to);
        lost.erase(from);
    }
    for (const std::size_t j : lost) {
        if (old[j].memory.p_n > 0.0) {
            hand_over(old[j], kept);
        }
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
