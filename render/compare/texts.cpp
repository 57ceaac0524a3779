#include "render/compare/texts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace diff {

namespace {

using Lines = std::vector<const TextLine*>;

/// Of `lines` those that `others` lacks, each line of them taken for one.
Lines lacking(const std::vector<TextLine>& lines, const std::vector<TextLine>& others) {
    std::vector<std::string> left;
    for (const TextLine& other : others) {
        left.push_back(other.text);
    }
    Lines result;
    for (const TextLine& line : lines) {
        const auto found = std::find(left.begin(), left.end(), line.text);
        if (found != left.end()) {
            left.erase(found);
        } else if (!line.is_masked) {
            result.push_back(&line);
        }
    }
    return result;
}

/// Where the line is; what has become longer or shorter still begins or ends there.
int distance(const TextLine& a, const TextLine& b) {
    const int across = std::min(std::abs(a.x - b.x), std::abs(a.x + a.width - b.x - b.width));
    return across + std::abs(a.y + a.height - b.y - b.height);
}

} // namespace

TextDifference compare_texts(const std::vector<TextLine>& reference, const std::vector<TextLine>& candidate) {
    const Lines gone = lacking(reference, candidate);
    const Lines come = lacking(candidate, reference);
    TextDifference result;
    result.lines = static_cast<int>(std::max(gone.size(), come.size()));
    if (gone.empty() && come.empty()) {
        result.reason = "all texts are the same";
    } else if (gone.empty() || come.empty()) {
        const TextLine& line = gone.empty() ? *come.front() : *gone.front();
        result.reason = fmt::format("the text \"{}\" at ({}, {}) {}", line.text, line.x, line.y,
                                    gone.empty() ? "has appeared" : "is missing");
    } else {
        const TextLine& line = *gone.front();
        const TextLine& now = **std::min_element(come.begin(), come.end(), [&](const TextLine* a, const TextLine* b) {
            return distance(line, *a) < distance(line, *b);
        });
        result.reason = fmt::format("the text \"{}\" at ({}, {}) is \"{}\"", line.text, line.x, line.y, now.text);
    }
    return result;
}

} // namespace diff
