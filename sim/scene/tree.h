#pragma once
/// The values of a scene file as a tree in which every value knows its place. tree.cpp is the only user
/// of toml++: no other file pays for its header.
#include <cstdint>
#include <string>
#include <vector>

namespace sim {

/// Where a value was written: in the file, or in one of the overrides.
struct TextPlace {
    int line = 0;        ///< from 1
    int column = 0;      ///< from 1
    int assignment = -1; ///< index of the override it came from; -1: the file
};

enum class TreeKind { table, array, text, integer, number, boolean, date };

/// One value. Which fields mean something depends on kind.
struct TreeNode {
    TreeKind kind = TreeKind::table;
    TextPlace place;                ///< of the value
    TextPlace key_place;            ///< of its key, where it has one
    std::string key;                ///< in its table; empty in an array
    std::vector<TreeNode> children; ///< table: in the order of the text; array: its elements
    std::string text;
    std::int64_t integer = 0;
    double number = 0.0; ///< of an integer also
    bool boolean = false;

    /// The value with this key, or null.
    const TreeNode* find(const std::string& name) const;
};

/// Where the text of a tree came from; turns a place into the beginning of a message.
struct TextSource {
    std::string file;                     ///< as shown in messages
    std::vector<std::string> assignments; ///< overrides: "dotted.key=value"

    /// "file:line:column", or "--set dotted.key=value" for a value that came from an override.
    std::string describe(const TextPlace& place) const;
};

/// Throws Error (usage): "<place>: <message>".
[[noreturn]] void fail_at(const TextSource& source, const TextPlace& place, const std::string& message);

/// A value in a few words for a message: `0.5`, `"heavy"`, `an array of 2 values`.
std::string describe_value(const TreeNode& node);

/// Reads TOML text. Throws Error (usage) with the place and toml++'s own words.
TreeNode parse_tree(const std::string& text, const TextSource& source);

/// Sets or adds the value of source.assignments[index], "dotted.key=value". An element of an array is named
/// by its index or, when its elements are tables, by the value of their key "name"; a segment may be quoted.
/// The value is TOML; a bare word is taken as text. Throws Error (usage).
void apply_assignment(TreeNode& root, const TextSource& source, int index);

/// "; did you mean 'x'?" if one of `names` is a few edits (insert, delete, replace, swap of neighbours) from `found`, else
/// nothing.
std::string near_miss(const std::string& found, const std::vector<std::string>& names);

/// How a message about an unknown name ends: near_miss(), else "; expected one of: ..." if there are few names, else nothing.
std::string suggestion(const std::string& found, const std::vector<std::string>& names);

} // namespace sim
