#include "sim/scene/section.h"

#include "sim/base/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace sim {

namespace {

constexpr double radians_per_degree = std::numbers::pi / 180.0;

/// Largest numerator and denominator of a time: frames times both still fit in 128 bits (rational.h).
constexpr std::int64_t largest_fraction_part = 1'000'000'000'000;

bool is_number(const TreeNode& node) {
    return node.kind == TreeKind::number || node.kind == TreeKind::integer;
}

bool is_within(const KeyRange& range, double x) {
    return std::isfinite(x) && x <= range.upper && (range.is_lower_open ? x > range.lower : x >= range.lower);
}

/// IEC 61966-2-1: encoded sRGB 0..1 to linear light.
double linear_from_srgb(double x) {
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

} // namespace

Section::Section(const TextSource& source, const TreeNode& node, const SectionSpec& spec, std::string title)
    : source_(source), node_(node), spec_(spec), title_(std::move(title)) {
    CHECK(node.kind == TreeKind::table);
    for (const TreeNode& child : node.children) {
        if (spec.find(child.key) == nullptr) {
            fail_at(source_, child.key_place,
                    fmt::format("{}: unknown key '{}'{}", title_, child.key,
                                suggestion(child.key, spec.key_names())));
        }
    }
}

bool Section::has(std::string_view key) const {
    CHECK(spec_.find(key) != nullptr);
    return node_.find(std::string(key)) != nullptr;
}

TextPlace Section::place_of(std::string_view key) const {
    const TreeNode* value = node_.find(std::string(key));
    return value != nullptr ? value->place : node_.place;
}

void Section::fail(std::string_view key, const std::string& message) const {
    fail_at(source_, place_of(key), title_ + ": " + message);
}

void Section::finish(const std::string& why) const {
    for (const TreeNode& child : node_.children) {
        if (!asked_.contains(child.key)) {
            fail_at(source_, child.key_place, fmt::format("{}: {} has no effect {}", title_, child.key, why));
        }
    }
}

const KeySpec& Section::spec_of(std::string_view key, KeyType type) const {
    const KeySpec* spec = spec_.find(key);
    CHECK(spec != nullptr && spec->type == type);
    return *spec;
}

const TreeNode& Section::value_of(const KeySpec& key) {
    asked_.insert(key.name);
    if (const TreeNode* given = node_.find(std::string(key.name))) {
        return *given;
    }
    if (key.default_text == required_key || key.default_text.empty()) {
        fail_at(source_, node_.place,
                fmt::format("{}: {} is missing, expected {}", title_, key.name, describe_expected(key)));
    }
    default_ = parse_tree(fmt::format("value = {}", key.default_text), source_).children.at(0);
    return default_;
}

void Section::wrong(const KeySpec& key, const Value& value) const {
    const std::string expected = value.is_component ? describe_component(key) : describe_expected(key);
    fail_at(
        source_, value.node.place,
        fmt::format("{}: {} is {}, expected {}", title_, value.name, describe_value(value.node), expected));
}

double Section::checked_number(const KeySpec& key, const Value& value) const {
    if (!is_number(value.node) || !is_within(key.range, value.node.number)) {
        wrong(key, value);
    }
    return value.node.number;
}

std::int64_t Section::checked_integer(const KeySpec& key, const Value& value) const {
    if (value.node.kind != TreeKind::integer || !is_within(key.range, value.node.number)) {
        wrong(key, value);
    }
    return value.node.integer;
}

std::vector<double> Section::numbers(const KeySpec& key, std::size_t count) {
    const TreeNode& value = value_of(key);
    if (value.kind != TreeKind::array || value.children.size() != count) {
        wrong(key, {value, std::string(key.name)});
    }
    std::vector<double> result;
    for (std::size_t i = 0; i < count; ++i) {
        result.push_back(checked_number(key, {value.children[i], fmt::format("{}[{}]", key.name, i), true}));
    }
    return result;
}

// --- scalars ---------------------------------------------------------------------------------------------

double Section::number(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::number);
    return checked_number(spec, {value_of(spec), std::string(key)});
}

std::optional<double> Section::optional_number(std::string_view key) {
    return has(key) ? std::optional(number(key)) : std::nullopt;
}

int Section::integer(std::string_view key) {
    return static_cast<int>(long_integer(key));
}

std::int64_t Section::long_integer(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::integer);
    return checked_integer(spec, {value_of(spec), std::string(key)});
}

bool Section::boolean(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::boolean);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::boolean) {
        wrong(spec, {value, std::string(key)});
    }
    return value.boolean;
}

std::string Section::text(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::text);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::text) {
        wrong(spec, {value, std::string(key)});
    }
    // Names and titles stand in one-line messages, in file metadata and in the trajectory.
    const bool has_control =
        std::ranges::any_of(value.text, [](char c) { return static_cast<unsigned char>(c) < 0x20; });
    if (has_control || (value.text.empty() && spec.default_text == required_key)) {
        fail(key, fmt::format("{} is {}, expected a text of one line", key,
                              value.text.empty() ? "empty" : "of several lines"));
    }
    return value.text;
}

std::string Section::lines(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::text);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::text) {
        wrong(spec, {value, std::string(key)});
    }
    if (std::ranges::any_of(value.text, [](char c) { return static_cast<unsigned char>(c) < 0x20 && c != '\n'; })) {
        fail(key, fmt::format("{} has a control character, expected text and \\n", key));
    }
    return value.text;
}

int Section::choice(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::choice);
    const TreeNode& value = value_of(spec);
    const std::vector<std::string> words = choices_of(spec);
    const auto found = std::ranges::find(words, value.text);
    if (value.kind != TreeKind::text || found == words.end()) {
        wrong(spec, {value, std::string(key)});
    }
    return static_cast<int>(found - words.begin());
}

Rational Section::fraction(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::fraction);
    const TreeNode& value = value_of(spec);
    std::optional<Rational> result;
    if (value.kind == TreeKind::integer) {
        result = Rational{value.integer, 1};
    } else if (value.kind == TreeKind::number) {
        result = rational_from_decimal(value.number);
    } else if (value.kind == TreeKind::text) {
        result = parse_rational(value.text);
    }
    const bool is_out = result && !is_within(spec.range, result->value());
    const bool is_lost = !result && (!is_number(value) || !is_within(spec.range, value.number));
    if (is_out || is_lost) {
        wrong(spec, {value, std::string(key)});
    }
    if (!result || result->num > largest_fraction_part || result->den > largest_fraction_part) {
        fail(key, fmt::format("{} is {}, expected a fraction of two integers up to 10^12, such as \"1/60\"",
                              key, describe_value(value)));
    }
    return *result;
}

// --- several numbers -------------------------------------------------------------------------------------

Vec3 Section::vector(std::string_view key) {
    const std::vector<double> x = numbers(spec_of(key, KeyType::vector), 3);
    return {x[0], x[1], x[2]};
}

Vec3 Section::direction(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::direction);
    const std::vector<double> x = numbers(spec, 3);
    const Vec3 v(x[0], x[1], x[2]);
    if (!(v.stableNorm() > 0.0)) {
        fail(key, fmt::format("{} has length 0, expected {}", key, describe_expected(spec)));
    }
    return v.stableNormalized();
}

Quat Section::quaternion(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::quaternion);
    const std::vector<double> x = numbers(spec, 4);
    const double norm = std::hypot(std::hypot(x[0], x[1]), std::hypot(x[2], x[3]));
    // Digits cut off by a person or a program are mended; another number of them is a mistake.
    constexpr double largest_deviation = 1e-3;
    if (!(std::abs(norm - 1.0) <= largest_deviation)) {
        fail(key, fmt::format("{} has length {:.6g}, expected {}", key, norm, describe_expected(spec)));
    }
    return Quat(x[0], x[1], x[2], x[3]).normalized();
}

Quat Section::axis_angle(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::axis_angle);
    const std::vector<double> x = numbers(spec, 4);
    const Vec3 axis(x[0], x[1], x[2]);
    if (!(axis.stableNorm() > 0.0)) {
        fail(key, fmt::format("{} has an axis of length 0, expected {}", key, describe_expected(spec)));
    }
    return Quat(Eigen::AngleAxisd(x[3] * radians_per_degree, axis.stableNormalized()));
}

std::vector<double> Section::moments(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::moments);
    return numbers(spec, value_of(spec).children.size() == 6 ? 6 : 3);
}

Eigen::Vector3i Section::counts(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::counts);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array || value.children.size() != 3) {
        wrong(spec, {value, std::string(key)});
    }
    Eigen::Vector3i result;
    for (int i = 0; i < 3; ++i) {
        const TreeNode& element = value.children[static_cast<std::size_t>(i)];
        result[i] = static_cast<int>(checked_integer(spec, {element, fmt::format("{}[{}]", key, i), true}));
    }
    return result;
}

std::vector<Eigen::Vector2d> Section::checked_pairs(const KeySpec& spec) {
    const TreeNode& value = value_of(spec);
    const std::string_view key = spec.name;
    if (value.kind != TreeKind::array) {
        wrong(spec, {value, std::string(key)});
    }
    std::vector<Eigen::Vector2d> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        const TreeNode& pair = value.children[i];
        const std::string name = fmt::format("{}[{}]", key, i);
        if (pair.kind != TreeKind::array || pair.children.size() != 2) {
            wrong(spec, {pair, name});
        }
        result.emplace_back(checked_number(spec, {pair.children[0], name + "[0]", true}),
                            checked_number(spec, {pair.children[1], name + "[1]", true}));
    }
    return result;
}

std::vector<Eigen::Vector2d> Section::pairs(std::string_view key) {
    return checked_pairs(spec_of(key, KeyType::pairs));
}

std::vector<Eigen::Vector2d> Section::profile(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::profile);
    std::vector<Eigen::Vector2d> points = checked_pairs(spec);
    const TreeNode& value = value_of(spec);
    if (points.size() < 2) {
        wrong(spec, {value, std::string(key)});
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (points[i].x() < 0.0 || (i > 0 && points[i].y() < points[i - 1].y())) {
            fail_at(source_, value.children[i].place,
                    fmt::format("{}: {}[{}] is [{}, {}], expected radius >= 0 and z not below that of the point before", title_,
                                key, i, points[i].x(), points[i].y()));
        }
    }
    return points;
}

std::vector<Vec3> Section::points(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::points);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array) {
        wrong(spec, {value, std::string(key)});
    }
    std::vector<Vec3> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        const TreeNode& point = value.children[i];
        const std::string name = fmt::format("{}[{}]", key, i);
        if (point.kind != TreeKind::array || point.children.size() != 3) {
            fail_at(source_, point.place,
                    fmt::format("{}: {} is {}, expected three finite numbers [{}]", title_, name,
                                describe_value(point), spec.unit));
        }
        Vec3 x;
        for (int k = 0; k < 3; ++k) {
            const TreeNode& element = point.children[static_cast<std::size_t>(k)];
            x[k] = checked_number(spec, {element, fmt::format("{}[{}]", name, k), true});
        }
        result.push_back(x);
    }
    return result;
}

// --- colours ---------------------------------------------------------------------------------------------

Vec3 Section::checked_color(const KeySpec& key, const Value& value) const {
    Vec3 result;
    if (value.node.kind == TreeKind::text) {
        // "#rrggbb", sRGB
        const std::string& text = value.node.text;
        std::uint32_t rgb = 0;
        const char* end = text.data() + text.size();
        if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, rgb, 16).ptr != end) {
            wrong(key, value);
        }
        for (int i = 0; i < 3; ++i) {
            result[i] = linear_from_srgb(((rgb >> (8 * (2 - i))) & 0xFF) / 255.0);
        }
        return result;
    }
    if (value.node.kind != TreeKind::array || value.node.children.size() != 3) {
        wrong(key, value);
    }
    for (int i = 0; i < 3; ++i) {
        const TreeNode& element = value.node.children[static_cast<std::size_t>(i)];
        result[i] = checked_number(key, {element, fmt::format("{}[{}]", value.name, i), true});
    }
    return result;
}

Vec3 Section::color(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::color);
    return checked_color(spec, {value_of(spec), std::string(key)});
}

std::vector<Vec3> Section::colors(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::colors);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array || value.children.empty()) {
        wrong(spec, {value, std::string(key)});
    }
    std::vector<Vec3> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        result.push_back(checked_color(spec, {value.children[i], fmt::format("{}[{}]", key, i)}));
    }
    return result;
}

// --- names and tables ------------------------------------------------------------------------------------

std::vector<std::string> Section::names(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::names);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array || value.children.empty() || value.children.size() > 2) {
        wrong(spec, {value, std::string(key)});
    }
    std::vector<std::string> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        if (value.children[i].kind != TreeKind::text) {
            wrong(spec, {value.children[i], fmt::format("{}[{}]", key, i)});
        }
        result.push_back(value.children[i].text);
    }
    return result;
}

std::vector<std::string> Section::texts(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::texts);
    if (!has(key)) {
        return {};
    }
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array || value.children.empty()) {
        wrong(spec, {value, std::string(key)});
    }
    std::vector<std::string> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        if (value.children[i].kind != TreeKind::text) {
            wrong(spec, {value.children[i], fmt::format("{}[{}]", key, i)});
        }
        result.push_back(value.children[i].text);
    }
    return result;
}

std::vector<int> Section::words(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::words);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array) {
        wrong(spec, {value, std::string(key)});
    }
    const std::vector<std::string> known = choices_of(spec);
    std::vector<int> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        const TreeNode& word = value.children[i];
        const std::string name = fmt::format("{}[{}]", key, i);
        if (word.kind != TreeKind::text) {
            wrong(spec, {word, name});
        }
        const auto found = std::ranges::find(known, word.text);
        if (found == known.end()) {
            fail_at(source_, word.place,
                    fmt::format("{}: {} is \"{}\", expected a known word{}", title_, name, word.text,
                                suggestion(word.text, known)));
        }
        result.push_back(static_cast<int>(found - known.begin()));
    }
    return result;
}

std::array<double, 2> Section::interval(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::interval);
    const std::vector<double> ends = numbers(spec, 2);
    if (!(ends[0] < ends[1])) {
        wrong(spec, {value_of(spec), std::string(key)});
    }
    return {ends[0], ends[1]};
}

const TreeNode& Section::table(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::table);
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::table) {
        wrong(spec, {value, std::string(key)});
    }
    return value;
}

std::vector<const TreeNode*> Section::tables(std::string_view key) {
    const KeySpec& spec = spec_of(key, KeyType::tables);
    if (spec.default_text != required_key && !has(key)) {
        asked_.insert(spec.name);
        return {};
    }
    const TreeNode& value = value_of(spec);
    if (value.kind != TreeKind::array || (value.children.empty() && spec.default_text == required_key)) {
        wrong(spec, {value, std::string(key)});
    }
    std::vector<const TreeNode*> result;
    for (std::size_t i = 0; i < value.children.size(); ++i) {
        if (value.children[i].kind != TreeKind::table) {
            wrong(spec, {value.children[i], fmt::format("{}[{}]", key, i)});
        }
        result.push_back(&value.children[i]);
    }
    return result;
}

} // namespace sim
