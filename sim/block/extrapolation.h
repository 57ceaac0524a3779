#pragma once
/// Nesterov's extrapolation of the impulses: when they go on in the direction in which the sweeps of a solve move them, and
/// how far (Mazhar et al. 2015, "Using Nesterov's method to accelerate multibody dynamics with friction and contact"), begun
/// anew where it leads back, or away (O'Donoghue & Candes 2015, "Adaptive restart for accelerated gradient schemes"). It serves
/// islands too dense for newton.h: a high heap needs about as many plain sweeps as the square of its height.
#include "sim/block/batch.h"

namespace sim {

/// Extrapolation overshoots where a sweep changes more than so many times [-] what the one before did: friction pushes as its load
/// does, so what sweeps do is no gradient, and may go ever farther without going back.
constexpr double most_overshoot = 2.0;

class Extrapolation {
public:
    void start() { steps_ = 0; }

    /// Share [-] of the last step that is repeated before the next sweep: none where extrapolation led back. Then the sweep went
    /// against that step, or, as of impulses that take turns, the step goes against what was extrapolated. And none where it
    /// overshot. growth: of what the sweeps change [-].
    double next(const StepParts& of_step, double growth) {
        steps_ = of_step.swept < 0.0 || of_step.extrapolated < 0.0 || growth > most_overshoot ? 0 : steps_ + 1;
        return steps_ / (steps_ + 3.0); // k / (k + 3): Nesterov's sequence
    }

private:
    int steps_ = 0; ///< since the extrapolation began
};

} // namespace sim
