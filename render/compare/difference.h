#pragma once
/// What differs between two pictures of one size, pixel by pixel and by area.
///
/// An edge that is drawn with other samples changes its pixels at random and keeps its place; the change vanishes
/// in pictures that are slightly out of focus. So these are compared: with the weights 1 4 6 4 1 (by 16) in x and
/// y, a colour may lie anywhere up to half the way to its eight neighbours, which is what an edge moved by half a
/// pixel does. What goes beyond is `excess`.
#include "render/compare/picture.h"

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace diff {

/// Differences of one level are rounding.
inline constexpr int rounding_levels = 1;

/// Areas are sums over cells of 4 x 4 pixels.
inline constexpr int cell_size = 4;

/// Number of cells along a length [px].
constexpr int cell_count(int pixels) {
    return (pixels + cell_size - 1) / cell_size;
}

/// Mean signed differences candidate - reference [levels].
struct Drift {
    double mean = 0.0;      ///< over all pixels; of the channel that differs most
    double one_sided = 0.0; ///< [-] 0..1 of that channel's values that differ: by how many more go the same way
                            ///< than chance lets
    double block = 0.0;     ///< over one block of drift_block pixels square, where both are flat, without rounding
    int x = 0;              ///< [px] upper left corner of that block
    int y = 0;              ///< [px]
};
inline constexpr int drift_block = 32; ///< [px]

/// Signed differences, of at most what counts as drift, that masks hide. Of each channel.
struct HiddenSigns {
    struct Sum {
        std::int64_t levels = 0;
        std::int64_t count = 0;
    };
    std::array<Sum, 3> up{};   ///< where the candidate is larger
    std::array<Sum, 3> down{};
};

/// Sums of squares over a cell of two pictures out of focus [levels^2].
struct SquareCell {
    std::uint32_t differences = 0;
    std::uint32_t steps[2] = {}; ///< of reference and candidate, to the right or below
};

/// A map that is used again costs no new memory.
struct DifferenceMap {
    int width = 0;                    ///< [px]
    int height = 0;                   ///< [px]
    std::vector<std::uint8_t> raw;    ///< [height * width] [levels] largest difference of a channel
    std::int64_t differing = 0;       ///< pixels
    int largest = 0;                  ///< [levels]
    double mean = 0.0;                ///< [levels] absolute, of all channels
    // Out of focus. Where rows hold no difference, nothing is computed, and all is 0.
    std::vector<std::uint8_t> smooth; ///< [height * width] [levels] largest difference of a channel
    std::vector<std::uint8_t> excess; ///< [height * width] [levels]
    std::vector<std::uint8_t> steps;  ///< [height * width] [levels] to the right or below, in the one that has more; all rows
    // What masks hide tells of noise all the same; see measure_hidden().
    std::vector<std::uint8_t> whole_raw; ///< [height * width] raw without masks; empty if there are none
    HiddenSigns hidden;
    std::optional<double> whole_shift; ///< [px] the usual one without masks, see edge_shift.h; none if there are no masks
    std::vector<SquareCell> squares; ///< by cell, in rows near differences; empty if there are none
    Picture reference;                ///< valid in the rows near differences
    Picture candidate;
    Drift drift;
};

/// Compares a and b, which have one size. Only rgb is looked at.
void measure(const Picture& a, const Picture& b, DifferenceMap& map);

/// What masks hide of b into map.whole_raw and map.hidden. masked: b with a's pixels where it is masked.
void measure_hidden(const Picture& a, const Picture& b, const Picture& masked, DifferenceMap& map);
/// There are no masks.
void forget_hidden(DifferenceMap& map);

/// The same but for steps, squares and drift, which a picture of the difference does not show.
void measure_excess(const Picture& a, const Picture& b, DifferenceMap& map);

/// The place of the largest sum.
struct Peak {
    int value = 0;
    int x = 0; ///< [px] upper left corner of the window
    int y = 0; ///< [px]
};

/// For each cell, rows of cells from the top: how many of its pixels have a value above `level`.
std::vector<std::int32_t> count_in_cells(const std::vector<std::uint8_t>& values, int width, int height, int level);

} // namespace diff
