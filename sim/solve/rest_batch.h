#pragma once
/// Resting contacts in the batches of block/batch.h: what each knows beside the equations, and what is done with all of
/// them before and after the sweeps. This header knows no library: rest_kernel.cpp is compiled once for each instruction
/// set.
#include "sim/block/batch.h"

namespace sim {

/// Where edges that are nearly parallel touch wanders far with a small turn, and their normal turns with it. Beyond this
/// share [-] of the smaller body the gap is that of the points that touched as the interval began, along its normal
/// then; the check of the planned poses sees what that leaves. It stays so within a solve: a gap that jumps from one to the other
/// meets no target.
inline constexpr double wander_share = 0.02;

/// Point k of each block of a batch, beside its BatchPoint.
struct RestPoint {
    Lanes gap_target; ///< [m] at t0 + h
};

/// A batch, beside its BlockBatch.
struct RestBlock {
    Lanes least_gap;    ///< [m] of the pair as the interval begins: a contact that repair found may overlap there by more
    Lanes load; ///< [N s] that the force of the last step would give in this interval; once stored, how much of p_n is a force
    const double* crossing[lane_count]; ///< of crossing edges a row of their features: direction_a, direction_b
    unsigned edges = 0; ///< bit l: one of its points is of crossing edges
    unsigned plain = 0; ///< bit l: all points but those of crossing edges are fixed to one body, at a face of the other: measured in lanes
    unsigned fresh = 0; ///< bit l: no point of it bore a load in the last interval; it approaches, or a collision reaches it
    unsigned grows = 0; ///< bit l: its impulses exceed by far what its force of the last step, or a weight, would give
    unsigned hit = 0;   ///< bit l: an impact loads it; then, an impact reaches a body of it
    bool is_certain = true; ///< none of the impulses that the solve starts from is uncertain
};

/// Time [s] that the impulses of an interval h stand for: from the middle of the interval before to its own middle.
inline double impulse_interval(double node_weight, double h) {
    return node_weight < 1.0 ? 0.5 * h / (1.0 - node_weight) : h;
}

/// What is the same for all batches.
struct RestRules {
    double h = 0.0; ///< [s]
    double tolerance = 0.0;
    double band = 0.0;               ///< [m] see left_share
    double step_share = 1.0;         ///< h as a share of a whole step [-]
    double velocity_tolerance = 0.0; ///< [m/s]
    double largest_growth = 0.0;
    double limit = 0.0;              ///< [-] friction beyond this share of mu p_n is at its limit
    double slip_tolerance = 0.0;     ///< [m]
    double gravity[3] = {0.0, 0.0, 0.0};
    double weight = 0.0; ///< [m/s^2] its size
    bool warm_start = true;
    bool is_wedged = false; ///< in the last interval loaded overlaps could not part
    bool is_stretched = false; ///< the last solve did not converge, or its interval was shorter
};

/// What a kernel does with a range of batches.
enum class RestPhase {
    start,          ///< gap targets, and impulses of the last interval, which the bodies get
    uncertain,      ///< gives them the uncertain share of the impulses
    uncertain_work, ///< its work against what the others lead to
    impulse_work,   ///< work of all impulses on the bodies
    scale,          ///< keeps a part of it
    hold_overlaps,  ///< what overlaps is asked to part to the tolerance only, and slowly
    give_way,       ///< what softness leaves missing of the gaps is asked for no more; the most of it [m]
    measure, ///< gaps and slips at the predicted poses -> the targets of the velocities; the largest error of a gap [m]; which blocks
             ///< impacts load, and which pass them on
    store    ///< what the contacts hand to the next interval; gives the bodies what acts before t0 of the impulses that are forces
};

struct RestWork {
    RestPhase phase = RestPhase::start;
    BlockBatch* batches = nullptr;
    std::size_t batch_count = 0;
    RestBlock* blocks = nullptr; ///< [batch_count]
    BatchPoint* points = nullptr; ///< all of them
    RestPoint* rest = nullptr;
    const BodyRows* begin = nullptr;   ///< [body_count] as the interval begins
    const BodyRows* end = nullptr;     ///< as predicted at its end
    const double* before = nullptr;    ///< velocities before any impulse, rows as in BatchSweep; for `uncertain_work` without its share
    double* velocity = nullptr;        ///< that impulses act on
    double* at_node = nullptr;         ///< to store: velocities at t0, which get what acts before it
    double* sums = nullptr;            ///< [batch_count] of the two kinds of work [J]; else null
    double kept = 1.0;                 ///< [-] part of it that `scale` keeps
    double pace = 0.0;                 ///< [m/s] for `hold_overlaps`
    double softness = 0.0;             ///< [-] for `give_way`
    /// The rows of the ContactMemory of point k in lane l at [lane_count * k + l], of one batch; to start and to store.
    double* const* memory = nullptr;
    const RestRules* rules = nullptr;
};

/// Returns the largest error of a gap [m] where the phase is to measure, the most that gives way, else 0.
double work_on_rest(const RestWork& work);

} // namespace sim
