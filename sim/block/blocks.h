#pragma once
/// The contacts of one solve, in batches of eight blocks: the iteration that collisions and resting contacts share.
/// What differs, the target velocities, is set by collision_solver and contact_solver.
///
/// A block is the contacts of one pair of surfaces with a common normal, solved together. Bender & Schmitt visit contact
/// by contact. Four corners under a face are redundant there: the loop converges slowly to one of many answers, which
/// depends on the order. The two bodies of a block move relative to each other with a twist (u, w) of six numbers, and its
/// impulses act as a wrench (P, L) on it, so a block has at most six equations however many corners it has. Solved as such,
/// the answer is unique: normal impulses are the smallest that do it (linear over the face), friction is shared in
/// proportion to them, and symmetry is kept. The equations stand in visit.h, those of all
/// loaded contacts of an island at once in newton.h; sweeps over the blocks are projected Gauss-Seidel.
#include "sim/base/step_report.h"
#include "sim/base/workers.h"
#include "sim/block/batch.h"
#include "sim/block/extrapolation.h"
#include "sim/block/joint_equations.h"
#include "sim/block/newton.h"
#include "sim/collide/manifold.h"
#include "sim/model/motion.h"

#include <Eigen/Core>

#include <array>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace sim {

using Vec2 = Eigen::Vector2d;
using Vec6 = Eigen::Matrix<double, 6, 1>;

/// A body that is moved by keys.
struct KinematicBody {
    std::size_t index = 0;
    Motion motion;
};

/// State of all bodies at one instant, arrays of [body_count].
struct Bodies {
    std::vector<BodyProps> props;
    std::vector<Pose> pose;
    std::vector<Velocity> velocity;
    std::vector<Mat3> inverse_inertia; ///< world frame, at `pose`
    std::vector<KinematicBody> kinematic; ///< those of them
    double time = 0.0;                 ///< [s] of the instant
};

/// Velocities of the kinematic ones, the others at rest [body_count].
std::vector<Velocity> kinematic_velocity(const Bodies& bodies);

/// Restitution and friction coefficients of a pair [-].
struct PairMaterial {
    double restitution = 0.0;
    double mu_s = 0.0;
    double mu_d = 0.0;
};
/// A value unset on one body is the partner's; set on both: geometric mean; on none: zero.
PairMaterial pair_material(const BodyProps& a, const BodyProps& b);

/// Contacts of two bodies with one normal, solved together.
struct Block {
    int a = -1;
    int b = -1;
    int first = 0; ///< index of its first contact
    int count = 0; ///< [-] 1..block_size; 0: taken out of the solve
    int pair = -1; ///< index of its pair
    int lane = -1; ///< where it lies: lane_count * batch + lane
    double mu_s = 0.0;
    double mu_d = 0.0;

    bool has_friction() const { return mu_s > 0.0; }
};

/// The frame of a block in a lane, for what is done block by block.
struct LaneFrame {
    int a = -1;
    int b = -1;
    Vec3 r_a = Vec3::Zero(); ///< block's centre on a from the centre of mass [m]
    Vec3 r_b = Vec3::Zero();
    Mat3 frame = Mat3::Identity(); ///< columns t_1, t_2, n

    LaneFrame(const BlockBatch& batch, std::size_t lane);
    /// Relative twist (u at the block's centre, w) in the block's frame [m/s], [rad/s].
    Vec6 relative_twist(std::span<const Velocity> velocity) const;
    /// Adds the wrench (P, L) [N s], [N m s], given in the block's frame, to both bodies.
    void apply(const Vec6& wrench, const Bodies& bodies, std::span<Velocity> velocity) const;
};

/// One point of a block in a lane; see BatchPoint. Vectors of two are in the tangents of its block.
struct LanePoint {
    double x = 0.0; ///< [m]
    double y = 0.0; ///< [m]
    double p_n = 0.0;
    Vec2 p_t = Vec2::Zero();

    LanePoint(const BatchPoint& point, std::size_t lane)
        : x(point.x.x[lane]), y(point.y.x[lane]), p_n(point.p_n.x[lane]),
          p_t(point.p_t[0].x[lane], point.p_t[1].x[lane]) {}
    double normal_velocity(const Vec6& twist) const { return twist[2] + twist[3] * y - twist[4] * x; }
    Vec2 tangential_velocity(const Vec6& twist) const { return {twist[0] - twist[5] * y, twist[1] + twist[5] * x}; }
    /// The wrench of its impulse sums, in the block's frame.
    Vec6 wrench() const;
};

/// Work [J] that kinematic bodies and motors do by the impulses of an instant.
struct DriveWork {
    double all = 0.0;
    double ahead = 0.0; ///< of it, what acts after the instant
};

/// Loops over fewer blocks, pairs or bodies are not worth while to be shared among threads.
inline constexpr std::size_t least_shared = 32;

/// Blocks are passed over while velocities at their points changed by no more than this share [-] of the iteration's tolerance,
/// or of the change of the sweep before if that is smaller.
inline constexpr double skip_share = 0.3;

/// So many sweeps [-] settle what is easy. After them Newton's method and extrapolation begin; where as many more do not halve the
/// least change of those before, they stall. By trial with the funnel, dominoes and rubble.
inline constexpr int plain_sweeps = 12;

/// Sweeps [-] between two steps of Newton's method: enough to find out who carries load.
inline constexpr int newton_period = 4;

/// Rounds [-] of what is repeated until it is right, where nothing proves that it ends: linear solves at predicted poses, changes
/// of marks, repairs, the time of an impact, the first mode of joints.
inline constexpr int most_rounds = 12;

/// Softness begins with this share [-] of a response: see Blocks.
inline constexpr double least_softness = 1e-3;

/// Looking for contacts and arranging them counts as so many sweeps [-] where work is bounded.
inline constexpr int sweeps_to_arrange = 10;

/// Where sweeps stall each of them lets pass this share [-] of the gap tolerance over the step: what never settles comes to an end.
/// By trial with stacks, dominoes, and chains in a tub.
inline constexpr double stall_share = 1e-4;

/// What solves know of bodies, arrays of [body_count]. Those that move no body in common use one side by side.
struct BlockBodies {
    std::vector<BodyRows> rows;         ///< of bodies in blocks, as the interval begins
    std::vector<std::uint64_t> colours; ///< bit k: a block of colour k moves it
    std::vector<char> swept;            ///< [bool] one sweep was not enough for its group in the last interval
    std::vector<NewtonWait> waits;      ///< of its island
    std::vector<char> wedged;           ///< [bool] in the last interval loaded contacts of its group could not part as asked
    std::vector<int> place;             ///< -1; of an island that is looked at, where the body is among its bodies

    /// Writes the rows of these bodies.
    void begin(const Bodies& bodies, std::span<const std::size_t> which, Workers* workers);
};

/// All blocks of one solve, and the batches in which they are solved.
class Blocks {
public:
    explicit Blocks(std::shared_ptr<BlockBodies> bodies = std::make_shared<BlockBodies>()) : bodies_(std::move(bodies)) {}

    std::vector<Block> blocks;
    std::vector<const Contact*> contacts; ///< of the blocks; they stay where they are during the solve
    std::vector<BlockBatch> batches;
    std::vector<BatchPoint> points; ///< of the batches
    Workers* workers = nullptr;     ///< share what is done block by block; null: this thread does all
    bool may_give_way = false;      ///< see softness()
    JointEquations* joints = nullptr; ///< of bodies in blocks; null: there are none

    /// Room for so many blocks and contacts, which are to be written; no batches.
    void clear(std::size_t block_count = 0, std::size_t contact_count = 0);
    bool empty() const { return blocks.empty(); }
    std::span<const Contact* const> contacts_of(const Block& block) const {
        return std::span(contacts).subspan(static_cast<std::size_t>(block.first), static_cast<std::size_t>(block.count));
    }
    BlockBatch& batch_of(const Block& block) { return batches[static_cast<std::size_t>(block.lane) / lane_count]; }
    const BlockBatch& batch_of(const Block& block) const { return batches[static_cast<std::size_t>(block.lane) / lane_count]; }
    static std::size_t lane_of(const Block& block) { return static_cast<std::size_t>(block.lane) % lane_count; }
    /// The points of a batch.
    std::span<BatchPoint> points_of(const BlockBatch& batch) {
        return std::span(points).subspan(static_cast<std::size_t>(batch.first), static_cast<std::size_t>(batch.count));
    }
    std::span<const BatchPoint> points_of(const BlockBatch& batch) const {
        return std::span(points).subspan(static_cast<std::size_t>(batch.first), static_cast<std::size_t>(batch.count));
    }

    /// Writes the blocks of a pair whose contacts are contacts[first] to contacts[last - 1], block_count() of them. to: a
    /// range of `blocks`; like: bodies, pair and friction.
    void split(std::span<Block> to, std::size_t first, std::size_t last, const Block& like);
    /// Adds them; its contacts are those from `first` on.
    void add(std::size_t first, const Block& like);

    /// Room for batches of the blocks from `first_block` on, of whose bodies the rows are there. They are to be filled; returns
    /// the first of them.
    std::size_t lay_out(const Bodies& bodies, std::size_t first_block);
    /// Indices of the blocks of batch i.
    std::span<const int> blocks_in(std::size_t i) const;
    /// Puts into batch i its blocks, and what does not change while it is iterated; impulses are zero, targets unset. velocity:
    /// before any impulse of this solve.
    void fill_batch(std::size_t i, const Bodies& bodies, std::span<const Velocity> velocity);
    /// All of that.
    void arrange(const Bodies& bodies, std::size_t first_block, std::span<const Velocity> velocity);

    /// Takes a block out of the solve, with its impulses.
    void drop(Block& block, const Bodies& bodies, std::span<Velocity> velocity);

    /// Calls work(first, last) for ranges that cover 0..count once; for one if there are fewer than `least`.
    template <typename Work>
    void share(std::size_t count, Work&& work, std::size_t least = least_shared) const {
        sim::share(workers, count, work, least);
    }

    /// Calls work(first, last) for ranges of batches from `first_batch` on, colour after colour.
    template <typename Work>
    void share_colours(Work&& work, std::size_t first_batch = 0) const {
        std::size_t begin = 0;
        for (const std::size_t end : colours_) {
            if (begin >= first_batch) {
                share(
                    end - begin, [&](std::size_t first, std::size_t last) { work(begin + first, begin + last); },
                    least_shared / lane_count);
            }
            begin = end;
        }
    }

    /// The same for ranges in any order. Each thread gets of every colour what it gets in share_colours(), and has in its cache.
    template <typename Work>
    void share_batches(Work&& work) const {
        const std::size_t parts = workers == nullptr ? 1 : workers->thread_count() * Workers::most_ranges;
        const auto work_on_parts = [&](std::size_t first, std::size_t last) {
            std::size_t begin = 0;
            for (const std::size_t end : colours_) {
                const std::size_t count = end - begin;
                work(begin + count * first / parts, begin + count * last / parts);
                begin = end;
            }
        };
        share(parts, work_on_parts, batches.size() < least_shared ? parts : 1);
    }

    /// [body_count] of the bodies in blocks, as the interval begins.
    std::span<const BodyRows> rows() const { return bodies_->rows; }

    /// Writes the rows of bodies that joints connect with those in blocks.
    void add_rows(const Bodies& bodies, std::span<const std::size_t> which) { bodies_->begin(bodies, which, workers); }

    /// Before the first sweep of a solve, which may spend so much: all blocks are to be solved again.
    void wake(int budget = std::numeric_limits<int>::max());
    /// Sweeps [-] since then.
    int sweeps() const { return sweeps_; }
    /// The same; a step of Newton's method counts as the sweeps that it costs.
    int spent() const { return sweeps_ + static_cast<int>(newton_cost_); }

    /// One iteration over all batches; returns the largest velocity change at any point [m/s]. A batch at whose points
    /// velocities changed by no more than `skip` [m/s] since it was last solved is passed over. tolerance: see BatchSweep. After
    /// some sweeps the impulses are extrapolated, and what changed by more than `large` [m/s] is visited again; where they stall,
    /// every second sweep takes half of what its visits find, and impulses give way if they may. close_joints: of bodies in blocks,
    /// before the visits.
    double sweep(std::span<Velocity> velocity, double skip, double tolerance,
                 double large = std::numeric_limits<double>::infinity(), const std::function<void()>& close_joints = {});

    /// Have the last sweeps brought nothing any more? Rigid bodies held by more contacts than they need may ask for what no
    /// impulses give, and then sweeps go on for ever at some small change.
    bool stalls() const { return stalls_; }
    /// Share [-] of the gap tolerance over the step by which velocities may still change then.
    double let_pass() const { return stalls_ ? stall_share * sweeps_ : 0.0; }

    /// Share [-] of their response by which normal impulses on led bodies (BodyProps::is_led) give way. What no motion gives, as of
    /// bodies between two that close in on them, is else asked for by ever larger impulses. Where they may, it is doubled from the
    /// first stall on every `plain_sweeps`, so that they come to an end.
    double softness() const { return softness_; }
    bool gives_way() const { return softness_ > 0.0; }

    /// Bodies [-] that contacts connect with those of a block.
    int island_size(const Block& block);

    /// Where the last sweep changed most.
    Unsettled least_settled();

private:
    struct Place {
        int colour;
        int count;
        int block;
    };
    /// A batch that is to be filled.
    struct PlannedBatch {
        std::size_t first = 0;       ///< in order_, of its blocks
        std::size_t lanes = 0;       ///< that hold one
        std::size_t first_point = 0;
        int count = 0; ///< points of a lane
    };
    /// The bodies of the blocks from `first_block` on for which is_one(body) is true, each once. Those that do not move may be of
    /// other solves, too, which look at theirs meanwhile.
    template <typename IsOne>
    void find_members(std::size_t first_block, IsOne&& is_one) {
        std::vector<int>& place = bodies_->place;
        members_.clear();
        for (const Block& block : std::span(blocks).subspan(first_block)) {
            for (const int of_block : {block.a, block.b}) {
                const auto body = static_cast<std::size_t>(of_block);
                if (block.count > 0 && is_one(body) && std::exchange(place[body], 0) < 0) {
                    members_.push_back(body);
                }
            }
        }
        for (const std::size_t body : members_) {
            place[body] = -1;
        }
    }
    std::vector<std::array<std::size_t, 2>> connected(std::span<const int> assemblies) const;
    std::vector<Place> coloured(const Bodies& bodies, std::size_t first_block);
    void plan_batches(std::span<const Place> places);
    void extrapolate(std::span<Velocity> velocity);
    void visit_again(const BatchSweep& like, double large);
    void find_islands();
    void solve_stalled(std::span<Velocity> velocity, double skip, const std::function<void()>& close_joints);
    void begin_wait(Island& island) const;
    void set_wait(Island& island, bool was_in_vain);
    double largest_change(const Island& island) const;
    void hold(const Island& island);

    std::shared_ptr<BlockBodies> bodies_;
    std::vector<int> order_;            ///< of the blocks in the batches
    std::vector<PlannedBatch> planned_; ///< [batches]
    std::vector<std::size_t> members_;  ///< see find_members()
    std::vector<std::size_t> colours_; ///< ends of the ranges of batches of which no two move the same body
    std::vector<ExtrapolatedPoint> extrapolated_; ///< [points]
    std::vector<std::size_t> again_;    ///< memory of visit_again()
    std::vector<StepParts> parts_;      ///< [batches] of the last step
    double change_ = 0.0;               ///< [m/s] by the last sweep
    double change_before_ = 0.0;        ///< [m/s] by the one before
    int budget_ = 0;                    ///< [-] of spent()
    int sweeps_ = 0;                    ///< since wake()
    double newton_cost_ = 0.0;          ///< [-] since then, in sweeps
    double least_change_ = 0.0;         ///< [m/s] of the last plain_sweeps, so far
    double progress_ = 0.0;             ///< [m/s] the same of those before
    bool stalls_ = false;
    double softness_ = 0.0; ///< [-]
    std::vector<Island> islands_;       ///< once asked for
    IslandNewton newton_;
    Extrapolation extrapolation_;
};

inline Vec3 vector_in_lane(const Lanes* from, std::size_t lane) {
    return {from[0].x[lane], from[1].x[lane], from[2].x[lane]};
}

/// Number of blocks that contacts make: a new one begins where the normal changes.
std::size_t block_count(std::span<const Contact> contacts);
std::size_t block_count(std::span<const Contact* const> contacts);

} // namespace sim
