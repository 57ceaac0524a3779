#pragma once
/// All overlaps of many bodies at one instant, and what they amount to over a run. Shares no code with sim/.
#include "tests/laws/reference/gap.h"

#include <Eigen/Geometry>

#include <cstddef>
#include <cstdint>
#include <set>
#include <utility>
#include <variant>
#include <vector>

namespace reference {

/// One convex piece of a body. The pose of its shape is relative to the body.
struct Piece {
    std::variant<OrientedBox, Ball, HalfSpace, Polyhedron, Rod> shape;
};

struct Solid {
    std::vector<Piece> pieces; ///< a union; at least one
    bool is_static = false;
};

struct Placement {
    Vector position = Vector::Zero();                                ///< [m]
    Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity(); ///< world from body
};

struct PairGap {
    int a = -1;       ///< index of a body
    int b = -1;       ///< > a
    double gap = 0.0; ///< [m], the deepest over the pieces of both
};

/// The gap [m] of two bodies: the smallest over the pieces of both.
double pair_gap(const Solid& a, const Placement& at_a, const Solid& b, const Placement& at_b);

/// Unordered pairs of bodies that are not compared (a < b), such as those that share a joint.
using ExcludedPairs = std::set<std::pair<int, int>>;

/// All pairs with gap <= margin of which at least one is not static, sorted by (a, b). margin [m] >= 0.
std::vector<PairGap> near_pairs(const std::vector<Solid>& solids, const std::vector<Placement>& placements,
                                double margin, const ExcludedPairs& excluded = {});

/// Bodies whose origin passed through a static body between two instants: their path, taken straight, enters
/// a static box or half space. A solid body of the size of a cube can only do so by leaving through it.
std::vector<int> passed_through(const std::vector<Solid>& solids, const std::vector<Placement>& before,
                                const std::vector<Placement>& after);

/// Collects penetrations (all > 0) and answers for their distribution.
class OverlapStatistics {
public:
    void add(const std::vector<PairGap>& pairs);
    std::size_t count() const { return depths_.size(); }
    /// The q-quantile [m], 0 if there is no overlap. q 0..1; nearest rank.
    double quantile(double q) const;
    double largest() const { return quantile(1.0); }
    /// Fraction of the overlaps that are deeper than `tolerance` [m].
    double share_above(double tolerance) const;
    std::size_t count_above(double tolerance) const;

private:
    std::vector<double> depths_; ///< [m]
};

} // namespace reference
