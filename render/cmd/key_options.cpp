#include "render/cmd/key_options.h"

#include "render/cmd/options.h"
#include "sim/base/error.h"
#include "sim/base/rational.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace cmd {

namespace {

/// A value in TOML; none where the text is not what is expected.
using Value = std::optional<std::string>;

Value toml_text(const std::string& text) {
    std::string result = "\"";
    for (const char letter : text) {
        const auto byte = static_cast<unsigned char>(letter);
        if (byte < 0x20 || byte == 0x7f) {
            result += fmt::format("\\u{:04x}", byte);
        } else {
            result += letter == '"' || letter == '\\' ? std::string("\\") + letter : std::string(1, letter);
        }
    }
    return result + "\"";
}

/// "a,b" -> ["a", "b"]; "none" -> [].
Value toml_words(const std::string& text) {
    std::string list;
    std::string_view words = text == "none" ? std::string_view() : text;
    while (!words.empty()) {
        const std::size_t end = std::min(words.find(','), words.size());
        list += (list.empty() ? "" : ", ") + *toml_text(std::string(words.substr(0, end)));
        words.remove_prefix(std::min(end + 1, words.size()));
    }
    return "[" + list + "]";
}

Value toml_count(const std::string& text) {
    const std::optional<long> value = parse_integer(text);
    return value && *value >= 0 ? Value(fmt::format("{}", *value)) : std::nullopt;
}

Value toml_fraction(const std::string& text) {
    const std::optional<sim::Rational> value = sim::parse_rational(text);
    if (!value || value->num <= 0) {
        return std::nullopt;
    }
    return value->den == 1 ? fmt::format("{}", value->num) : fmt::format("\"{}/{}\"", value->num, value->den);
}

Value toml_positive(const std::string& text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_whole = error == std::errc() && end == text.data() + text.size();
    return is_whole && std::isfinite(value) && value > 0 ? Value(fmt::format("{}", value)) : std::nullopt;
}

/// Before or after the x of "1280x720"; none unless both are integers.
Value side(const std::string& size, bool is_width) {
    const std::size_t cross = std::min(size.find('x'), size.size());
    const std::string width = size.substr(0, cross);
    const std::string height = size.substr(std::min(cross + 1, size.size()));
    return parse_integer(width) && parse_integer(height) ? Value(is_width ? width : height) : std::nullopt;
}

Value toml_width(const std::string& size) {
    return side(size, true);
}

Value toml_height(const std::string& size) {
    return side(size, false);
}

/// One option and the key that it sets; an option of two keys has two rows, one after the other.
struct KeyOption {
    const char* option;
    const char* type;    ///< of its value, in --help
    const char* meaning; ///< in --help
    std::string Options::* text;
    const char* key;
    Value (*toml)(const std::string& text);
    const char* expected; ///< where toml() returns none; null: it takes any text
    bool is_simulated;    ///< only before the simulation
};

constexpr const char* size_help = "Size of a frame [px], such as 1280x720";
constexpr const char* size_expected = "width and height in pixels such as 1280x720";

constexpr KeyOption key_options[] = {
    {"--size", "WxH", size_help, &Options::size, "output.width", toml_width, size_expected, false},
    {"--size", "WxH", size_help, &Options::size, "output.height", toml_height, size_expected, false},
    {"--fps", "N", "Frames a second: a number or a fraction such as 24000/1001", &Options::fps, "output.fps",
     toml_fraction, "a number or a fraction such as 24000/1001, > 0", false},
    {"--duration", "S", "Length of the film [s]", &Options::duration, "output.duration", toml_fraction,
     "a number of seconds > 0", false},
    {"--time-step", "S", "Time step h [s]; independent of the frame rate", &Options::time_step,
     "simulation.time_step", toml_fraction, "a number of seconds > 0", true},
    {"--tolerance", "M", "Largest gap error and overlap [m]", &Options::tolerance, "simulation.tolerance",
     toml_positive, "a number of metres > 0", true},
    {"--crf", "N", "Quality of the film, 0..51: less is better and larger; 0 is lossless, which browsers do not play",
     &Options::crf, "output.crf", toml_count, "an integer 0..51", false},
    {"--camera", "NAME", "Name of the camera", &Options::camera, "output.camera", toml_text, nullptr, false},
    {"--show", "WORDS", "Over the picture, such as time,points,impulses; none: nothing; see overlay.show",
     &Options::show, "overlay.show", toml_words, nullptr, false},
    {"--color-by", "WORD", "look (as the scene says), material, body, speed, contacts or impulse",
     &Options::color_by, "overlay.color_by", toml_text, nullptr, false},
    {"--passes", "WORDS", "Beside each frame: depth,normal,body,motion,alpha (OpenEXR), rgba,depth16,rgb16 (PNG); see output.passes",
     &Options::passes, "output.passes", toml_words, nullptr, false},
    {"--record-every", "N", "Steps a record of the trajectory; 0: one record a frame", &Options::record_every,
     "output.record_every", toml_count, "a number of steps >= 0", true},
};

/// "dotted.key=value". Throws Error (usage).
std::string assignment(const KeyOption& option, const std::string& text) {
    const Value value = option.toml(text);
    if (!value) {
        throw sim::Error(sim::ExitCode::usage,
                         fmt::format("{} '{}': expected {}", option.option, text, option.expected));
    }
    return fmt::format("{}={}", option.key, *value);
}

} // namespace

void add_key_options(CLI::App& verb, Options& options, Changes changes) {
    for (const KeyOption& row : key_options) {
        const bool is_of_use = changes == Changes::everything || !row.is_simulated;
        if (is_of_use && verb.get_option_no_throw(row.option) == nullptr) {
            verb.add_option(row.option, options.*row.text, row.meaning)->type_name(row.type);
        }
    }
}

std::vector<std::string> key_overrides(const Options& options) {
    std::vector<std::string> overrides;
    for (const KeyOption& row : key_options) {
        if (!(options.*row.text).empty()) {
            overrides.push_back(assignment(row, options.*row.text));
        }
    }
    return overrides;
}

std::string as_typed(const std::string& message, const Options& options) {
    for (const KeyOption& row : key_options) {
        const std::string& text = options.*row.text;
        const std::string prefix = text.empty() ? "" : "--set " + assignment(row, text) + ": ";
        if (!text.empty() && message.starts_with(prefix)) {
            return fmt::format("{} {}: {}", row.option, text, message.substr(prefix.size()));
        }
    }
    return message;
}

std::optional<long> parse_integer(std::string_view text) {
    long value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
        return std::nullopt;
    }
    return value;
}

} // namespace cmd
