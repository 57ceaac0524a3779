#pragma once
/// Something small that differs alone: the edges around it do not, as other samples would make them.
#include "render/compare/difference.h"

#include <cstdint>
#include <vector>

namespace diff {

inline constexpr int lone_size = 16; ///< [px] side of the window that may hold a lone change

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
    /// map: after measure(). What is masked tells of noise too: whole_raw has the differences without
    /// masks, empty if there are none.
    EdgeNoise(const DifferenceMap& map, const std::vector<std::uint8_t>& whole_raw);

    LonePeak lone_peak() const;

private:
    /// False if so many edges differ that no window of any number of pixels is alone.
    bool can_be_lone() const;

    int columns_;
    int rows_;
    std::vector<std::int32_t> edges_;   ///< edge pixels by cell
    std::vector<std::int32_t> lone_;    ///< pixels by cell that differ much
    std::vector<std::int32_t> touched_; ///< those that differ, and those that masks hide too
};

} // namespace diff
