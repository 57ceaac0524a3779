#pragma once
/// Bytes as text: RFC 4648.
#include <optional>
#include <string>
#include <string_view>

namespace sim {

std::string base64(std::string_view bytes);

/// The bytes that a text stands for; none if it is not whole.
std::optional<std::string> bytes_of_base64(std::string_view text);

} // namespace sim
