#pragma once
/// Neighbouring pixels that differ, and the shift that explains their differences best.
#include "render/compare/difference.h"
#include "render/compare/result.h"

#include <cstdint>
#include <vector>

namespace diff {

/// Pixels that differ, close together: cells of cell_size, touching each other.
struct Area {
    std::vector<std::int32_t> cells; ///< row * columns + column, ascending
    Box box;                         ///< of all differing pixels in them
    std::int64_t pixels = 0;         ///< that differ by more than the level
    int largest = 0;                 ///< [levels]
};

/// Areas of pixels whose smooth difference is above `level`, largest first.
std::vector<Area> find_areas(const DifferenceMap& map, int level);

/// Parts of an area in squares of `side` pixels that overlap by half, in order of their places.
std::vector<Area> split_area(const Area& area, const DifferenceMap& map, int level, int side);

/// A shift counts if it explains this share [-] of the squared differences: fits to the noise of edges are worse.
inline constexpr double least_explained = 0.58;
/// Whole shifts that are tried [px].
inline constexpr int search_reach = 6;

/// The shift u, so that candidate(x) = reference(x - u) out of focus, that leaves least of the squared differences
/// on the area's pixels: Lucas & Kanade 1981, iterated, from zero or from the best whole shift of up to `reach`
/// pixels.
Displacement fit_displacement(const DifferenceMap& map, const Area& area, int reach);

/// The same from the candidate's side: reference(x) = candidate(x + u). What covers or reveals something is explained
/// from one side only.
Displacement fit_backwards(const DifferenceMap& map, const Area& area, int reach);

} // namespace diff
