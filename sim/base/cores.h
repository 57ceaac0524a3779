#pragma once
/// The processors that this process has.
#include <filesystem>

namespace sim {

/// Cores that the process may use at once, at least 1: those of its affinity mask, no more than a container's quota, rounded up.
/// With more threads than that the simulation takes 1.4 to 2 times as long: they wait for each other, and for the quota.
int core_count();

/// Quota of processor time [cores]: the least of the control group that `own_groups` tells of and of those it lies in, up to `root`;
/// infinite where there is none. Linux: "Control Group v2", files cpu.max.
double cpu_quota(const std::filesystem::path& own_groups = "/proc/self/cgroup", const std::filesystem::path& root = "/sys/fs/cgroup");

} // namespace sim
