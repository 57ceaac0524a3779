/// What a key expects, in words.
#include "sim/scene/keys.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace sim {
namespace {

using enum KeyType;

std::string describe_range(const KeyRange& range) {
    const bool has_lower = range.lower > KeyRange{}.lower;
    const bool has_upper = range.upper < KeyRange{}.upper;
    if (has_lower && has_upper && !range.is_lower_open) {
        return fmt::format(" {}..{}", range.lower, range.upper);
    }
    std::string result;
    if (has_lower) {
        result += fmt::format(" {} {}", range.is_lower_open ? ">" : ">=", range.lower);
    }
    if (has_upper) {
        result += fmt::format("{} <= {}", has_lower ? " and" : "", range.upper);
    }
    return result;
}

/// "a", "b" or "c"
std::string one_of(const std::vector<std::string>& words) {
    std::string result;
    for (std::size_t i = 0; i < words.size(); ++i) {
        result += (i == 0 ? "\"" : i + 1 == words.size() ? " or \"" : ", \"") + words[i] + "\"";
    }
    return result;
}

} // namespace

std::vector<std::string> choices_of(const KeySpec& key) {
    std::vector<std::string> result;
    std::string_view rest = key.choices;
    while (!rest.empty()) {
        const std::size_t end = std::min(rest.find(' '), rest.size());
        result.emplace_back(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    return result;
}

std::string describe_expected(const KeySpec& key) {
    const std::string range = describe_range(key.range);
    const std::string unit = key.unit.empty() ? "" : fmt::format(" [{}]", key.unit);
    switch (key.type) {
    case number:
        return (range.empty() ? "a finite number" : "a number" + range) + unit;
    case integer:
        return "an integer" + range + unit;
    case boolean:
        return "true or false";
    case text:
        return "a text";
    case choice:
        return one_of(choices_of(key));
    case fraction:
        return "a number" + range + " or a text such as \"1/60\"" + unit;
    case vector:
        return (range.empty() ? "three finite numbers" : "three numbers" + range) + unit;
    case direction:
        return "three finite numbers, not all zero";
    case quaternion:
        return "four numbers w, x, y, z whose squares sum to 1";
    case axis_angle:
        return "four finite numbers: an axis x, y, z, not all zero, and an angle [degrees]";
    case moments:
        return "three or six finite numbers" + unit;
    case counts:
        return "three integers" + range;
    case KeyType::color:
        return "three numbers 0..1 (linear RGB) or \"#rrggbb\" (sRGB)";
    case colors:
        return "an array of colours, each three numbers 0..1 (linear RGB) or \"#rrggbb\" (sRGB)";
    case pairs:
        return "an array of pairs of numbers" + range + unit;
    case profile:
        return "an array of at least two [radius, z]" + unit + ", radius >= 0, z not falling";
    case points:
        return "an array of at least four [x, y, z]" + unit;
    case names:
        return "one or two names of bodies";
    case texts:
        return "an array of names of bodies";
    case words:
        return fmt::format("an array of \"{}\"", fmt::join(choices_of(key), "\", \""));
    case interval:
        return "two numbers, the first less than the second" + unit;
    case table:
        return fmt::format("a table: {}", key.choices);
    case tables:
        return fmt::format("an array of tables: {}", key.choices);
    }
    return "";
}

std::string describe_component(const KeySpec& key) {
    const std::string range = describe_range(key.range);
    const std::string unit = key.unit.empty() ? "" : fmt::format(" [{}]", key.unit);
    if (key.type == counts) {
        return "an integer" + range + unit;
    }
    return (range.empty() ? "a finite number" : "a number" + range) + unit;
}

} // namespace sim
