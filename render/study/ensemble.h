#pragma once
/// Several runs of a chaotic scene, each from another seed, as one.
#include "render/study/point.h"

#include <span>
#include <vector>

namespace study {

using Series = std::vector<std::vector<double>>; ///< [count][statistics_count]

/// Mean and variance over runs.
struct Ensemble {
    Series mean;
    Series variance; ///< of one run: n - 1 in the denominator
    int runs = 0;
};

/// Of those points that are done; none: empty.
Ensemble ensemble_of(std::span<const Point> points);

} // namespace study
