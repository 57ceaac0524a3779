#pragma once
/// Settings of a simulation for a motion that is to be within a length of the true one: runs with ever shorter steps, until
/// two successive ones agree.
#include "render/study/motion.h"
#include "sim/base/rational.h"

#include <string>
#include <vector>

namespace study {

/// One run of the search, held against the one before.
struct AccuracyRun {
    sim::Rational time_step{};      ///< [s]
    double tolerance = 0.0;         ///< [m]
    std::string stopped{};          ///< why it has no motion; empty: it has
    double interval = 0.0;          ///< [s] into which its steps were divided, root mean square over time
    double difference = 0.0;        ///< [m] root mean square over bodies and instants; of the first run: infinite
    double determined_until = 0.0;  ///< [s] the last instant up to which no body is farther than asked from its other place
    double mean_difference = 0.0;   ///< [m] largest distance of the common centre of mass from its other place
};

enum class AccuracyEnd {
    reached,
    chaotic, ///< no step makes two runs agree: overlaps alone are held to what was asked
    missed,  ///< the shortest step that is tried does not
};

/// Successive intervals h_1 > h_2 > ... give motions x_k. Where x_k - x = C h_k^p, the differences of three of them tell p, and
/// with it what is left: |x_k - x| = |x_k - x_(k-1)| / ((h_(k-1) / h_k)^p - 1), Richardson's estimate. Intervals are the steps,
/// but where these are divided: two steps that are divided into the same intervals tell nothing. Tolerances shrink with the step,
/// so that what they leave is seen in the differences too.
class AccuracySearch {
public:
    /// asked: [m] > 0.
    AccuracySearch(const sim::SceneDef& scene, double asked);

    /// What the next run sets of the scene: "dotted.key=value".
    std::vector<std::string> overrides() const;
    /// Steps of it between two of the instants at which motions are compared, the start being the first, and their number.
    std::int64_t steps_between() const;
    int instants() const { return instants_; }

    /// The motion of that run, or why it has none. True if it is to be kept: the search is over.
    bool add(Motion motion);
    /// Instead: why it has stopped. False if a shorter step will not help.
    bool add_stopped(const std::string& message);

    /// Once it is over.
    AccuracyEnd end() const { return end_; }
    double asked() const { return asked_; }
    double estimate() const { return estimate_; } ///< [m] of what is left in the run kept, root mean square
    double order() const { return order_; }       ///< of convergence [-], 1 to 2
    const std::vector<AccuracyRun>& runs() const { return runs_; }

private:
    sim::Rational step_of(std::int64_t parts) const;
    double tolerance_of(std::int64_t parts) const;
    void compare(const Motion& motion, AccuracyRun& run) const;
    void find_estimate();
    bool is_chaotic() const;
    void shorten(std::int64_t factor);

    const sim::SceneDef scene_;
    double asked_;
    sim::Rational longest_;      ///< [s] time step of the first run
    sim::Rational spacing_;      ///< [s] between instants: a multiple of it
    int instants_ = 0;
    std::int64_t parts_ = 1;     ///< the next run's step is longest_ / parts_
    AccuracyEnd end_ = AccuracyEnd::reached;
    Motion before_;
    std::vector<AccuracyRun> runs_;
    double order_ = 1.0;
    double estimate_ = 0.0;
};

} // namespace study
