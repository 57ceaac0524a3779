/// overlap_check TRAJECTORY.h5 [TOLERANCE]: judges every record of a trajectory by exact box and ball
/// geometry that shares no code with the simulation. Prints the distribution of the overlaps, the deepest
/// pair, and the bodies that left through a static body. Exit code: 0 all overlaps within the tolerance and
/// nobody left, 1 otherwise, 2 usage, 3 the file cannot be read.
#include "tests/laws/reference/overlap.h"
#include "tests/laws/reference/trajectory_file.h"

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <set>

namespace {

struct Verdict {
    reference::OverlapStatistics overlaps;
    reference::PairGap deepest; ///< gap 0: none
    std::size_t deepest_record = 0;
    std::set<int> left; ///< bodies that passed through a static one
};

Verdict judge(const reference::TrajectoryFile& file) {
    Verdict verdict;
    std::vector<reference::Placement> before;
    for (std::size_t record = 0; record < file.record_count(); ++record) {
        const std::vector<reference::Placement> now = file.placements(record);
        const std::vector<reference::PairGap> pairs = reference::near_pairs(file.solids(), now, 0.0);
        verdict.overlaps.add(pairs);
        for (const reference::PairGap& pair : pairs) {
            if (pair.gap < verdict.deepest.gap) {
                verdict.deepest = pair;
                verdict.deepest_record = record;
            }
        }
        for (int body : reference::passed_through(file.solids(), record == 0 ? now : before, now)) {
            verdict.left.insert(body);
        }
        before = now;
    }
    return verdict;
}

void print(const reference::TrajectoryFile& file, const Verdict& verdict, double tolerance) {
    std::printf("records %zu  bodies %zu  time %.6g .. %.6g s\n", file.record_count(), file.solids().size(),
                file.time().empty() ? 0.0 : file.time().front(),
                file.time().empty() ? 0.0 : file.time().back());
    std::printf("overlaps %zu  p50 %.3e m  p99 %.3e m  max %.3e m\n", verdict.overlaps.count(),
                verdict.overlaps.quantile(0.5), verdict.overlaps.quantile(0.99), verdict.overlaps.largest());
    std::printf("above %.1e m: %zu (%.4f %%)\n", tolerance, verdict.overlaps.count_above(tolerance),
                100.0 * verdict.overlaps.share_above(tolerance));
    if (verdict.deepest.a >= 0) {
        std::printf("deepest: %s and %s at %.6g s\n", file.names()[verdict.deepest.a].c_str(),
                    file.names()[verdict.deepest.b].c_str(), file.time()[verdict.deepest_record]);
    }
    std::printf("left through a static body: %zu", verdict.left.size());
    for (int body : verdict.left) {
        std::printf(" %s", file.names()[body].c_str());
    }
    std::printf("\n");
}

} // namespace

int main(int argc, char** argv) {
    char* end = nullptr;
    const double tolerance = argc > 2 ? std::strtod(argv[2], &end) : 1e-4;
    if (argc < 2 || argc > 3 || (end && (*end != '\0' || !(tolerance >= 0.0)))) {
        std::fprintf(stderr, "usage: overlap_check TRAJECTORY.h5 [TOLERANCE in m, default 1e-4]\n");
        return 2;
    }
    try {
        const reference::TrajectoryFile file(argv[1]);
        const Verdict verdict = judge(file);
        print(file, verdict, tolerance);
        return verdict.overlaps.count_above(tolerance) == 0 && verdict.left.empty() ? 0 : 1;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "overlap_check: %s\n", error.what());
        return 3;
    }
}
