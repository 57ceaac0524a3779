#include "sim/model/obj_file.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
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

} // namespace sim
