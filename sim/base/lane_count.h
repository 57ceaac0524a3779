#pragma once
/// How many independent problems the kernels solve at a time, and their numbers in memory. Knows no library: kernels
/// are compiled once for each instruction set.

namespace sim {

/// Problems in one batch, whatever the width of the processor's registers.
inline constexpr int lane_count = 8;

/// One value a lane.
struct alignas(64) Lanes {
    double x[lane_count];
};

/// The same in half the memory, to seven digits.
struct alignas(32) ShortLanes {
    float x[lane_count];
};

} // namespace sim
