#include "render/compare/utf8.h"

#include "sim/base/utf8.h"

#include <fmt/format.h>

#include <cstdint>

namespace diff {

std::string as_utf8(const std::string& bytes) {
    std::string text;
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t length = sim::utf8_length(std::string_view(bytes).substr(at));
        text += length > 0 ? bytes.substr(at, length) : fmt::format("~{:02X}", static_cast<std::uint8_t>(bytes[at]));
        at += length > 0 ? length : 1;
    }
    return text;
}

} // namespace diff
