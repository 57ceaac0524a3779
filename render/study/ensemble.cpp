#include "render/study/ensemble.h"

#include <algorithm>

namespace study {

Ensemble ensemble_of(std::span<const Point> points) {
    Ensemble all;
    for (const Point& point : points) {
        if (point.status != Status::done || point.series.empty()) {
            continue;
        }
        ++all.runs;
        if (all.mean.empty()) {
            all.mean = point.series;
            all.variance.assign(point.series.size(), std::vector<double>(statistics_count, 0.0));
            continue;
        }
        for (std::size_t k = 0; k < all.mean.size(); ++k) { // Welford 1962
            for (std::size_t q = 0; q < statistics_count; ++q) {
                const double delta = point.series[k][q] - all.mean[k][q];
                all.mean[k][q] += delta / all.runs;
                all.variance[k][q] += delta * (point.series[k][q] - all.mean[k][q]);
            }
        }
    }
    for (std::vector<double>& row : all.variance) {
        for (double& value : row) {
            value /= std::max(1, all.runs - 1);
        }
    }
    return all;
}

} // namespace study
