#include "sim/base/cores.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <thread>

namespace sim {

namespace fs = std::filesystem;

int core_count() {
    const double cores = std::max(1u, std::thread::hardware_concurrency());
    return static_cast<int>(std::max(std::ceil(std::min(cores, cpu_quota())), 1.0));
}

double cpu_quota(const fs::path& own_groups, const fs::path& root) {
    fs::path group; // of the line "0::/path"; where the file system of groups is the container's own, the path may lead nowhere in it
    std::ifstream lines(own_groups);
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("0::/")) {
            group = line.substr(4);
        }
    }
    double quota = std::numeric_limits<double>::infinity();
    while (true) {
        std::ifstream file(root / group / "cpu.max"); // "quota period" [us], or "max period"
        double time = 0.0, period = 0.0;
        if (file >> time >> period && period > 0.0) {
            quota = std::min(quota, time / period);
        }
        if (group.empty()) {
            return quota;
        }
        group = group.parent_path();
    }
}

} // namespace sim
