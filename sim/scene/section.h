#pragma once
/// Reads the values of one table of a scene file by its part of the key table: types, ranges, defaults, and
/// the message for whatever is wrong.
#include "sim/base/math.h"
#include "sim/base/rational.h"
#include "sim/scene/keys.h"
#include "sim/scene/tree.h"

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sim {

/// Every getter throws Error (usage) for a value of the wrong type or out of range, and for a key that is
/// missing but required; a key left out gives its default. Keys are those of the SectionSpec: CHECK.
class Section {
public:
    /// title: how messages call the table, "body 'cube'". Throws Error (usage) for a key the table does not
    /// know.
    Section(const TextSource& source, const TreeNode& node, const SectionSpec& spec, std::string title);

    bool has(std::string_view key) const;
    double number(std::string_view key);
    int integer(std::string_view key);
    std::int64_t long_integer(std::string_view key);
    bool boolean(std::string_view key);
    /// Of one line.
    std::string text(std::string_view key);
    /// Lines end at "\n".
    std::string lines(std::string_view key);
    /// Index of the word among the key's choices.
    int choice(std::string_view key);
    Rational fraction(std::string_view key);
    Vec3 vector(std::string_view key);
    /// Unit.
    Vec3 direction(std::string_view key);
    /// Unit.
    Quat quaternion(std::string_view key);
    /// Rotation by an axis and an angle in degrees.
    Quat axis_angle(std::string_view key);
    /// 3 or 6.
    std::vector<double> moments(std::string_view key);
    Eigen::Vector3i counts(std::string_view key);
    /// Linear RGB.
    Vec3 color(std::string_view key);
    std::vector<Vec3> colors(std::string_view key);
    std::vector<Eigen::Vector2d> pairs(std::string_view key);
    /// Radius and z of at least two points, from bottom to top.
    std::vector<Eigen::Vector2d> profile(std::string_view key);
    /// Any number of them.
    std::vector<Vec3> points(std::string_view key);
    /// 1 or 2.
    std::vector<std::string> names(std::string_view key);
    std::vector<std::string> texts(std::string_view key);
    /// Indices among the key's choices, in the order given.
    std::vector<int> words(std::string_view key);
    /// Ascending.
    std::array<double, 2> interval(std::string_view key);
    const TreeNode& table(std::string_view key);
    /// Empty if left out.
    std::vector<const TreeNode*> tables(std::string_view key);

    std::optional<double> optional_number(std::string_view key);

    /// Throws Error (usage) for a key that is there but was never asked for: it has no effect, `why` ("in a
    /// static body").
    void finish(const std::string& why) const;

    /// Throws Error (usage) at the key's value, or at the table if it was left out: "<place>: <title>:
    /// <message>".
    [[noreturn]] void fail(std::string_view key, const std::string& message) const;

    const std::string& title() const { return title_; }
    const TextSource& source() const { return source_; }
    const TreeNode& node() const { return node_; }
    TextPlace place_of(std::string_view key) const;

private:
    /// A value with the name it has in messages: "position[1]".
    struct Value {
        const TreeNode& node;
        std::string name;
        bool is_component = false; ///< one number of several
    };

    const KeySpec& spec_of(std::string_view key, KeyType type) const;
    /// The given value, or the default; throws if the key is required and missing.
    const TreeNode& value_of(const KeySpec& key);
    [[noreturn]] void wrong(const KeySpec& key, const Value& value) const;
    double checked_number(const KeySpec& key, const Value& value) const;
    std::int64_t checked_integer(const KeySpec& key, const Value& value) const;
    std::vector<double> numbers(const KeySpec& key, std::size_t count);
    std::vector<Eigen::Vector2d> checked_pairs(const KeySpec& spec);
    Vec3 checked_color(const KeySpec& key, const Value& value) const;

    const TextSource& source_;
    const TreeNode& node_;
    const SectionSpec& spec_;
    std::string title_;
    std::set<std::string_view> asked_;
    TreeNode default_; ///< the last default that was parsed
};

} // namespace sim
