#pragma once
/// How far candidates are apart, at the present poses and at planned ones: what was found is kept while the bodies stay.
#include "sim/base/workers.h"
#include "sim/collide/box_axes.h"
#include "sim/world/candidates.h"

#include <limits>

namespace sim {

class PairDistances {
public:
    /// The first `count` of the bodies are in candidates; `bodies` and `settings` stay where they are.
    PairDistances(const Bodies& bodies, std::size_t count, const StepSettings& settings, Workers& workers);

    /// A pair that may touch within the step.
    struct Near {
        std::size_t candidate = 0;
        double margin = 0.0; ///< [m] see Candidates::margin_of
    };
    /// Those of the candidates at the present poses.
    const std::vector<Near>& find_near(Candidates& candidates);

    /// Depths of penetration of the candidates at `planned` poses. is_first: of this plan; later only pairs of bodies that
    /// moved since are looked at.
    void check(Candidates& candidates, std::span<const Pose> planned, bool is_first);
    /// [m] of the candidate in this slot, then.
    double penetration(std::size_t slot) const { return penetration_[slot]; }

    bool are_boxes(const BodyPair& pair) const {
        return is_box_[static_cast<std::size_t>(pair.a)] != 0 && is_box_[static_cast<std::size_t>(pair.b)] != 0;
    }
    const BoxAxes& axes(std::size_t slot) const { return axes_[slot]; } ///< of boxes
    /// Others, no box and no contact: they are looked at again once they may have come near.
    void set_apart(const Candidate& candidate);

private:
    template <typename F>
    void place(const Candidates& candidates, std::span<const Pose> poses, F&& is_moved);
    void update_axes(std::span<const Candidate> candidates);
    bool has_moved(const Candidate& candidate) const;
    double least_separation(const Candidate& candidate, std::span<const Pose> poses);
    double margin(const Candidates& candidates, const Candidate& candidate);

    const Bodies& bodies_;
    const StepSettings& settings_;
    Workers& workers_;
    std::vector<char> is_box_;           ///< [count] a single box, not a part of a compound
    std::vector<PlacedBoxRow> box_rows_; ///< [count]
    std::vector<Pose> box_pose_;         ///< [count] at which the axes of a body's pairs were found
    std::vector<Pose> checked_pose_;     ///< [count] planned poses when a body's pairs were last looked at
    std::vector<char> moved_;            ///< [count] since then
    std::vector<BoxAxes> axes_;          ///< [slots] of pairs of boxes
    /// A separation [m] that was found, and at which poses.
    struct Separation {
        double distance = -std::numeric_limits<double>::infinity();
        Pose a;
        Pose b;
    };
    std::vector<Separation> separations_; ///< [slots] of other pairs, where the last look found them apart
    std::vector<double> penetration_;     ///< [slots]
    std::vector<double> margin_;          ///< [candidates] see Near; negative: too far apart
    std::vector<Near> near_;
};

} // namespace sim
