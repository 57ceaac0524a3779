#include "sim/world/contact_view.h"

namespace sim {

namespace {

/// The solver's own mark tells sticking from sliding only where mu_s and mu_d differ.
bool is_sticking(const ContactMemory& memory, const PairMaterial& material) {
    const double limit = material.mu_s * memory.p_n;
    return memory.is_sticking() && memory.p_t.norm() < (1.0 - same_share) * limit;
}

} // namespace

std::vector<ContactSnapshot> loaded_contacts(std::span<const PairContacts> pairs, double time_step) {
    std::vector<ContactSnapshot> contacts;
    for (const PairContacts& pair : pairs) {
        for (const Contact& contact : pair.manifold.contacts) {
            const ContactMemory& memory = contact.memory;
            if (!(memory.p_n > 0.0)) {
                continue;
            }
            const ContactGeometry& at = contact.at;
            const double share = memory.interval() > 0.0 ? time_step / memory.interval() : 1.0;
            const Vec3 impulse = share * (memory.p_n * at.n + memory.p_t);
            const Vec3 point = at.middle();
            contacts.push_back({{pair.manifold.body_a, pair.manifold.body_b},
                                point.cast<float>(),
                                at.n.cast<float>(),
                                impulse.cast<float>(),
                                is_sticking(memory, pair.material)});
        }
    }
    return contacts;
}

} // namespace sim
