#pragma once
/// Sweeps carried on: when the impulses of a solve go on in the direction in which its sweeps move them, and how far.
/// Nesterov's momentum, begun anew where it leads back (O'Donoghue & Candes 2015, "Adaptive restart for accelerated
/// gradient schemes"). A high pile needs as many plain sweeps as the square of its height, so about as many as its height.
#include <algorithm>
#include <limits>

namespace sim {

class Momentum {
public:
    static constexpr int no_limit = std::numeric_limits<int>::max();

    /// plain, last: sweeps of a solve [-] before any is carried on, and after which none is.
    explicit Momentum(int plain = few, int last = no_limit) : plain_(plain), last_(last) {}

    /// Before the first sweep of a solve.
    void begin() { sweeps_ = 0; }

    /// Before each sweep: is it carried on?
    bool carries() {
        ++sweeps_;
        return sweeps_ > plain_ && sweeps_ <= last_;
    }

    /// change: largest velocity change by the sweep before [m/s].
    void start(double change) {
        carried_ = 0;
        change_at_start_ = change;
    }

    /// Share [-] of the last sweep's step that is repeated before the next one. along: product of that step with the
    /// one from where it began; negative where the momentum leads back.
    double next(double along, double change) {
        ++carried_;
        if (along < 0.0 || change > growth * change_at_start_) {
            start(change);
        }
        return std::min(carried_ / (carried_ + 3.0), largest); // k / (k + 3): Nesterov's sequence
    }

private:
    // Found by trial with dominoes and the funnel.
    static constexpr int few = 20;          ///< sweeps of a solve before any is carried on [-]
    static constexpr double largest = 0.98; ///< most of the last step that is repeated [-]
    static constexpr double growth = 2.0;   ///< of the change since it began [-]; beyond, it begins anew

    int plain_;
    int last_;
    int sweeps_ = 0;               ///< since begin()
    int carried_ = 0;              ///< since the momentum began
    double change_at_start_ = 0.0; ///< [m/s] by the sweep after which it began
};

} // namespace sim
