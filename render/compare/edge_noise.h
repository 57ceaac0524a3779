#pragma once
/// Whether the edges of a picture differ everywhere, as other samples make them, or in one place only.
#include "render/compare/difference.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace diff {

inline constexpr int lone_size = 16; ///< [px] side of the window that may hold a lone change

/// The window in which most pixels are beyond what edges that differ everywhere account for.
struct EdgePeak {
    int pixels = 0;
    double beyond = 0.0; ///< [px]
    int x = 0;           ///< [px] upper left corner
    int y = 0;           ///< [px]
};

/// The densest window of differing pixels, and what differs outside its neighbourhood.
struct LonePeak {
    int pixels = 0;
    double value = 0.0;     ///< [px] pixels, less what is granted for differences elsewhere; >= 0
    double elsewhere = 1.0; ///< share of the cells with edges that differ; 1 if there are hardly any
    int x = 0;              ///< [px] upper left corner
    int y = 0;              ///< [px]
};

class EdgeNoise {
public:
    /// map: after measure(); must outlive this. What is masked tells of noise too: whole_raw has the differences without
    /// masks, empty if there are none.
    EdgeNoise(const DifferenceMap& map, const std::vector<std::uint8_t>& whole_raw);

    /// How far the picture's edges differ everywhere [-]: 0 where few do, to 1.
    double everywhere() const;

    /// cells: pixels beyond an edge's noise, see count_in_cells(); size: of the window, a multiple of cell_size [px];
    /// allowance: share of a window's edge pixels that is taken off [-].
    EdgePeak densest_beyond(const std::vector<std::int32_t>& cells, int size, double allowance) const;

    LonePeak lone_peak() const;

private:
    /// Share of the cells with edges that differ, outside the columns and rows of cells given; none if there are hardly any.
    std::optional<double> share_outside(int left, int top, int right, int bottom) const;

    /// False if so many edges differ that no window of any number of pixels is alone.
    bool can_be_lone() const;

    const DifferenceMap& map_;
    int columns_;
    int rows_;
    std::vector<std::int32_t> edges_;   ///< edge pixels by cell
    std::vector<std::int32_t> touched_; ///< differing pixels by cell
    std::vector<std::int32_t> whole_touched_; ///< those that masks hide too
};

} // namespace diff
