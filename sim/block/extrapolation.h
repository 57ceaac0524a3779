#pragma once
/// Nesterov's extrapolation of the impulses: when they go on in the direction in which the sweeps of a solve move them, and
/// how far (Mazhar et al. 2015, "Using Nesterov's method to accelerate multibody dynamics with friction and contact"), begun
/// anew where it leads back (O'Donoghue & Candes 2015, "Adaptive restart for accelerated gradient schemes"). It serves
/// islands too dense for newton.h: a high heap needs about as many plain sweeps as the square of its height.
#include <algorithm>

namespace sim {

class Extrapolation {
public:
    /// Before the first sweep of a solve.
    void begin() { sweeps_ = 0; }

    /// Before each sweep: are the impulses extrapolated?
    bool is_due() {
        ++sweeps_;
        return sweeps_ > plain_sweeps && sweeps_ <= last_extrapolated;
    }

    /// change: largest velocity change by the sweep before [m/s].
    void start(double change) {
        steps_ = 0;
        change_at_start_ = change;
    }

    /// Share [-] of the last sweep's step that is repeated before the next one. along: product of that step with the
    /// one from where it began; negative where the extrapolation leads back.
    double next(double along, double change) {
        ++steps_;
        if (along < 0.0 || change > growth * change_at_start_) {
            start(change);
        }
        return std::min(steps_ / (steps_ + 3.0), largest_share); // k / (k + 3): Nesterov's sequence
    }

private:
    // Found by trial with dominoes and the funnel.
    /// Sweeps of a solve [-] before any is extrapolated. With 10 the funnel's impacts take a few less, with 6 rows of
    /// fallen dominoes many more.
    static constexpr int plain_sweeps = 14;
    /// Sweep of a solve [-] after which none is extrapolated: in a row of 200 fallen dominoes what has not led to the end
    /// by then goes in circles.
    static constexpr int last_extrapolated = 600;
    static constexpr double largest_share = 0.98; ///< most of the last step that is repeated [-]
    static constexpr double growth = 2.0;         ///< of the change since it began [-]; beyond, it begins anew

    int sweeps_ = 0;               ///< since begin()
    int steps_ = 0;                ///< since the extrapolation began
    double change_at_start_ = 0.0; ///< [m/s] by the sweep after which it began
};

} // namespace sim
