#include "render/compare/report_page.h"

#include "render/compare/page.h"
#include "sim/base/base64.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <set>

namespace diff {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

/// All pictures that the result names.
std::string picture_elements(const fs::path& folder, const Json& result) {
    std::string elements;
    std::set<std::string> seen{""};
    for (const Json& item : result.at("cases")) {
        for (const Json& frame : item.at("frames")) {
            for (const char* key : {"reference_picture", "candidate_picture", "difference_picture"}) {
                const std::string path = frame.at(key);
                if (seen.insert(path).second) {
                    elements += fmt::format("<script type=\"text/plain\" class=\"picture\" data-path=\"{}\">{}</script>\n",
                                            escape_html(path), sim::base64(sim::read_text_file(folder / path)));
                }
            }
        }
    }
    return elements;
}

} // namespace

void write_report_page(const fs::path& folder, const std::string& result_json, PagePictures pictures) {
    // In JSON, '<' stands within texts only; written as an escape it cannot end the element around it.
    std::string data;
    for (const char c : result_json) {
        data += c == '<' ? std::string("\\u003c") : std::string(1, c);
    }
    const std::string elements =
        pictures == PagePictures::inside ? picture_elements(folder, Json::parse(result_json)) : std::string();
    sim::write_file(folder / "index.html", fill_page("report.html", {{"result", data}, {"pictures", elements}}));
}

} // namespace diff
