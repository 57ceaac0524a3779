#pragma once
/// Text that may be any bytes.
#include <cstddef>
#include <string_view>

namespace sim {

/// Bytes of the well-formed UTF-8 character that the text begins with (The Unicode Standard, table 3-7); 0: none does.
inline std::size_t utf8_length(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
    const unsigned first = byte(0);
    const std::size_t length = text.empty() || (first >= 0x80 && first < 0xc2) || first >= 0xf5 ? 0
                               : first < 0x80                                                   ? 1
                               : first < 0xe0                                                   ? 2
                               : first < 0xf0                                                   ? 3
                                                                                                : 4;
    for (std::size_t i = 1; i < length; ++i) {
        const unsigned least = i == 1 && first == 0xe0 ? 0xa0 : i == 1 && first == 0xf0 ? 0x90 : 0x80;
        const unsigned most = i == 1 && first == 0xed ? 0x9f : i == 1 && first == 0xf4 ? 0x8f : 0xbf;
        if (byte(i) < least || byte(i) > most) {
            return 0;
        }
    }
    return length;
}

} // namespace sim
