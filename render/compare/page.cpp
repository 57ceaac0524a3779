#include "render/compare/page.h"

#include "render/compare/page_texts.h"
#include "sim/base/error.h"

#include <algorithm>
#include <iterator>

namespace diff {

std::string fill_page(std::string_view name, const std::map<std::string, std::string, std::less<>>& texts) {
    const auto* file = std::find_if(std::begin(page_texts), std::end(page_texts),
                                    [name](const PageText& text) { return text.name == name; });
    CHECK(file != std::end(page_texts));
    std::string page;
    std::string_view rest = file->text;
    for (std::size_t begin = rest.find("{{"); begin != std::string_view::npos; begin = rest.find("{{")) {
        const std::size_t end = rest.find("}}", begin);
        const std::string_view key = rest.substr(begin + 2, end - begin - 2);
        const auto found = texts.find(key);
        page += rest.substr(0, begin);
        page += found != texts.end() ? found->second : fill_page(key, texts);
        rest.remove_prefix(end + 2);
    }
    return page += rest;
}

std::string escape_html(std::string_view text) {
    std::string escaped;
    for (const char c : text) {
        switch (c) {
        case '&':
            escaped += "&amp;";
            break;
        case '<':
            escaped += "&lt;";
            break;
        case '>':
            escaped += "&gt;";
            break;
        case '"':
            escaped += "&quot;";
            break;
        default:
            escaped += c;
        }
    }
    return escaped;
}

} // namespace diff
