#pragma once
/// Nesterov's extrapolation of the impulses: when they go on in the direction in which the sweeps of a solve move them, and
/// how far (Mazhar et al. 2015, "Using Nesterov's method to accelerate multibody dynamics with friction and contact"), begun
/// anew where it leads back (O'Donoghue & Candes 2015, "Adaptive restart for accelerated gradient schemes") or has brought
/// nothing for a while: friction can lead it in circles. It serves islands too dense for newton.h: a high heap needs about as
/// many plain sweeps as the square of its height.

namespace sim {

class Extrapolation {
public:
    void start() { steps_ = 0; }

    /// Share [-] of the last sweep's step that is repeated before the next one. along: product of that step with the
    /// one from where it began; negative where the extrapolation leads back.
    double next(double along) {
        steps_ = along < 0.0 ? 0 : steps_ + 1;
        return steps_ / (steps_ + 3.0); // k / (k + 3): Nesterov's sequence
    }

private:
    int steps_ = 0; ///< since the extrapolation began
};

} // namespace sim
