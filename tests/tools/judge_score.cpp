/// How often the judge of comparisons is right about the pairs that judge_corpus has written. Arguments: FOLDER [-v]
#include "render/compare/judge.h"
#include "render/compare/pair.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Score {
    int pairs = 0;
    int right = 0;
    int one_sided = 0;              ///< the verdict depends on which of the two is the reference
    std::map<std::string, int> gates; ///< exceeded, by name
    std::map<std::string, int> only;  ///< exceeded alone
};

diff::Frame judged(const fs::path& a, const fs::path& b, const diff::PairSettings& settings) {
    static diff::PairMemory memory;
    diff::Frame frame;
    diff::compare_files({a, b}, settings, memory, frame);
    return frame;
}

void judge_kind(const fs::path& folder, bool is_verbose, Score& score) {
    const std::string kind = folder.filename().string();
    const bool is_noise = kind.starts_with("noise");
    diff::PairSettings settings;
    settings.is_jpeg = kind.find("JPEG") != std::string::npos;
    settings.is_lossy = settings.is_jpeg || kind.find("film") != std::string::npos;
    std::vector<fs::path> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
        if (entry.path().string().ends_with(".a.png")) {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    for (const fs::path& a : files) {
        std::string b = a.string();
        b[b.size() - 5] = 'b';
        const diff::Frame frame = judged(a, b, settings);
        const bool is_changed = frame.tier == diff::Tier::changed;
        const bool is_right = is_changed != is_noise;
        ++score.pairs;
        score.right += is_right;
        score.one_sided += (judged(b, a, settings).tier == diff::Tier::changed) != is_changed;
        const auto is_exceeded = [](const diff::Gate& gate) { return gate.is_exceeded; };
        const bool is_only = std::count_if(frame.gates.begin(), frame.gates.end(), is_exceeded) == 1;
        for (const diff::Gate& gate : frame.gates) {
            score.gates[gate.name] += gate.is_exceeded;
            score.only[gate.name] += gate.is_exceeded && is_only;
        }
        if (is_verbose && !is_right) {
            std::printf("  %s:", a.c_str());
            for (const diff::Gate& gate : frame.gates) {
                std::printf(" %s %.3g/%.3g", gate.name.c_str(), gate.value, gate.limit);
            }
            std::printf("\n");
        }
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: judge_score FOLDER [-v]\n");
        return 2;
    }
    bool is_good = true;
    for (const char* part : {"seen", "unseen"}) {
        const fs::path folder = fs::path(argv[1]) / part;
        if (!fs::exists(folder)) {
            continue;
        }
        std::vector<fs::path> kinds;
        for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
            kinds.push_back(entry.path());
        }
        std::sort(kinds.begin(), kinds.end());
        Score sum;
        int false_alarms = 0;
        for (const fs::path& kind : kinds) {
            Score score;
            judge_kind(kind, argc > 2, score);
            std::printf("%-6s %-34s %3d of %3d right", part, kind.filename().c_str(), score.right, score.pairs);
            for (const auto& [gate, count] : score.gates) {
                if (count > 0) {
                    std::printf(", %s %d", gate.c_str(), count);
                    if (score.only[gate] > 0) {
                        std::printf(" (%d alone)", score.only[gate]);
                    }
                }
            }
            std::printf(score.one_sided > 0 ? "; %d one-sided\n" : "\n", score.one_sided);
            sum.pairs += score.pairs;
            sum.right += score.right;
            sum.one_sided += score.one_sided;
            false_alarms += kind.filename().string().starts_with("noise") ? score.pairs - score.right : 0;
        }
        const double share = 100.0 * sum.right / std::max(sum.pairs, 1);
        std::printf("%-6s %d of %d right: %.1f %%; %d false alarms; %d verdicts depend on the order\n", part, sum.right,
                    sum.pairs, share, false_alarms, sum.one_sided);
        is_good = is_good && share >= 97.0 && false_alarms == 0 && sum.one_sided == 0;
    }
    return is_good ? 0 : 1;
}
