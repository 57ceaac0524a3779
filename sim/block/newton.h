#pragma once
/// Where sweeps stall: the equations of all loaded contacts of an island at once. Sweeps carry news from body to body, one
/// block a visit, so a tower needs about as many as the square of its height. But after a few of them it is known which
/// points carry load and which blocks stick: with that active set eq. 1 and eq. 5 are linear equations, which one sparse
/// factorisation solves. Points that would pull leave the set, others that would approach enter it, blocks whose friction would
/// exceed its limit slide, and the new set is solved, until it stays (semi-smooth Newton; Alart & Curnier 1991, "A mixed
/// formulation for frictional contact problems prone to Newton like solution methods"). What sticks again the sweeps that follow
/// find.
#include "sim/model/body.h"
#include "sim/block/batch.h"
#include "sim/block/body_factors.h"

#include <span>
#include <vector>

namespace sim {

class Blocks;
struct BlockBodies;
struct LanePoint;

/// Added to the diagonal of each equation, as a share [-] of the response that its block would have with the island's heaviest
/// body in place of its lighter one: light bodies do not sink under a heavy one. Solutions with these equations precondition
/// those without. The response of n stacked boxes to what bends them is some n^-4 of a block's: what lies far below this share
/// solutions hardly find.
inline constexpr double compliance = 1e-9;

/// Sweeps [-] for which Newton's method is not used after a step that was in vain; none after one that helped.
struct NewtonWait {
    float whole = 0.0f; ///< from that step on
    float left = 0.0f;  ///< of them, in the solves to come
};

/// Dynamic bodies that contacts and joints connect, and the blocks between them.
struct Island {
    std::vector<int> bodies; ///< ascending
    std::vector<int> blocks; ///< ascending
    std::vector<int> assemblies; ///< of joints, ascending

    NewtonWait wait;      ///< as the solve began
    double cost = 0.0;    ///< [-] of the last step, in visits of a block: products of two bodies' equations
    double in_vain = 0.0; ///< [-] sweeps of the island that steps of this solve cost since the last that was not in vain
    bool is_served = false;      ///< by steps of this solve, none of them known to be in vain
    bool resists = false;        ///< one was: left to sweeps
    bool is_extrapolated = true; ///< else it is served, or was done when it was looked at last
    double change = 0.0;         ///< [m/s] largest of a visit before the last step
};

/// Active sets [-] of one step, each with a factorisation: a tower of 250 boxes needs more than 12. What needs more than these may take
/// turns.
inline constexpr int newton_rounds = 24;

/// Of a step of Newton's method.
struct NewtonLimits {
    double cost = 0.0;  ///< [-] the most that it may cost, in visits of a block
    double least = 0.0; ///< [m/s] what a point may miss without a load
};

/// Share [-] of an island's load in points whose friction is at its limit: they slide.
double sliding_share(const Blocks& loop, const Island& island);

class IslandNewton {
public:
    /// One step of Newton's method for an island: its impulses and the velocities of its bodies change. Sliding friction is held.
    /// Counts what it costs. Joints are closed before and after. Returns false where the active set does not settle, or misses more than
    /// 1 / `compliance` of what the first one did (`law_dominoes.a_row_that_lies...`), or what the sweeps minimise grows: all stays as it
    /// was then, for impulses that hold bodies against each other may be any.
    bool step(Blocks& loop, Island& island, BlockBodies& bodies, std::span<Velocity> velocity, const NewtonLimits& limits);

private:
    /// An equation of a block: a velocity that is to reach its target.
    struct Row {
        Eigen::Matrix<double, 6, 1> twist; ///< its coefficients of the block's relative twist
        Eigen::Matrix<double, 6, 1> of_a;  ///< and of the velocity of body a, b
        Eigen::Matrix<double, 6, 1> of_b;
        double compliance = 0.0;           ///< [1/kg], [1/(kg m^2)]
        double missing = 0.0;              ///< [m/s], [rad/s]
        double impulse = 0.0;              ///< found [N s], [N m s]
    };
    /// Impulses of the rows, and what velocity they give them.
    struct Direction {
        Eigen::VectorXd impulse;
        Eigen::VectorXd moved;
    };
    /// The equations of a block.
    struct Active {
        int block = -1;
        std::size_t first = 0; ///< of its rows
        int normal_rows = 0;
        int friction_rows = 0; ///< 0: it slides, or has none
        double count = 0.0;    ///< loaded points
        Eigen::Vector2d centre;   ///< of the loaded points [m]
        Eigen::Matrix2d axes;     ///< columns: along which they spread
        Eigen::Vector2d moments;  ///< about these axes [m^2]
        double load = 0.0;        ///< [N s]
        Eigen::Vector2d pressure; ///< centre of the load [m]
        double turning = 0.0;     ///< moment of the load about it [N s m^2]
    };
    /// Of a point; along t_1, t_2, n.
    struct PointState {
        Vec3 impulse = Vec3::Zero(); ///< [N s]
        Vec3 missed = Vec3::Zero();  ///< [m/s] velocity beyond its target
    };
    static PointState state_of(const BatchPoint& point, std::size_t lane, const Eigen::Matrix<double, 6, 1>& twist);
    void add_block(const Blocks& loop, int block, double mass_share, std::span<const Velocity> velocity);
    void add_normal_rows(const Blocks& loop, Active& active, const Eigen::Matrix<double, 6, 1>& twist);
    void add_friction_rows(const Blocks& loop, Active& active, const Eigen::Matrix<double, 6, 1>& twist);
    void find_fill(const Blocks& loop, std::span<const int> place, const Island& island);
    bool factorise(const Blocks& loop, std::span<const BodyRows> rows, std::span<const int> place, const Island& island,
                   double heaviest);
    Direction solution(const Blocks& loop, std::span<const int> place, const Island& island, const Eigen::VectorXd& missing);
    double missing_square() const;
    void find_impulses(const Blocks& loop, std::span<const int> place, const Island& island, double enough);
    LanePoint found_at(const Active& active, const LanePoint& at) const;
    bool take_found(Blocks& loop, const Active& active, std::span<const BodyRows> rows, std::span<Velocity> velocity) const;
    template <typename F>
    static void for_each_block(Blocks& loop, const Island& island, F&& visit);
    void begin(Blocks& loop, const Island& island, std::span<const Velocity> velocity);
    bool is_nearer(Blocks& loop, const Island& island, std::span<const Velocity> velocity) const;
    void take_back(Blocks& loop, const Island& island, std::span<Velocity> velocity) const;
    void find_loaded(Blocks& loop, const Island& island, std::span<const int> place);
    bool enter_set(Blocks& loop, const Island& island, std::span<const int> place, std::span<const Velocity> velocity, double least) const;

    std::vector<PointState> begun_;        ///< the island's points as a step begins
    std::vector<Velocity> begun_velocity_; ///< and its bodies
    std::vector<char> is_loaded_;          ///< [bool] of these, for enter_set()
    std::vector<Active> active_;
    std::vector<Row> rows_;
    BodyFactors factors_;
};

} // namespace sim
