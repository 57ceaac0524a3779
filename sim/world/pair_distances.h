#pragma once
/// How far candidates are apart, at the present poses and at planned ones: what was found is kept while the
/// bodies stay.
#include "sim/base/grow.h"
#include "sim/base/workers.h"
#include "sim/collide/box_pairs.h"
#include "sim/collide/manifold.h"
#include "sim/world/candidates.h"

#include <limits>

namespace sim {

class PairDistances {
public:
    /// The first `count` of the bodies are in candidates; `bodies` stays where it is.
    PairDistances(const Bodies& bodies, std::size_t count, Workers& workers);

    /// Indices of the candidates that may touch within the step, at the present poses.
    std::span<const std::uint32_t> find_near(Candidates& candidates);

    /// Depths of penetration of the candidates at `planned` poses, exact where they exceed `enough` [m]. is_first: of this plan;
    /// later only pairs of bodies that moved since are looked at.
    void check(Candidates& candidates, std::span<const Pose> planned, double enough, bool is_first);
    /// [m] then, and no less than it is below `enough` [m], which may be less.
    double penetration(const Candidate& candidate, std::span<const Pose> planned, double enough);

    /// Corners of the faces [near] of those that are boxes, up to lane_count, after find_near().
    void clip(std::span<const Candidate* const> near, std::span<FaceCorners> corners) const;
    /// Their contacts.
    void find_box_contacts(const Candidate& candidate, const FaceCorners& corners, double margin,
                           std::vector<FoundContact>& contacts) const;
    /// Of others, not both boxes, what was found at the present poses. Without contacts they are looked at again once they may
    /// have come near; with some, along the features that touch first.
    void set_found(const Candidate& candidate, std::span<const FoundContact> contacts);

private:
    template <typename F>
    void place(const Candidates& candidates, std::span<const Pose> poses, F&& is_moved);
    void update_axes(std::span<const Candidate> candidates);
    bool has_moved(const Candidate& candidate) const;
    void look(const Candidate& candidate, std::span<const Pose> poses);
    double least_separation(const Candidate& candidate, std::span<const Pose> poses, double enough);
    bool may_touch(const Candidates& candidates, const Candidate& candidate);

    const Bodies& bodies_;
    Workers& workers_;
    std::vector<char> is_box_;           ///< [count] a single box, not a part of a compound
    std::vector<PlacedBoxRow> box_rows_; ///< [count]
    std::vector<Pose> looked_at_;        ///< [count] poses at which a body's pairs were last looked at
    std::vector<char> moved_;            ///< [count] since then
    std::vector<BoxAxes> axes_;          ///< [slots of boxes]
    /// How far two bodies are apart [m], at least, and at which poses.
    struct Separation {
        double distance = -std::numeric_limits<double>::infinity();
        Pose a;
        Pose b;
        double penetration = 0.0; ///< [m] at the planned poses, by check()
        bool is_exact = false;    ///< where they overlap
        ContactFeature nearest;   ///< features along whose normal they were found so
    };
    std::vector<Separation> separations_; ///< [slots of others] by the last look
    std::vector<std::uint32_t> near_;
};

} // namespace sim
