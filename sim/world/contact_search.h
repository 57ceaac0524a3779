#pragma once
/// The pairs of bodies that have contacts, and what is remembered of them from step to step.
#include "sim/solve/contact_memory.h"
#include "sim/world/pair_distances.h"

#include <utility>

namespace sim {

class ContactSearch {
public:
    /// The first `count` of the bodies are searched for; `bodies` and `settings` stay where they are. jointed: pairs that do
    /// not collide, ascending.
    ContactSearch(const Bodies& bodies, std::size_t count, const StepSettings& settings, std::vector<BodyPair> jointed,
                  Workers& workers);

    Candidates candidates;
    PairDistances distances;
    std::vector<PairContacts> pairs; ///< ascending; then those that repair added

    /// Pairs and contacts at the present poses, out of the candidates there; with what is remembered of them.
    void find();

    /// Before what pair `index` remembers changes; a new one has nothing to keep.
    void keep(std::size_t index);
    /// Other contacts of a candidate, as repair finds them: into the pair it has, or a new one. Returns its index.
    std::size_t put(const BodyPair& pair, std::span<const FoundContact> contacts);
    /// Index of a pair in `pairs`; pairs.size() if it has no contacts.
    std::size_t index_of(const BodyPair& pair) const;
    /// Undoes all of that.
    void put_back();

private:
    void take_known(std::size_t first, std::size_t last, std::vector<PairContacts>& found);
    void find_contacts_of(const Candidate& candidate, const FaceCorners& corners, std::vector<FoundContact>& contacts,
                          PairContacts& pair);

    const Bodies& bodies_;
    Workers& workers_;
    std::span<const std::uint32_t> near_; ///< candidates
    std::size_t sorted_pairs_ = 0; ///< length of the ascending part
    std::vector<std::pair<std::size_t, PairContacts>> replaced_; ///< by keep(): index into pairs, and what was there
};

} // namespace sim
