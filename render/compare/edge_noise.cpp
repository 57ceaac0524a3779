#include "render/compare/edge_noise.h"

#include <algorithm>
#include <cmath>

namespace diff {

namespace {

constexpr int edge_levels = 24;    ///< a step between neighbours is an edge [levels]
constexpr int touched_levels = 8;  ///< a pixel differs [levels]
constexpr int least_edge_pixels = 3; ///< of the 16 of a cell with an edge
/// Cells with edges below which nothing is said about a picture's edges.
constexpr int least_edge_cells = 50;

/// Other sample patterns touch 0.3 to 0.95 of the cells with edges, a body that has moved a few hundredths.
constexpr double noise_begins = 0.15;
constexpr double noise_is_everywhere = 0.45;

/// Pixels of a lone change that are granted if all edges elsewhere differ: one sample in ten, 100 pixels.
constexpr double lone_grant = 1000.0;
/// Cells around the window of a lone change that may belong to it.
constexpr int lone_margin = 2;

} // namespace

EdgeNoise::EdgeNoise(const DifferenceMap& map)
    : map_(map), columns_(cell_count(map.width)), rows_(cell_count(map.height)),
      edges_(count_in_cells(map.steps, map.width, map.height, edge_levels)),
      touched_(count_in_cells(map.raw, map.width, map.height, touched_levels)) {}

std::optional<double> EdgeNoise::share_outside(int left, int top, int right, int bottom) const {
    int cells = 0;
    int touched = 0;
    for (int row = 0; row < rows_; ++row) {
        for (int column = 0; column < columns_; ++column) {
            const auto i = static_cast<std::size_t>(row * columns_ + column);
            const bool is_inside = row >= top && row < bottom && column >= left && column < right;
            if (!is_inside && edges_[i] >= least_edge_pixels) {
                ++cells;
                touched += touched_[i] > 0;
            }
        }
    }
    return cells < least_edge_cells ? std::nullopt : std::optional(static_cast<double>(touched) / cells);
}

double EdgeNoise::everywhere() const {
    const double share = share_outside(0, 0, 0, 0).value_or(0.0);
    return std::clamp((share - noise_begins) / (noise_is_everywhere - noise_begins), 0.0, 1.0);
}

EdgePeak EdgeNoise::densest_beyond(const std::vector<std::int32_t>& cells, int size, double allowance) const {
    constexpr double unit = 64.0; // of a pixel, so that sums of cells stay integers
    std::vector<std::int32_t> beyond(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        beyond[i] = static_cast<std::int32_t>(std::lround(unit * (cells[i] - allowance * edges_[i])));
    }
    const Peak peak = densest_window(beyond, map_.width, map_.height, size);
    EdgePeak result;
    result.beyond = peak.value / unit;
    result.x = peak.x;
    result.y = peak.y;
    if (peak.value > 0) {
        const int side = size / cell_size;
        for (int row = peak.y / cell_size; row < std::min(peak.y / cell_size + side, rows_); ++row) {
            for (int column = peak.x / cell_size; column < std::min(peak.x / cell_size + side, columns_); ++column) {
                result.pixels += cells[static_cast<std::size_t>(row * columns_ + column)];
            }
        }
    }
    return result;
}

LonePeak EdgeNoise::lone_peak() const {
    const Peak peak = densest_window(touched_, map_.width, map_.height, lone_size);
    LonePeak result;
    result.pixels = peak.value;
    result.x = peak.x;
    result.y = peak.y;
    const int left = peak.x / cell_size;
    const int top = peak.y / cell_size;
    constexpr int side = lone_size / cell_size;
    result.elsewhere = share_outside(left - lone_margin, top - lone_margin, left + side + lone_margin, top + side + lone_margin)
                           .value_or(1.0);
    result.value = std::max(0.0, peak.value - lone_grant * result.elsewhere);
    return result;
}

} // namespace diff
