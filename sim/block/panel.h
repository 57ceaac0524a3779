#pragma once
/// What body_factors.h does most: products of its blocks, which have a row and a column for each component of a body's velocity.

namespace sim {

/// Blocks of 6 x 6 below each other in one column of six columns of numbers. Each of them times one block is taken from one of
/// another panel.
struct PanelProduct {
    const double* from = nullptr;   ///< first row of the first block
    int from_rows = 0;              ///< numbers from column to column
    int count = 0;                  ///< [-] blocks
    const double* factor = nullptr; ///< [36] row by row
    double* to = nullptr;           ///< first row of the other panel
    int to_rows = 0;
    const int* places = nullptr;    ///< [count] which block of the other panel, ascending
};
/// Numbers up to `lane_count` beyond the last row of both panels are looked at, and left as they are.
void subtract_product(const PanelProduct& product);

} // namespace sim
