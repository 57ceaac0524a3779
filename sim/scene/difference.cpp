#include "sim/scene/difference.h"

#include "sim/base/rational.h"
#include "sim/scene/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

namespace sim {

namespace {

TreeNode tree_of(const SceneSource& scene) {
    const TextSource source{"scene", {scene.overrides.begin(), scene.overrides.end()}};
    TreeNode root = parse_tree(scene.text, source);
    for (std::size_t i = 0; i < scene.overrides.size(); ++i) {
        apply_assignment(root, source, static_cast<int>(i));
    }
    return root;
}

/// "body.cube", "body[3]", "output.fps"
std::string path_of(const std::string& parent, const TreeNode& node, std::size_t index) {
    if (!node.key.empty()) {
        return parent.empty() ? node.key : parent + "." + node.key;
    }
    const TreeNode* name = node.kind == TreeKind::table ? node.find("name") : nullptr;
    return name != nullptr ? parent + "." + name->text : fmt::format("{}[{}]", parent, index);
}

/// A number, or a fraction written as text: 60, 60.0 and "60/1" mean the same.
std::optional<Rational> fraction_of(const TreeNode& node) {
    switch (node.kind) {
    case TreeKind::integer:
        return Rational{node.integer, 1};
    case TreeKind::number:
        return rational_from_decimal(node.number);
    case TreeKind::text:
        return parse_rational(node.text);
    default:
        return std::nullopt;
    }
}

std::string table_difference(const TreeNode& now, const TreeNode& before, const std::string& path);

/// Of short arrays, the words and numbers in them, if no array or table is.
std::string whole_value(const TreeNode& node) {
    const auto is_nested = [](const TreeNode& child) { return child.kind == TreeKind::table || child.kind == TreeKind::array; };
    constexpr std::size_t most_shown = 8;
    if (node.kind != TreeKind::array || node.children.size() > most_shown || std::ranges::any_of(node.children, is_nested)) {
        return describe_value(node);
    }
    std::string text;
    for (const TreeNode& child : node.children) {
        text += (text.empty() ? "" : ", ") + describe_value(child);
    }
    return "[" + text + "]";
}

/// The first element of `these` that has a name which no element of `those` has; null if there is none.
const TreeNode* only_in(const std::vector<TreeNode>& these, const std::vector<TreeNode>& those) {
    const auto name_of = [](const TreeNode& node) {
        const TreeNode* name = node.find("name");
        return name != nullptr ? name->text : std::string();
    };
    const auto found = std::ranges::find_if(these, [&](const TreeNode& node) {
        return !name_of(node).empty() && std::ranges::find(those, name_of(node), name_of) == those.end();
    });
    return found == these.end() ? nullptr : &*found;
}

/// Of arrays of other lengths.
std::string length_difference(const TreeNode& now, const TreeNode& before, const std::string& path) {
    if (const TreeNode* added = only_in(now.children, before.children)) {
        return path_of(path, *added, 0) + " is new";
    }
    if (const TreeNode* removed = only_in(before.children, now.children)) {
        return path_of(path, *removed, 0) + " is gone";
    }
    return fmt::format("{} is {}, was {}", path, whole_value(now), whole_value(before));
}

// The first difference between two values; both stand at `path`.
std::string value_difference(const TreeNode& now, const TreeNode& before, const std::string& path) {
    const std::optional<Rational> fraction = fraction_of(now);
    const bool are_texts = now.kind == TreeKind::text && before.kind == TreeKind::text;
    if (!are_texts && fraction && fraction == fraction_of(before)) {
        return "";
    }
    if (now.kind == before.kind) {
        switch (now.kind) {
        case TreeKind::table:
            return table_difference(now, before, path);
        case TreeKind::array:
            if (now.children.size() != before.children.size()) {
                return length_difference(now, before, path);
            }
            for (std::size_t i = 0; i < now.children.size(); ++i) {
                const std::string found =
                    value_difference(now.children[i], before.children[i], path_of(path, now.children[i], i));
                if (!found.empty()) {
                    return found;
                }
            }
            return "";
        case TreeKind::boolean:
            if (now.boolean == before.boolean) {
                return "";
            }
            break;
        case TreeKind::text:
        case TreeKind::date:
            if (now.text == before.text) {
                return "";
            }
            break;
        case TreeKind::integer:
        case TreeKind::number:
            if (now.number == before.number) { // too large for a fraction
                return "";
            }
            break;
        }
    }
    return fmt::format("{} is {}, was {}", path, describe_value(now), describe_value(before));
}

std::string table_difference(const TreeNode& now, const TreeNode& before, const std::string& path) {
    const TreeNode nothing; // a table without keys means the same as none
    for (std::size_t i = 0; i < now.children.size(); ++i) {
        const TreeNode& child = now.children[i];
        const TreeNode* other = before.find(child.key);
        const std::string child_path = path_of(path, child, i);
        std::string found;
        if (other != nullptr) {
            found = value_difference(child, *other, child_path);
        } else if (child.kind == TreeKind::table) {
            found = table_difference(child, nothing, child_path);
        } else {
            found = fmt::format("{} is {}, was not set", child_path, whole_value(child));
        }
        if (!found.empty()) {
            return found;
        }
    }
    for (std::size_t i = 0; i < before.children.size(); ++i) {
        const TreeNode& child = before.children[i];
        if (now.find(child.key) != nullptr) {
            continue;
        }
        const std::string child_path = path_of(path, child, i);
        const std::string found =
            child.kind == TreeKind::table
                ? table_difference(nothing, child, child_path)
                : fmt::format("{} is not set, was {}", child_path, whole_value(child));
        if (!found.empty()) {
            return found;
        }
    }
    return "";
}

} // namespace

std::string scene_difference(const SceneSource& now, const SceneSource& before) {
    return table_difference(tree_of(now), tree_of(before), "");
}

} // namespace sim
