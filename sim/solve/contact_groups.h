#pragma once
/// Islands that are solved together. Bodies that nothing connects have no part in each other's contacts, so each group is solved
/// until it is done, whatever the others take, and while what it consists of is in the processor's cache; threads need not wait for
/// each other.
#include "sim/solve/joint.h"
#include "sim/solve/resting_contacts.h"

#include <deque>

namespace sim {

struct ContactSolveReport {
    int iterations = 0;
    double residual = 0.0;       ///< [m] largest gap error at the predicted poses
    double joint_residual = 0.0; ///< [m]
    double work = 0.0;           ///< [J] that contacts do on bodies; the most of a group in which no joint gives energy
    bool converged = true;
};

struct ContactGroup {
    explicit ContactGroup(std::shared_ptr<BlockBodies> of) : contacts(std::move(of)) {}

    RestingContacts contacts;
    std::vector<int> pairs;           ///< ascending; then those that were added
    std::vector<std::size_t> bodies;  ///< that its contacts and joints move
    std::vector<std::size_t> changed; ///< of them, those that the uncertain share of the guess moves
    std::vector<int> assemblies;      ///< of joints
    bool is_begun = false;     ///< its contacts are in blocks
    bool is_wedged = false;    ///< loaded contacts could not part as they were asked to
    bool is_due = true;        ///< it is to be solved, or solved again
    double given_way = 0.0;    ///< [m] the most that its contacts are asked for less, as no motion gives it
    int sweeps = 0;            ///< of all its solves of the interval
    double settled = 0.0;      ///< [m/s] change that it may leave in any case
    double enough = 0.0;       ///< [m/s] change that ends the sweeps; 0 until the first one of the interval
    ContactSolveReport report; ///< of its last solve
};

/// Those of a plan. Keep their arrays between steps.
class ContactGroups {
public:
    ContactGroups() { groups_.emplace_back(block_bodies_); }

    /// Groups of islands: one of each that has joints, whose equations take longer than its visits, then those of the others, in the
    /// order of their first pairs. solved: bodies in contacts or joints, ascending.
    void form(const Bodies& bodies, const std::vector<PairContacts>& pairs, const JointSolver& joints,
              std::span<const std::size_t> solved, Workers* workers);

    /// See RestingContacts. Groups that they connect become one.
    void add(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::span<const int> added, std::span<const Velocity> at_node,
             Prediction& to);
    void drop(const Bodies& bodies, const std::vector<PairContacts>& pairs, int pair, Prediction& to);

    /// Calls work(group) for those of which is_one(group) is true. Threads share the loops of each of the large ones; of the others,
    /// whose loops end sooner than another thread has what it needs of them, each takes some.
    template <typename IsOne, typename Work>
    void for_each(Workers* workers, IsOne&& is_one, Work&& work) {
        std::vector<ContactGroup*> together;
        std::vector<ContactGroup*> apart;
        for (ContactGroup& group : groups_) {
            if (is_one(group)) {
                (is_large(group) ? together : apart).push_back(&group);
            }
        }
        for (ContactGroup* group : together) {
            group->contacts.loop.workers = workers;
            work(*group);
        }
        const auto work_on = [&](std::size_t first, std::size_t last) {
            for (ContactGroup* group : std::span(apart).subspan(first, last - first)) {
                group->contacts.loop.workers = nullptr;
                work(*group);
                group->contacts.loop.workers = workers;
            }
        };
        share(workers, apart.size(), work_on, 1);
    }

    BlockBodies& block_bodies() { return *block_bodies_; }
    const BlockBodies& block_bodies() const { return *block_bodies_; }
    /// Once all are solved.
    void count_sweeps();

    auto begin() { return groups_.begin(); }
    auto end() { return groups_.end(); }
    auto begin() const { return groups_.begin(); }
    auto end() const { return groups_.end(); }
    ContactGroup& front() { return groups_.front(); } ///< there is one, and it stays where it is

private:
    static bool is_large(const ContactGroup& group);
    void begin_group(std::size_t index);
    void find_islands(const Bodies& bodies, const std::vector<PairContacts>& pairs, const JointSolver& joints,
                      std::span<const std::size_t> solved);
    std::size_t group_of(const PairContacts& pair) const;
    void join(const Bodies& bodies, const std::vector<PairContacts>& pairs, std::pair<std::size_t, std::size_t> both,
              std::span<const int> added, Prediction& to);

    std::shared_ptr<BlockBodies> block_bodies_ = std::make_shared<BlockBodies>();
    std::deque<ContactGroup> groups_;
    std::vector<int> group_of_;     ///< [body_count] of bodies in contacts or joints that these move; else -1
    // Of form():
    std::vector<int> first_of_;     ///< [body_count] of the body's island; -1: it does not move
    std::vector<int> size_;         ///< [body_count] pairs of the island of which it is the first
    std::vector<int> mover_;        ///< [pairs] a body of the pair that moves
};

} // namespace sim
