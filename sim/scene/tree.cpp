#include "sim/scene/tree.h"

#include "sim/base/error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace sim {

namespace {

TextPlace place_of(const toml::source_region& region) {
    return {static_cast<int>(region.begin.line), static_cast<int>(region.begin.column), -1};
}

// --- depth of keys
// -----------------------------------------------------------------------------------------

/// Parts of a dotted key. toml++, and what walks its tables, calls itself once a part; it limits brackets only.
constexpr int most_parts = 32;

/// Index of the last character of the string that begins at `at`, or of the text.
std::size_t end_of_string(const std::string& text, std::size_t at) {
    const char quote = text[at];
    const bool has_lines = text.compare(at, 3, std::string(3, quote)) == 0;
    const std::string end = has_lines ? std::string(3, quote) : std::string(1, quote);
    for (std::size_t i = at + end.size(); i < text.size(); ++i) {
        if (text[i] == '\\' && quote == '"') {
            ++i;
        } else if (text[i] == '\n' && !has_lines) {
            return i - 1;
        } else if (text.compare(i, end.size(), end) == 0) {
            std::size_t last = i + end.size() - 1;
            while (has_lines && last + 1 < text.size() && text[last + 1] == quote) {
                ++last; // quotes may stand before the three that end it
            }
            return last;
        }
    }
    return text.size() - 1;
}

/// Index of the first key of more parts than that, or npos.
std::size_t find_deep_key(const std::string& text) {
    int parts = 1;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '#') {
            i = std::min(text.find('\n', i), text.size()) - 1;
        } else if (c == '"' || c == '\'') {
            i = end_of_string(text, i);
        } else if (c == '.') {
            if (++parts > most_parts) {
                return i;
            }
        } else if (std::string_view("\n,=[]{}").find(c) != std::string_view::npos) {
            parts = 1;
        }
    }
    return std::string::npos;
}

// --- toml++ -> TreeNode
// ---------------------------------------------------------------------------------------

TreeNode tree_of(const toml::node& node) {
    TreeNode result;
    result.place = place_of(node.source());
    if (const toml::table* table = node.as_table()) {
        result.kind = TreeKind::table;
        for (const auto& [key, value] : *table) {
            TreeNode child = tree_of(value);
            child.key = std::string(key.str());
            child.key_place = place_of(key.source());
            // A table opened by a dotted key has no place of its own.
            if (child.place.line == 0) {
                child.place = child.key_place;
            }
            result.children.push_back(std::move(child));
        }
        // toml++ sorts by key; here the order is that of the text.
        std::ranges::stable_sort(result.children, [](const TreeNode& a, const TreeNode& b) {
            return std::pair(a.key_place.line, a.key_place.column) <
                   std::pair(b.key_place.line, b.key_place.column);
        });
    } else if (const toml::array* array = node.as_array()) {
        result.kind = TreeKind::array;
        for (const toml::node& element : *array) {
            result.children.push_back(tree_of(element));
        }
    } else if (const auto* text = node.as_string()) {
        result.kind = TreeKind::text;
        result.text = text->get();
    } else if (const auto* integer = node.as_integer()) {
        result.kind = TreeKind::integer;
        result.integer = integer->get();
        result.number = static_cast<double>(integer->get());
    } else if (const auto* number = node.as_floating_point()) {
        result.kind = TreeKind::number;
        result.number = number->get();
    } else if (const auto* boolean = node.as_boolean()) {
        result.kind = TreeKind::boolean;
        result.boolean = boolean->get();
    } else {
        result.kind = TreeKind::date;
    }
    return result;
}

/// Marks a value and all below it as coming from an override.
void mark(TreeNode& node, int index) {
    node.place = node.key_place = {0, 0, index};
    for (TreeNode& child : node.children) {
        mark(child, index);
    }
}

// --- overrides -------------------------------------------------------------------------------------------

/// "a.'b c'.0 = value" split into its segments and the text of the value.
struct Assignment {
    std::vector<std::string> path;
    std::string value;
};

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// Empty path if it is not of that form.
Assignment split_assignment(const std::string& text) {
    Assignment result;
    std::string segment;
    bool is_quoted = false;
    char quote = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quote != 0) {
            if (c == quote) {
                quote = 0;
            } else {
                segment += c;
            }
        } else if (c == '"' || c == '\'') {
            quote = c;
            is_quoted = true;
        } else if (c == '.' || c == '=') {
            segment = is_quoted ? segment : trimmed(segment);
            if (segment.empty()) {
                return {};
            }
            result.path.push_back(segment);
            segment.clear();
            is_quoted = false;
            if (c == '=') {
                result.value = trimmed(text.substr(i + 1));
                return result.value.empty() ? Assignment{} : result;
            }
        } else if (!is_quoted || (c != ' ' && c != '\t')) {
            segment += c;
        }
    }
    return {};
}

/// A word such as stop, 1/240 or #ff8800 is text even without its quotes, which a shell takes away.
bool is_bare_word(const std::string& text) {
    return std::ranges::none_of(
        text, [](char c) { return std::string_view("\"'[]{}=,\n\r\\").find(c) != std::string_view::npos; });
}

TreeNode parse_value(const std::string& text, const TextSource& source, const TextPlace& place) {
    if (find_deep_key(text) != std::string::npos) {
        fail_at(source, place, fmt::format("a key has too many parts, expected at most {}", most_parts));
    }
    try {
        const toml::table table = toml::parse("value = " + text + "\n");
        if (table.size() != 1) {
            fail_at(source, place, "expected one value after '='");
        }
        return tree_of(*table.get("value"));
    } catch (const toml::parse_error& error) {
        if (!is_bare_word(text)) {
            fail_at(source, place, fmt::format("the value is not TOML: {}", error.description()));
        }
        TreeNode word;
        word.kind = TreeKind::text;
        word.text = text;
        return word;
    }
}

/// Element of an array by index or by its key "name"; null if there is none.
TreeNode* find_element(TreeNode& array, const std::string& segment) {
    for (TreeNode& element : array.children) {
        const TreeNode* name = element.find("name");
        if (name != nullptr && name->kind == TreeKind::text && name->text == segment) {
            return &element;
        }
    }
    std::size_t index = 0;
    const auto [end, status] = std::from_chars(segment.data(), segment.data() + segment.size(), index);
    const bool is_index = status == std::errc() && end == segment.data() + segment.size();
    return is_index && index < array.children.size() ? &array.children[index] : nullptr;
}

std::vector<std::string> names_of_elements(const TreeNode& array) {
    std::vector<std::string> names;
    for (const TreeNode& element : array.children) {
        const TreeNode* name = element.find("name");
        if (name != nullptr && name->kind == TreeKind::text) {
            names.push_back(name->text);
        }
    }
    return names;
}

std::string joined(const std::vector<std::string>& path, std::size_t count) {
    std::string result;
    for (std::size_t i = 0; i < count; ++i) {
        result += (i == 0 ? "" : ".") + path[i];
    }
    return result;
}

/// Damerau's distance (neighbours swapped only), row by row through the table of the words' beginnings.
std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> two_back;
    std::vector<std::size_t> back;
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) {
        row[j] = j;
    }
    for (std::size_t i = 1; i <= a.size(); ++i) {
        two_back = std::exchange(back, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({back[j] + 1, row[j - 1] + 1, back[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
                row[j] = std::min(row[j], two_back[j - 2] + 1);
            }
        }
    }
    return row[b.size()];
}

} // namespace

const TreeNode* TreeNode::find(const std::string& name) const {
    const auto found = std::ranges::find(children, name, &TreeNode::key);
    return kind != TreeKind::table || found == children.end() ? nullptr : &*found;
}

std::string TextSource::describe(const TextPlace& place) const {
    if (place.assignment >= 0) {
        return "--set " + assignments[static_cast<std::size_t>(place.assignment)];
    }
    return place.line > 0 ? fmt::format("{}:{}:{}", file, place.line, place.column) : file;
}

void fail_at(const TextSource& source, const TextPlace& place, const std::string& message) {
    // One line, whatever names and TOML's own words contain.
    std::string line = source.describe(place) + ": " + message;
    for (std::size_t at = 0; (at = line.find('\n', at)) != std::string::npos; ++at) {
        line.replace(at, 1, "\\n");
    }
    std::ranges::replace_if(line, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
    throw Error(ExitCode::usage, line);
}

std::string describe_value(const TreeNode& node) {
    switch (node.kind) {
    case TreeKind::table:
        return "a table";
    case TreeKind::array:
        return node.children.empty() ? "an empty array"
                                     : fmt::format("an array of {} value{}", node.children.size(),
                                                   node.children.size() == 1 ? "" : "s");
    case TreeKind::text: {
        // A long text is cut at a whole character of UTF-8.
        constexpr std::size_t longest = 40;
        std::size_t length = std::min(node.text.size(), longest);
        while (length < node.text.size() && (static_cast<unsigned char>(node.text[length]) & 0xC0) == 0x80) {
            --length;
        }
        std::string shown = node.text.substr(0, length);
        std::ranges::replace_if(
            shown, [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
        return fmt::format("\"{}{}\"", shown, length < node.text.size() ? "..." : "");
    }
    case TreeKind::integer:
        return fmt::format("{}", node.integer);
    case TreeKind::number:
        return std::isnan(node.number) ? "nan" : fmt::format("{}", node.number);
    case TreeKind::boolean:
        return node.boolean ? "true" : "false";
    case TreeKind::date:
        break;
    }
    return "a date or time";
}

TreeNode parse_tree(const std::string& text, const TextSource& source) {
    if (const std::size_t deep = find_deep_key(text); deep != std::string::npos) {
        const std::size_t line_start = text.rfind('\n', deep) + 1; // 0 if there is none
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(deep), '\n');
        fail_at(source, {static_cast<int>(line), static_cast<int>(deep - line_start) + 1, -1},
                fmt::format("a key has too many parts, expected at most {}", most_parts));
    }
    try {
        return tree_of(toml::parse(text));
    } catch (const toml::parse_error& error) {
        fail_at(source, place_of(error.source()), fmt::format("not TOML: {}", error.description()));
    }
}

void apply_assignment(TreeNode& root, const TextSource& source, int index) {
    const TextPlace place{0, 0, index};
    const Assignment assignment = split_assignment(source.assignments[static_cast<std::size_t>(index)]);
    const std::vector<std::string>& path = assignment.path;
    if (path.empty()) {
        fail_at(source, place, "expected dotted.key=value");
    }
    if (path.size() > most_parts) {
        fail_at(source, place, fmt::format("a key has {} parts, expected at most {}", path.size(), most_parts));
    }
    TreeNode value = parse_value(assignment.value, source, place);
    // Walk down to the value, adding the tables that are not there.
    TreeNode* node = &root;
    for (std::size_t i = 0; i < path.size(); ++i) {
        if (node->kind == TreeKind::array) {
            TreeNode* element = find_element(*node, path[i]);
            if (element == nullptr) {
                fail_at(source, place,
                        fmt::format("{} has no element '{}', expected a name or an index below {}{}",
                                    joined(path, i), path[i], node->children.size(),
                                    suggestion(path[i], names_of_elements(*node))));
            }
            node = element;
        } else if (node->kind == TreeKind::table) {
            if (node->find(path[i]) == nullptr) {
                TreeNode added;
                added.key = path[i];
                mark(added, index);
                node->children.push_back(added);
            }
            node = &*std::ranges::find(node->children, path[i], &TreeNode::key);
        } else {
            fail_at(
                source, place,
                fmt::format("{} is {}, it has no key '{}'", joined(path, i), describe_value(*node), path[i]));
        }
    }
    value.key = node->key;
    mark(value, index);
    *node = std::move(value);
}

std::string near_miss(const std::string& found, const std::vector<std::string>& names) {
    constexpr std::size_t most_edits = 3; // more than that is another word
    std::string nearest;
    std::size_t least = std::min(most_edits, found.size() / 2) + 1;
    for (const std::string& name : names) {
        const std::size_t edits = edit_distance(found, name);
        if (edits < least) {
            nearest = name;
            least = edits;
        }
    }
    return nearest.empty() ? "" : fmt::format("; did you mean '{}'?", nearest);
}

std::string suggestion(const std::string& found, const std::vector<std::string>& names) {
    constexpr std::size_t most_listed = 32;
    const std::string nearest = near_miss(found, names);
    const bool is_listed = nearest.empty() && !names.empty() && names.size() <= most_listed;
    return is_listed ? fmt::format("; expected one of: {}", fmt::join(names, ", ")) : nearest;
}

} // namespace sim
