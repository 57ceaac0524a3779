#include "render/compare/report_page.h"

#include "render/compare/page.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <vector>

namespace diff {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// As in the list of the page: what could not be compared, changed, noise, identical.
int severity(const Json& item) {
    if (item.at("status") != "compared") {
        return 3;
    }
    const std::string tier = item.at("tier");
    return tier == "changed" ? 2 : tier == "noise" ? 1 : 0;
}

/// Paths of all pictures, those of the worst frames of the worst cases first.
std::vector<std::string> pictures_by_severity(const Json& result) {
    struct Entry {
        int of_case = 0;
        int of_frame = 0;
        const Json* frame = nullptr;
    };
    std::vector<Entry> entries;
    for (const Json& item : result.at("cases")) {
        for (const Json& frame : item.at("frames")) {
            entries.push_back({severity(item), severity(frame), &frame});
        }
    }
    std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return std::pair(a.of_case, a.of_frame) > std::pair(b.of_case, b.of_frame);
    });
    std::set<std::string> seen;
    std::vector<std::string> paths;
    for (const Entry& entry : entries) {
        for (const char* key : {"reference_picture", "candidate_picture", "difference_picture"}) {
            std::string path = entry.frame->at(key);
            if (!path.empty() && seen.insert(path).second) {
                paths.push_back(std::move(path));
            }
        }
    }
    return paths;
}

std::string base64(const std::string& bytes) {
    constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            group = group << 8 | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            text += k <= count ? digits[group >> (18 - 6 * k) & 63] : '=';
        }
    }
    return text;
}

std::string picture_elements(const fs::path& folder, const Json& result, std::uintmax_t picture_bytes) {
    std::string elements;
    std::uintmax_t sum = 0;
    for (const std::string& path : pictures_by_severity(result)) {
        std::error_code error;
        const std::uintmax_t size = fs::file_size(folder / path, error);
        if (error || sum + size > picture_bytes) {
            continue;
        }
        sum += size;
        elements +=
            fmt::format("<script type=\"text/plain\" class=\"picture\" data-path=\"{}\">{}</script>\n",
                        escape_html(path), base64(sim::read_text_file(folder / path)));
    }
    return elements;
}

} // namespace

void write_report_page(const fs::path& folder, const std::string& result_json, std::uintmax_t picture_bytes) {
    const Json result = Json::parse(result_json);
    // In JSON, '<' stands within texts only; written as an escape it cannot end the element around it.
    std::string data;
    for (const char c : result_json) {
        data += c == '<' ? std::string("\\u003c") : std::string(1, c);
    }
    const std::string pictures = picture_elements(folder, result, picture_bytes);
    sim::write_file(folder / "index.html",
                    fill_page("report.html", {{"result", data}, {"pictures", pictures}}));
}

} // namespace diff
