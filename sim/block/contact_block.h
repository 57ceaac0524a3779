#pragma once
/// The iteration loop that collisions and resting contacts share. Its unit is a block: the contacts of one
/// pair of surfaces with a common normal, solved together. What differs, the target velocities, is set by
/// collision_solver and contact_solver.
///
/// Bender & Schmitt visit contact by contact. Four corners under a face are redundant there: the loop
/// converges slowly to one of many answers, which depends on the order. The two bodies of a block move
/// relative to each other with a twist (u, w) of six numbers, and its impulses act as a wrench (P, L) on it,
/// so a block has at most six equations however many corners it has. Solved as such, the answer is unique:
/// normal impulses are the smallest that do it (linear over the face), friction is shared in proportion to
/// them, and symmetry is kept.
#include "sim/base/workers.h"
#include "sim/block/batch.h"
#include "sim/block/impulse.h"
#include "sim/block/momentum.h"
#include "sim/collide/manifold.h"

#include <array>
#include <span>
#include <vector>

namespace sim {

/// State of all bodies at one instant, arrays of [body_count].
struct Bodies {
    std::vector<BodyProps> props;
    std::vector<Pose> pose;
    std::vector<Velocity> velocity;
    std::vector<Mat3> inverse_inertia; ///< world frame, at `pose`
};

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// Most contacts in one block: a face of a box clipped by another has at most eight corners, and a crossing
/// of edges.
inline constexpr int block_size = 9;

/// One contact in the loop. Vectors of two are in the tangents of its block.
struct ContactPoint {
    double x = 0.0;                 ///< [m] in the contact plane, from the block's centre
    double y = 0.0;                 ///< [m]
    double u_n_target = 0.0;        ///< [m/s]
    Vec2 u_t_target = Vec2::Zero(); ///< of a sticking contact [m/s]
    double p_n = 0.0;               ///< sum of the normal impulses [N s]
    Vec2 p_t = Vec2::Zero();        ///< sum of the friction impulses [N s]
};

/// Contacts of two bodies with one normal, solved together. The block's frame: t_1, t_2, n at the mean
/// contact point.
struct ContactBlock {
    int a = -1;
    int b = -1;
    int first = 0; ///< index of its first point
    int count = 0; ///< [-] 1..block_size
    double mu_s = 0.0;
    double mu_d = 0.0;
    /// Share [-] of the impulses at which the sliding direction is taken: of a step's impulses the part that
    /// acts before t0; 1 (the velocity after) in a collision, where sticking and sliding are then one law.
    double node_weight = 1.0;
    bool is_sticking = false; ///< the mark of eq. 6
    bool is_flat = false;     ///< a face against points: its gaps are linear in small changes of velocity
    bool is_face_of_a = false; ///< then: whose face
    Vec3 r_a = Vec3::Zero();  ///< middle of the contacts on a from its centre of mass [m]
    Vec3 r_b = Vec3::Zero();
    Mat3 frame = Mat3::Identity(); ///< columns t_1, t_2, n
    Vec3 twist_before = Vec3::Zero(); ///< u_1, u_2 [m/s], w_n [rad/s] before any impulse of this solve

    bool has_friction() const { return mu_s > 0.0; }
    /// Sets is_flat and is_face_of_a by the feature of its first contact.
    void set_surface(const ContactFeature& feature) {
        is_face_of_a = feature.kind == FeatureKind::face_a;
        is_flat = (is_face_of_a || feature.kind == FeatureKind::face_b) && !is_curved(feature);
    }
};

/// How a block's relative twist answers to impulses.
struct BlockResponse {
    Mat6 twist = Mat6::Zero(); ///< by a unit wrench, in the block's frame (K and its angular parts)
    double k_t = 0.0;          ///< [1/kg] largest eigenvalue of K_tt over the points
};

/// Restitution and friction coefficients of a pair.
struct PairMaterial {
    double restitution = 0.0;
    double mu_s = 0.0;
    double mu_d = 0.0;
};
/// A value unset on one body is the partner's; set on both: geometric mean; on none: zero.
PairMaterial pair_material(const BodyProps& a, const BodyProps& b);

/// Loops over fewer blocks, pairs or bodies are not worth while to be shared among threads.
inline constexpr std::size_t least_shared = 32;

/// With fewer batches of a colour it is not worth while to share them among threads.
inline constexpr std::size_t least_batches = 4;

/// Sweeps of a solve over batches [-] before any is carried on. With 10 the funnel's impacts take a few less, with 6 rows
/// of fallen dominoes many more.
inline constexpr int plain_sweeps = 14;

/// Projections within one friction solve, at most [-]: more gain little, the loop over the blocks goes on anyway.
inline constexpr int most_projections = 2;

/// A tolerance of velocities up to here [m/s] is not loose.
inline constexpr double tight_velocity_tolerance = 5e-5;

/// The same in a sweep over batches, counted from 0, of a solve to `tolerance` [m/s], which the sweep before missed by
/// changes of `last` [m/s]. The first sweeps to a loose tolerance bring what changed since the last step, roughly. With one
/// projection beyond that some piles do not come to rest, some blocks of many points go in circles, and with a tight
/// tolerance fallen dominoes take twice as long.
inline int projections_in(int sweep, double last, double tolerance) {
    constexpr int quick_sweeps = 8;
    return sweep < quick_sweeps && last > tolerance && tolerance > tight_velocity_tolerance ? 1 : most_projections;
}

/// Sweep of a solve over batches [-] after which none is carried on: in a row of 200 fallen dominoes the momentum that
/// has not led to the end by then goes in circles.
inline constexpr int last_carried = 600;

/// All blocks of one solve, in the order they are visited, and their points.
struct ContactBlocks {
    std::vector<ContactBlock> blocks;
    std::vector<ContactPoint> points;

    Workers* workers = nullptr; ///< share what is done block by block; null: this thread does all

    std::vector<BlockBatch> batches; ///< the same blocks in lanes, once arranged
    std::vector<BatchPoint> batch_points;
    std::vector<std::size_t> colours; ///< ends of the ranges of batches of which no two move the same body
    std::vector<double> activity; ///< [body_count] of those in blocks: sum of the velocity changes of their blocks [m/s]

    void clear() {
        blocks.clear();
        points.clear();
    }
    bool empty() const { return blocks.empty(); }

    /// The points of a block.
    std::span<ContactPoint> points_of(const ContactBlock& block) {
        return std::span(points).subspan(static_cast<std::size_t>(block.first),
                                         static_cast<std::size_t>(block.count));
    }
    std::span<const ContactPoint> points_of(const ContactBlock& block) const {
        return std::span(points).subspan(static_cast<std::size_t>(block.first),
                                         static_cast<std::size_t>(block.count));
    }

    /// Adds the contacts of one pair, in their order; a new block begins where the normal changes.
    /// Impulses are zero, targets unset.
    void append(const Bodies& bodies, int a, int b, std::span<const ContactGeometry> contacts,
                const PairMaterial& material);

    /// The same into blocks and points that are there already, from these indices on.
    void place(std::size_t first_block, std::size_t first_point, const Bodies& bodies, int a, int b,
               std::span<const ContactGeometry> contacts, const PairMaterial& material);

    /// Calls work(first, last) for ranges that cover 0..count once; for one if there are fewer than `least`.
    template <typename Work>
    void share(std::size_t count, Work&& work, std::size_t least = least_shared) const {
        if (workers != nullptr) {
            workers->run(count, work, least);
        } else if (count > 0) {
            work(std::size_t{0}, count);
        }
    }

    /// Sets the batches up for the present blocks, with their responses.
    void arrange(const Bodies& bodies);

    /// The same without what the batches hold: which block is in which lane. Of the blocks a, b and count are known.
    void plan(const Bodies& bodies);

    /// All blocks are to be solved again.
    void wake(const Bodies& bodies);

    /// Calls work(first, last) for ranges of batches that cover all of them, colour after colour.
    template <typename Work>
    void share_colours(Work&& work) const {
        std::size_t begin = 0;
        for (const std::size_t end : colours) {
            share(end - begin, [&](std::size_t first, std::size_t last) { work(begin + first, begin + last); }, least_batches);
            begin = end;
        }
    }

    /// Targets, marks and impulses of blocks and points go into the batches; all blocks are to be solved again.
    void load_batches(const Bodies& bodies);

    /// One iteration over all batches; returns the largest velocity change at any point [m/s]. A batch whose
    /// bodies changed by less than `skip` [m/s] since it was last solved is passed over. slack, projections: see
    /// BatchSweep. After some the impulses are carried on.
    double sweep(std::span<Velocity> velocity, double skip, double slack, int projections);

    /// Impulses of the batches go back into the points.
    void store_impulses();

private:
    void fill_batches(const Bodies& bodies, std::size_t first, std::size_t last);
    void begin_sweeps(const Bodies& bodies);
    void load_batch(BlockBatch& batch);
    void carry_on(std::span<Velocity> velocity);
    void store_batch(const BlockBatch& batch);

    std::vector<CarriedPoint> carried_; ///< [batch_points]
    std::vector<std::uint64_t> used_;   ///< [body_count] bit k: a block of colour k moves it
    std::vector<double> along_;         ///< [batches] see Momentum::next
    double change_ = 0.0;               ///< [m/s] by the last sweep
    Momentum momentum_{plain_sweeps, last_carried};
};

inline Vec3 vector_in_lane(const Lanes* from, std::size_t lane) {
    return {from[0].x[lane], from[1].x[lane], from[2].x[lane]};
}

/// Number of blocks that `append` makes of these contacts.
std::size_t block_count(std::span<const ContactGeometry> contacts);
std::size_t block_count(std::span<const Contact> contacts);
/// Contacts of the first of them.
std::size_t block_length(std::span<const Contact> contacts);

/// Relative twist (u at the block's centre, w) in the block's frame [m/s], [rad/s].
inline Vec6 relative_twist(const ContactBlock& block, std::span<const Velocity> velocity) {
    const Velocity& a = velocity[static_cast<std::size_t>(block.a)];
    const Velocity& b = velocity[static_cast<std::size_t>(block.b)];
    const Vec3 u = a.at(block.r_a) - b.at(block.r_b);
    const Vec3 w = a.w - b.w;
    Vec6 twist;
    for (int i = 0; i < 3; ++i) {
        twist[i] = block.frame.col(i).dot(u);
        twist[3 + i] = block.frame.col(i).dot(w);
    }
    return twist;
}

/// Velocities of a point for a relative twist of its block.
inline double normal_velocity(const ContactPoint& point, const Vec6& twist) {
    return twist[2] + twist[3] * point.y - twist[4] * point.x;
}
inline Vec2 tangential_velocity(const ContactPoint& point, const Vec6& twist) {
    return {twist[0] - twist[5] * point.y, twist[1] + twist[5] * point.x};
}

/// What impulses on the block do; held bodies count as immovable.
BlockResponse block_response(const ContactBlock& block, std::span<const ContactPoint> points, const Bodies& bodies,
                             bool hold_a = false, bool hold_b = false);

/// Adds the wrench (P, L) [N s], [N m s], given in the block's frame, to both bodies.
void apply_wrench(const ContactBlock& block, const Vec6& wrench, std::span<const BodyProps> props,
                  std::span<const Mat3> inverse_inertia, std::span<Velocity> velocity);

/// Tangential velocity of a point before any impulse of this solve.
inline Vec2 tangential_before(const ContactBlock& block, const ContactPoint& point) {
    return {block.twist_before[0] - block.twist_before[2] * point.y,
            block.twist_before[1] + block.twist_before[2] * point.x};
}

/// u_1, u_2, w_n of a twist.
inline Vec3 tangential_part(const Vec6& twist) {
    return {twist[0], twist[1], twist[5]};
}

/// The wrench of one point's impulse sums, in the block's frame.
inline Vec6 wrench_of_point(const ContactPoint& p) {
    Vec6 wrench;
    wrench << p.p_t, p.p_n, p.p_n * p.y, -p.p_n * p.x, p.x * p.p_t.y() - p.y * p.p_t.x();
    return wrench;
}

/// The wrench of the points' impulse sums, in their block's frame.
Vec6 wrench_of(std::span<const ContactPoint> points);

/// Solves one block with all others held: its points' impulse sums change, and the wrench [N s], [N m s] returned is
/// still to be given to its bodies. twist: its relative twist; change: the largest velocity change at a point [m/s].
Vec6 block_wrench(const ContactBlock& block, const BlockResponse& response, std::span<ContactPoint> points, Vec6 twist,
                  double& change, int projections = most_projections);

/// Solves one block with all others held; returns the largest velocity change at a point [m/s].
/// `points`: those of the block. `hold_a`, `hold_b`: that body counts as immovable (shock propagation), in `response`
/// too.
double solve_block(const ContactBlock& block, const BlockResponse& response, std::span<ContactPoint> points,
                   const Bodies& bodies, std::span<Velocity> velocity, int projections = most_projections,
                   bool hold_a = false, bool hold_b = false);

} // namespace sim
