#pragma once
/// Sweeps carried on: when the impulses of a solve go on in the direction in which its sweeps move them, and how far.
/// Nesterov's momentum, begun anew where it leads back (O'Donoghue & Candes 2015, "Adaptive restart for accelerated
/// gradient schemes"). Long chains and high piles need as many plain sweeps as the square of their length, so about as
/// many as their length.
#include <algorithm>

namespace sim {

class Momentum {
public:
    /// Sweeps of one solve before the impulses are carried on beyond them.
    static constexpr int plain_sweeps = 20;

    /// change: largest velocity change by the sweep before [m/s].
    void start(double change) {
        sweeps_ = 0;
        change_at_start_ = change;
    }

    /// Share [-] of the last sweep's step that is repeated before the next one. along: product of that step with the one
    /// from where it began; negative where the momentum leads back.
    double next(double along, double change) {
        ++sweeps_;
        if (along < 0.0 || change > growth * change_at_start_) {
            start(change);
        }
        return std::min(sweeps_ / (sweeps_ + 3.0), largest);
    }

private:
    /// Most of the last step [-] that is repeated.
    static constexpr double largest = 0.98;
    /// The momentum begins anew where the change by a sweep has grown by this factor [-] since it began.
    static constexpr double growth = 2.0;

    int sweeps_ = 0;               ///< since the momentum began
    double change_at_start_ = 0.0; ///< [m/s] by the sweep after which it began
};

} // namespace sim
