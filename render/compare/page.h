#pragma once
/// HTML pages from the templates of page/, which are part of the program.
#include <map>
#include <string>
#include <string_view>

namespace diff {

/// The template `name` with each {{key}} replaced: by the text given for it, or by the file of page/ of that
/// name. An unknown key or name: CHECK.
std::string fill_page(std::string_view name, const std::map<std::string, std::string, std::less<>>& texts);

/// For text between tags and for attributes in double quotes.
std::string escape_html(std::string_view text);

} // namespace diff
