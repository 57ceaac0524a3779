#include "sim/base/base64.h"

#include <algorithm>
#include <cstdint>

namespace sim {

namespace {

constexpr std::string_view base64_digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::size_t group_bytes = 3; ///< in four letters

} // namespace

std::string base64(std::string_view bytes) {
    std::string text;
    text.reserve((bytes.size() + 2) / group_bytes * 4);
    for (std::size_t i = 0; i < bytes.size(); i += group_bytes) {
        const std::size_t count = std::min(group_bytes, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < group_bytes; ++k) {
            group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += k <= count ? base64_digits[group >> (18 - 6 * k) & 63] : '=';
        }
    }
    return text;
}

std::optional<std::string> bytes_of_base64(std::string_view text) {
    const std::size_t padding = text.ends_with("==") ? 2 : text.ends_with("=") ? 1 : 0;
    if (text.size() % 4 != 0) {
        return {};
    }
    std::string bytes;
    bytes.reserve(text.size() / 4 * group_bytes);
    for (std::size_t i = 0; i < text.size(); i += 4) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const bool is_padding = i + k >= text.size() - padding;
            const std::size_t digit = is_padding ? 0 : base64_digits.find(text[i + k]);
            if (digit == std::string_view::npos) {
                return {};
            }
            group = group << 6 | static_cast<std::uint32_t>(digit);
        }
        for (std::size_t k = 0; k < group_bytes; ++k) {
            bytes += static_cast<char>(group >> (16 - 8 * k) & 255);
        }
    }
    bytes.resize(bytes.size() - padding);
    return bytes;
}

} // namespace sim
