#pragma once
/// Pairs of bodies that may touch within the next steps. They are searched for several steps at once, in a frame that falls
/// with most bodies; *escaped* bodies, which may leave the box they were given, are searched for again.
#include "sim/block/blocks.h"
#include "sim/collide/broad_phase.h"
#include "sim/model/scene_def.h"

#include <array>
#include <cstdint>

namespace sim {

/// How far a point of the body moves between two poses in a frame that moves by `drift` [m] meanwhile, at most [m].
double moved_by(const BodyProps& props, const Pose& from, const Pose& to, const Vec3& drift);

/// 16 bytes: each step passes over all of them.
struct Candidate {
    BodyPair bodies;
    std::uint32_t slot = 0;  ///< where what is known of them lies, among pairs of boxes or among others
    bool are_boxes = false;  ///< each a single box, not a part of a compound
    bool is_new = true;      ///< nothing is known yet
    bool is_near = false;    ///< they may touch within the step
};
static_assert(sizeof(Candidate) == 16);

class Candidates {
public:
    /// The first `count` of the bodies are searched for; `bodies` and `settings` stay where they are. jointed: pairs that do
    /// not collide, ascending.
    Candidates(const Bodies& bodies, std::size_t count, const StepSettings& settings, std::vector<BodyPair> jointed);
    Candidates(const Candidates&) = delete;
    Candidates& operator=(const Candidates&) = delete;

    /// Those of the next step, at the present poses.
    void find();

    /// And those of bodies that the planned impulses move beyond the reach estimated from their velocities: from the present
    /// poses to `planned` within `interval` [s]. solved: bodies that impulses move.
    void find_thrown(std::span<const std::size_t> solved, std::span<const Pose> planned, double interval);

    /// A body that waited is there, with the next find().
    void release(std::size_t body);

    /// The bodies have moved over `interval` [s].
    void move(double interval);

    std::vector<Candidate>& all() { return all_; } ///< ascending
    const std::vector<Candidate>& all() const { return all_; }
    std::size_t slot_count(bool of_boxes) const { return slots_[of_boxes].count; }
    std::span<const std::size_t> bodies() const { return members_; } ///< those of all pairs, ascending

    /// How near two bodies may be and still touch within the step [m].
    double margin_of(const BodyPair& pair) const;
    /// No less than that, and found sooner [m].
    double farthest(const BodyPair& pair) const;

    /// Where the search stands, for a checkpoint: pairs follow from it, by resume().
    template <typename Archive>
    void exchange(Archive& archive) {
        exchange_of(*this, archive);
    }
    template <typename Archive>
    void exchange(Archive& archive) const {
        exchange_of(*this, archive);
    }
    void resume();

private:
    template <typename Self, typename Archive>
    static void exchange_of(Self& self, Archive& archive) {
        archive(self.frame_);
        archive(self.drift_);
        archive(self.searched_pose_);
        archive(self.searched_reach_);
        archive(self.searched_again_);
    }

    Vec3 drift_in(double t) const;
    void find_reach();
    bool has_escaped(std::size_t i) const;
    bool have_many_escaped() const;
    void search_all();
    void search_escaped();
    double search_reach(std::size_t i) const;
    void set_box(std::size_t i);
    Bounds searched_box(std::size_t i) const;
    void search();
    void add_found();
    bool may_touch(const BodyPair& pair) const;

    const Bodies& bodies_;
    const StepSettings& settings_;
    std::size_t count_ = 0;
    std::vector<BodyPair> jointed_;
    BroadPhase broad_phase_;
    double h_ = 0.0;                     ///< [s] the step
    double fall_ = 0.0;                  ///< [m/s] by gravity within it
    std::vector<double> reach_;          ///< [count] that each body may move in the step, in the frame of the search [m]
    std::vector<double> rim_speed_;      ///< [count] of its outermost point by its rotation [m/s]
    Vec3 frame_ = Vec3::Zero();          ///< velocity of the frame of the search [m/s]
    Vec3 drift_ = Vec3::Zero();          ///< [m] it went since then
    std::vector<Pose> searched_pose_;    ///< [count] in that frame, when each body's pairs were searched for
    std::vector<double> searched_reach_; ///< [count] that each body may be away from there [m]
    std::vector<Bounds> boxes_;          ///< [count] by these
    std::size_t searched_again_ = 0;     ///< bodies, one by one, since all were searched for
    std::vector<int> escaped_;
    std::vector<BodyPair> found_;        ///< by the last search
    std::vector<Candidate> all_;
    struct Slots {
        std::size_t count = 0;
        std::vector<std::uint32_t> free;
    };
    std::array<Slots, 2> slots_; ///< of pairs with another shape, of pairs of boxes
    std::vector<std::size_t> members_;
};

} // namespace sim
