#pragma once
#include <string>

namespace diff {

/// A name of a file, which may be any bytes, as text: bytes that are no UTF-8 are written as ~FF.
std::string as_utf8(const std::string& bytes);

} // namespace diff
