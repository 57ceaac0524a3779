#include "sim/model/obj_file.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdint>
#include <set>
#include <sstream>
#include <string_view>

namespace sim {
namespace {

/// The whole of a word as a finite number.
bool read_number(const std::string& word, double& x) {
    const char* end = word.data() + word.size();
    const auto [next, error] = std::from_chars(word.data(), end, x);
    return error == std::errc() && next == end && std::isfinite(x);
}

} // namespace

std::vector<Vec3> obj_points(const std::string& text, const std::string& file) {
    std::vector<Vec3> points;
    if (text.find('\0') != std::string::npos) {
        throw Error(ExitCode::usage, file + ": no text, expected lines such as 'v 0.1 0.2 0.3'");
    }
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    std::istringstream lines(text.starts_with(byte_order_mark) ? text.substr(byte_order_mark.size()) : text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        std::istringstream words(line);
        std::string word;
        if (!(words >> word) || word != "v") {
            continue;
        }
        Vec3 point;
        for (int k = 0; k < 3; ++k) {
            if (!(words >> word)) {
                throw Error(ExitCode::usage, fmt::format("{}:{}: v is followed by {} numbers, expected three",
                                                         file, number, k));
            }
            if (!read_number(word, point[k])) {
                throw Error(
                    ExitCode::usage,
                    fmt::format("{}:{}: '{}' stands after v, expected a finite number", file, number, word));
            }
        }
        points.push_back(point);
    }
    return points;
}

std::vector<std::vector<Vec3>> obj_groups(const std::string& text, const std::string& file) {
    const std::vector<Vec3> points = obj_points(text, file);
    std::vector<std::set<std::size_t>> used(1);
    std::istringstream lines(text);
    std::size_t known = 0; // vertices before the line
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            ++known;
        } else if (word == "g" || word == "o") {
            used.emplace_back();
        } else if (word == "f") {
            while (words >> word) {
                // "7/1/3": the vertex is the first; from the end if it is negative.
                std::int64_t index = 0;
                std::from_chars(word.data(), word.data() + word.size(), index);
                index = index < 0 ? index + static_cast<std::int64_t>(known) : index - 1;
                if (index < 0 || index >= static_cast<std::int64_t>(points.size())) {
                    throw Error(ExitCode::usage, fmt::format("{}:{}: '{}' stands after f, expected the number of a "
                                                             "vertex, 1 to {}", file, number, word, points.size()));
                }
                used.back().insert(static_cast<std::size_t>(index));
            }
        }
    }
    std::vector<std::vector<Vec3>> groups;
    for (const std::set<std::size_t>& group : used) {
        if (!group.empty()) {
            groups.emplace_back();
            for (const std::size_t index : group) {
                groups.back().push_back(points[index]);
            }
        }
    }
    return groups;
}

} // namespace sim
