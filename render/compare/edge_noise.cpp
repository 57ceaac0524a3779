#include "render/compare/edge_noise.h"

#include <algorithm>
#include <cmath>

namespace diff {

namespace {

constexpr int edge_levels = 24;    ///< a step between neighbours is an edge [levels]
constexpr int touched_levels = 8;  ///< a pixel differs, as other samples make it [levels]
constexpr int lone_levels = 16;    ///< a pixel differs as one of a lone change [levels]
constexpr int least_edge_pixels = 3; ///< of the 16 of a cell with an edge
/// Cells with edges below which nothing is said about a picture's edges.
constexpr int least_edge_cells = 50;

/// Pixels of a lone change that are granted if all edges elsewhere differ: one sample in ten, 100 pixels.
constexpr double lone_grant = 1000.0;
/// Cells around the window of a lone change that may belong to it.
constexpr int lone_margin = 2;

/// Text is drawn without samples, whatever the edges elsewhere do. Most pixels of its cells are edges, so that other samples
/// could not miss them: at least so many of the 16, in at least so many cells within so many of the window.
constexpr int least_text_pixels = 8;
constexpr int least_text_cells = 20;
constexpr int text_across = 12;
constexpr int text_up = 1;

/// Sums over rectangles of cells.
class CellSums {
public:
    template <typename Value>
    CellSums(int columns, int rows, Value value) : columns_(columns), rows_(rows) {
        const auto width = static_cast<std::size_t>(columns) + 1;
        sums_.assign(width * (static_cast<std::size_t>(rows) + 1), 0);
        for (std::size_t row = 0; row < static_cast<std::size_t>(rows); ++row) {
            for (std::size_t column = 0; column + 1 < width; ++column) {
                sums_[(row + 1) * width + column + 1] = value(row * (width - 1) + column) + sums_[row * width + column + 1] +
                                                        sums_[(row + 1) * width + column] - sums_[row * width + column];
            }
        }
    }

    /// What lies outside the picture counts nothing.
    int of(int left, int top, int right, int bottom) const {
        const int l = std::clamp(left, 0, columns_), r = std::clamp(right, 0, columns_);
        const int t = std::clamp(top, 0, rows_), b = std::clamp(bottom, 0, rows_);
        return at(r, b) - at(l, b) - at(r, t) + at(l, t);
    }

private:
    int at(int column, int row) const {
        return sums_[static_cast<std::size_t>(row) * (static_cast<std::size_t>(columns_) + 1) + static_cast<std::size_t>(column)];
    }

    int columns_;
    int rows_;
    std::vector<std::int32_t> sums_;
};

/// Pixels of each cell.
struct CellCounts {
    int columns;
    int rows;
    const std::vector<std::int32_t>& edges;
    const std::vector<std::int32_t>& lone;    ///< that differ much
    const std::vector<std::int32_t>& touched; ///< that differ, those that masks hide too
};

/// What tells whether the change of a window is alone: the edges around it.
struct Surroundings {
    struct Kind {
        int across = 0;       ///< [cells] on each side of the window
        int up = 0;           ///< [cells] above and below
        int edge_pixels = 0;  ///< of a cell, from which on it counts
        int least_cells = 0;  ///< below which nothing is said
        bool is_text = false; ///< the window's pixels count in such cells only
    };

    Surroundings(const CellCounts& cells, const Kind& of_kind)
        : kind(of_kind),
          lone(cells.columns, cells.rows,
                  [&](std::size_t i) { return !kind.is_text || cells.edges[i] >= kind.edge_pixels ? cells.lone[i] : 0; }),
          edges(cells.columns, cells.rows, [&](std::size_t i) { return cells.edges[i] >= kind.edge_pixels; }),
          both(cells.columns, cells.rows,
               [&](std::size_t i) { return cells.edges[i] >= kind.edge_pixels && cells.touched[i] > 0; }) {}

    /// Share of the cells with edges around the window that differ; 1 if there are hardly any.
    double share(int left, int top) const {
        const auto around = [&](const CellSums& sums) {
            constexpr int side = lone_size / cell_size;
            const auto square = [&](int across, int up) {
                return sums.of(left - across, top - up, left + side + across, top + side + up);
            };
            return square(kind.across, kind.up) - square(lone_margin, std::min(lone_margin, kind.up));
        };
        const int all = around(edges);
        return all < kind.least_cells ? 1.0 : static_cast<double>(around(both)) / all;
    }

    Kind kind;
    CellSums lone;    ///< pixels that differ much
    CellSums edges;   ///< cells
    CellSums both;    ///< those of them that differ
};

/// Enters the window whose pixels are most above what is granted for the differences around, if it beats the peak.
void raise_lone_peak(const Surroundings& around, const CellCounts& cells, LonePeak& peak) {
    constexpr int side = lone_size / cell_size;
    for (int top = 0; top == 0 || top + side <= cells.rows; ++top) {
        if (around.lone.of(0, top, cells.columns, top + side) <= peak.value) {
            continue;
        }
        for (int left = 0; left == 0 || left + side <= cells.columns; ++left) {
            const int pixels = around.lone.of(left, top, left + side, top + side);
            if (pixels <= peak.value) {
                continue;
            }
            const double elsewhere = around.share(left, top);
            const double value = pixels - lone_grant * elsewhere;
            if (value > peak.value) {
                peak = {pixels, value, elsewhere, left * cell_size, top * cell_size};
            }
        }
    }
}

} // namespace

EdgeNoise::EdgeNoise(const DifferenceMap& map, const std::vector<std::uint8_t>& whole_raw)
    : columns_(cell_count(map.width)), rows_(cell_count(map.height)),
      edges_(count_in_cells(map.steps, map.width, map.height, edge_levels)),
      lone_(count_in_cells(map.raw, map.width, map.height, lone_levels)),
      touched_(count_in_cells(whole_raw.empty() ? map.raw : whole_raw, map.width, map.height, touched_levels)) {}

bool EdgeNoise::can_be_lone() const {
    constexpr int around = lone_size / cell_size + 2 * lone_margin;
    int cells = 0;
    int touched = 0;
    for (std::size_t i = 0; i < edges_.size(); ++i) {
        cells += edges_[i] >= least_edge_pixels;
        touched += edges_[i] >= least_edge_pixels && touched_[i] > 0;
    }
    return lone_grant * (touched - around * around) < double{lone_size} * lone_size * cells;
}

LonePeak EdgeNoise::lone_peak() const {
    const CellCounts counts{columns_, rows_, edges_, lone_, touched_};
    LonePeak result;
    if (can_be_lone()) {
        const Surroundings::Kind all{
            .across = columns_, .up = rows_, .edge_pixels = least_edge_pixels, .least_cells = least_edge_cells};
        raise_lone_peak({counts, all}, counts, result);
    }
    const Surroundings::Kind text{.across = text_across,
                                  .up = text_up,
                                  .edge_pixels = least_text_pixels,
                                  .least_cells = least_text_cells,
                                  .is_text = true};
    raise_lone_peak({counts, text}, counts, result);
    return result;
}

} // namespace diff
