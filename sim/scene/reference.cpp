#include "sim/scene/file.h"
#include "sim/scene/keys.h"

#include <fmt/format.h>

namespace sim {

namespace {

std::string code(std::string_view text) {
    return text.empty() ? "" : fmt::format("`{}`", text);
}

std::string default_of(const KeySpec& key) {
    return key.default_text == required_key ? "required" : code(key.default_text);
}

} // namespace

std::string scene_key_reference() {
    std::string page = R"(# Scene files

A scene is one TOML file. Every key is listed here with what it expects and its default; a key that is not listed, a
value of another kind or out of range, or a name that does not exist is an error with its line and column. This page
is made from the parser's own table.

Units are SI, z is up. Angles are in degrees and their keys end in `_degrees`. Times and rates are exact: `0.001` is
one thousandth, and `"1/240"` or `"24000/1001"` may be written as a text. Colours are linear red, green, blue from 0 to
1, or a text `"#rrggbb"` in sRGB.

Any value can be set from the command line: `--set simulation.tolerance=1e-5`, `--set body.ball.mass=2`,
`--set body.3.velocity.0=1.5` (elements of arrays by name or by number from 0; the value is TOML, quotes around a word
may be left out).
)";
    for (const SectionSpec& section : scene_sections()) {
        page += fmt::format("\n## {}\n\n{}\n\n",
                            section.path.empty() ? "Top of the file" : code(section.header), section.meaning);
        page += "| key | expects | default | meaning |\n| --- | --- | --- | --- |\n";
        for (const KeySpec& key : section.keys) {
            page += fmt::format("| `{}` | {} | {} | {} |\n", key.name, describe_expected(key),
                                default_of(key), key.meaning);
        }
    }
    return page;
}

} // namespace sim
