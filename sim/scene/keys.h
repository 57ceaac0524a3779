#pragma once
/// Every key a scene file may have, in one table: the parser, its suggestions and the reference page are made
/// of it.
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sim {

/// What may stand behind a key.
enum class KeyType {
    number, ///< finite
    integer,
    boolean,
    text,
    choice,     ///< one of a few words
    fraction,   ///< a number, or "24000/1001"; kept exactly
    vector,     ///< three numbers
    direction,  ///< three numbers, not all zero; normalised
    quaternion, ///< w x y z, of length 1 within 1e-3; normalised
    axis_angle, ///< an axis x y z, not all zero, and an angle
    moments,    ///< three or six numbers
    counts,     ///< three integers
    color,      ///< three numbers (linear RGB) or "#rrggbb" (sRGB)
    colors,     ///< array of those
    pairs,      ///< array of pairs of numbers
    profile,    ///< array of pairs radius, z
    points,     ///< array of triples of numbers
    names,      ///< array of one or two texts
    texts,      ///< array of texts
    words,      ///< array of some of a few words
    interval,   ///< array of two ascending numbers
    table,      ///< [name]
    tables,     ///< [[name]], any number of them
};

/// Allowed values of a number, of the components of a vector, or of integers.
struct KeyRange {
    double lower = -std::numeric_limits<double>::infinity();
    double upper = std::numeric_limits<double>::infinity();
    bool is_lower_open = false; ///< lower itself is not allowed
};

/// Marks a key that must be given.
inline constexpr std::string_view required_key = "required";

struct KeySpec {
    std::string_view name;
    KeyType type = KeyType::number;
    std::string_view unit;         ///< "m", "kg m^2"; empty: none
    std::string_view default_text; ///< TOML; empty: may be left out and then means nothing; or required_key
    std::string_view meaning;
    KeyRange range;
    std::string_view
        choices; ///< "ahead stop", in the order of the enumeration; of a table: how it is written
};

/// One table of the scene file.
struct SectionSpec {
    std::string_view path;   ///< "simulation", "body.shape box"; empty: the top of the file
    std::string_view header; ///< as written: "[simulation]", "[[body]]"
    std::string_view meaning;
    std::vector<KeySpec> keys;

    const KeySpec* find(std::string_view name) const;
    std::vector<std::string> key_names() const;
};

/// All tables, in the order of the reference.
std::span<const SectionSpec> scene_sections();

/// CHECKs that it exists.
const SectionSpec& scene_section(std::string_view path);

/// What a key expects, for a message: "a number > 0 [kg]".
std::string describe_expected(const KeySpec& key);

/// The same for one number of several.
std::string describe_component(const KeySpec& key);

/// The words of KeySpec::choices.
std::vector<std::string> choices_of(const KeySpec& key);

} // namespace sim
