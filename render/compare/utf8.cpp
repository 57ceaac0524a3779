#include "render/compare/utf8.h"

#include <fmt/format.h>

#include <cstdint>

namespace diff {

namespace {

/// Length of the sequence of UTF-8 that begins at `at`; 0 if none does (RFC 3629, sec. 4).
std::size_t sequence_length(const std::string& bytes, std::size_t at) {
    const auto byte = [&](std::size_t i) {
        return at + i < bytes.size() ? static_cast<std::uint8_t>(bytes[at + i]) : std::uint8_t{0};
    };
    const std::uint8_t first = byte(0);
    const std::size_t length = first < 0x80 ? 1 : first < 0xc2 ? 0 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : first < 0xf5 ? 4 : 0;
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xc0) != 0x80) {
            return 0;
        }
    }
    const std::uint8_t second = byte(1);
    const bool is_too_long = (first == 0xe0 && second < 0xa0) || (first == 0xf0 && second < 0x90);
    const bool is_no_character = (first == 0xed && second > 0x9f) || (first == 0xf4 && second > 0x8f);
    return is_too_long || is_no_character ? 0 : length;
}

} // namespace

std::string as_utf8(const std::string& bytes) {
    std::string text;
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t length = sequence_length(bytes, at);
        text += length > 0 ? bytes.substr(at, length) : fmt::format("~{:02X}", static_cast<std::uint8_t>(bytes[at]));
        at += length > 0 ? length : 1;
    }
    return text;
}

} // namespace diff
