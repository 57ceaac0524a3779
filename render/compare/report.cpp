#include "render/compare/report.h"

#include "render/compare/history.h"
#include "render/compare/utf8.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <vector>

namespace diff {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr std::size_t most_markdown_cases = 50;
constexpr const char* manifest_name = "manifest.json";

template <typename Value>
Json or_null(const std::optional<Value>& value) {
    return value ? Json(*value) : Json(nullptr);
}

Json to_json(const Box& box) {
    return {box.x, box.y, box.width, box.height};
}

Json to_json(const Displacement& u) {
    return {{"x", u.x}, {"y", u.y}, {"explained", u.explained}};
}

Json to_json(const Origin& origin) {
    return {{"program", origin.program},
            {"scene", origin.scene},
            {"state_hash", origin.state_hash},
            {"shaders_hash", origin.shaders_hash},
            {"renderer", origin.renderer},
            {"processor", origin.processor},
            {"shaders", origin.shaders}};
}

template <typename Item, typename Convert>
Json list(const std::vector<Item>& items, Convert convert) {
    Json json = Json::array();
    for (const Item& item : items) {
        json.push_back(convert(item));
    }
    return json;
}

Json to_json(const Frame& frame) {
    const auto gate = [](const Gate& g) -> Json {
        return {{"name", g.name},     {"value", g.value},   {"limit", g.limit},           {"unit", g.unit},
                {"reason", g.reason}, {"source", g.source}, {"is_exceeded", g.is_exceeded}};
    };
    const auto cluster = [](const Cluster& c) -> Json {
        return {{"box", to_json(c.box)},
                {"pixels", c.pixels},
                {"largest_difference", c.largest_difference},
                {"kind", name_of(c.kind)},
                {"displacement", to_json(c.displacement)},
                {"bodies", c.bodies}};
    };
    const auto body = [](const BodyChange& b) -> Json {
        return {{"name", b.name},
                {"kind", name_of(b.kind)},
                {"displacement", to_json(b.displacement)},
                {"distance", or_null(b.distance)},
                {"angle", or_null(b.angle)},
                {"pixels", b.pixels},
                {"box", to_json(b.box)}};
    };
    return {{"name", frame.name},
            {"index", frame.index},
            {"status", name_of(frame.status)},
            {"tier", name_of(frame.tier)},
            {"message", frame.message},
            {"width", frame.width},
            {"height", frame.height},
            {"candidate_width", frame.candidate_width},
            {"candidate_height", frame.candidate_height},
            {"differing_pixels", frame.differing_pixels},
            {"largest_difference", frame.largest_difference},
            {"mean_difference", frame.mean_difference},
            {"curve", frame.curve},
            {"gates", list(frame.gates, gate)},
            {"clusters", list(frame.clusters, cluster)},
            {"bodies", list(frame.bodies, body)},
            {"scene_change", frame.scene_change},
            {"reference_picture", frame.reference_picture},
            {"candidate_picture", frame.candidate_picture},
            {"difference_picture", frame.difference_picture}};
}

Json to_json(const Case& c) {
    return {{"name", c.name},
            {"reference", c.reference},
            {"candidate", c.candidate},
            {"is_sequence", c.is_sequence},
            {"is_failed", c.is_failed},
            {"status", name_of(c.status)},
            {"tier", name_of(c.tier)},
            {"message", c.message},
            {"cause", name_of(c.cause)},
            {"cause_text", c.cause_text},
            {"reference_origin", to_json(c.reference_origin)},
            {"candidate_origin", to_json(c.candidate_origin)},
            {"first_bad_frame", or_null(c.first_bad_frame)},
            {"worst_frame", or_null(c.worst_frame)},
            {"shift", or_null(c.shift)},
            {"bad_runs", list(c.bad_runs, [](const FrameRun& r) -> Json { return {r.begin, r.end}; })},
            {"missing_frames", c.missing_frames},
            {"extra_frames", c.extra_frames},
            {"film", c.film},
            {"fps", c.fps},
            {"is_flaky", is_flaky(c)},
            {"history", list(c.history,
                             [](const PastRun& run) -> Json {
                                 return {{"time", run.time}, {"is_failed", run.is_failed}, {"curve", run.curve}};
                             })},
            {"frames", list(c.frames, [](const Frame& f) { return to_json(f); })}};
}

std::int64_t compared_count(const Comparison& comparison) {
    std::int64_t count = 0;
    for (const std::int64_t of_tier : comparison.cases_of_tier) {
        count += of_tier;
    }
    return count;
}

/// "changed", or why there was nothing to compare: "size differs".
std::string verdict(const Case& c) {
    std::string text = c.status == Status::compared ? name_of(c.tier) : name_of(c.status);
    std::replace(text.begin(), text.end(), '_', ' ');
    return text;
}

/// Text for XML: the characters with a meaning are named, those it cannot hold are replaced.
std::string xml(const std::string& text) {
    std::string out;
    for (const char c : as_utf8(text)) {
        switch (c) {
        case '&':
            out += "&amp;";
            break;
        case '<':
            out += "&lt;";
            break;
        case '>':
            out += "&gt;";
            break;
        case '"':
            out += "&quot;";
            break;
        default:
            out += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? '?' : c;
        }
    }
    return out;
}

std::string summary_line(const Comparison& comparison) {
    const auto cases = static_cast<std::int64_t>(comparison.cases.size());
    return fmt::format("{} case{}: {} identical, {} noise, {} changed, {} not compared; {} failed", cases,
                       cases == 1 ? "" : "s", comparison.cases_of_tier[0], comparison.cases_of_tier[1],
                       comparison.cases_of_tier[2], cases - compared_count(comparison), comparison.failed_cases);
}

/// Names of files may be any bytes, JSON holds characters.
void make_utf8(Json& json) {
    if (json.is_structured()) {
        std::for_each(json.begin(), json.end(), make_utf8);
    } else if (json.is_string()) {
        json = as_utf8(json.get_ref<const std::string&>());
    }
}

} // namespace

std::string to_json(const Comparison& comparison) {
    Json json = {{"version", 1},
                 {"program", comparison.program},
                 {"command", comparison.command},
                 {"accept", comparison.accept},
                 {"fail_on", name_of(comparison.fail_on)},
                 {"exit_code", comparison.exit_code},
                 {"counts",
                  {{"identical", comparison.cases_of_tier[0]},
                   {"noise", comparison.cases_of_tier[1]},
                   {"changed", comparison.cases_of_tier[2]},
                   {"not_compared",
                    static_cast<std::int64_t>(comparison.cases.size()) - compared_count(comparison)},
                   {"failed", comparison.failed_cases}}},
                 {"cases", list(comparison.cases, [](const Case& c) { return to_json(c); })}};
    make_utf8(json);
    return json.dump(2) + "\n";
}

std::string to_junit(const Comparison& comparison) {
    const auto is_error = [](const Case& c) { return c.is_failed && c.status == Status::unreadable; };
    const auto errors = std::count_if(comparison.cases.begin(), comparison.cases.end(), is_error);
    double seconds = 0.0;
    for (const Case& c : comparison.cases) {
        seconds += c.seconds;
    }
    std::string text = fmt::format("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"
                                   "<testsuite name=\"tumble\" tests=\"{}\" failures=\"{}\" errors=\"{}\" skipped=\"0\" "
                                   "time=\"{:.3f}\">\n",
                                   comparison.cases.size(), comparison.failed_cases - errors, errors, seconds);
    for (const Case& c : comparison.cases) {
        text += fmt::format("<testcase classname=\"tumble.compare\" name=\"{}\" time=\"{:.3f}\">", xml(c.name), c.seconds);
        if (c.is_failed) {
            const char* element = is_error(c) ? "error" : "failure";
            text += fmt::format("\n<{} type=\"{}\" message=\"{}\">{}\nreference: {}\ncandidate: {}\n", element, verdict(c),
                                xml(c.message), xml(c.cause_text), xml(c.reference), xml(c.candidate));
            for (const Frame& frame : c.frames) {
                for (const std::string& picture :
                     {frame.reference_picture, frame.candidate_picture, frame.difference_picture}) {
                    text += picture.empty() ? "" : xml(picture) + "\n";
                }
            }
            text += fmt::format("</{}>\n", element);
        }
        text += "</testcase>\n";
    }
    return text + "</testsuite>\n</testsuites>\n";
}

std::string to_markdown(const Comparison& comparison) {
    std::string text = "### tumble: " + summary_line(comparison) + "\n";
    std::vector<const Case*> cases;
    for (const Case& c : comparison.cases) {
        if (c.status != Status::compared || c.tier != Tier::identical) {
            cases.push_back(&c);
        }
    }
    std::stable_sort(cases.begin(), cases.end(), [](const Case* a, const Case* b) {
        return std::pair(a->status != Status::compared, a->tier) > std::pair(b->status != Status::compared, b->tier);
    });
    if (!cases.empty()) {
        text += "\n| case | verdict | why |\n| --- | --- | --- |\n";
    }
    for (std::size_t i = 0; i < std::min(cases.size(), most_markdown_cases); ++i) {
        std::string why = cases[i]->message;
        if (!cases[i]->cause_text.empty()) {
            why += "; " + cases[i]->cause_text;
        }
        std::replace(why.begin(), why.end(), '|', '/');
        text += fmt::format("| {} | {}{}{} | {} |\n", cases[i]->name, cases[i]->is_failed ? "**" : "",
                            verdict(*cases[i]), cases[i]->is_failed ? "**" : "", why);
    }
    if (cases.size() > most_markdown_cases) {
        text += fmt::format("\nand {} more\n", cases.size() - most_markdown_cases);
    }
    return text;
}

std::string to_text(const Comparison& comparison) {
    std::string text;
    for (const Case& c : comparison.cases) {
        text += fmt::format("{}: {}{}: {}\n", c.name, verdict(c), is_flaky(c) ? " (flaky)" : "", c.message);
        if (!c.cause_text.empty()) {
            text += "  " + c.cause_text + "\n";
        }
    }
    if (comparison.cases.size() > 1) {
        text += summary_line(comparison) + "\n";
    }
    return text;
}

std::vector<sim::WrittenFile> read_manifest(const fs::path& folder, const char* kind) {
    std::error_code error;
    std::vector<sim::WrittenFile> files;
    if (!fs::is_regular_file(folder / manifest_name, error)) {
        return files;
    }
    const nlohmann::json json = nlohmann::json::parse(sim::read_text_file(folder / manifest_name), nullptr, false);
    try {
        if (json.at("kind") == kind) {
            for (const nlohmann::json& file : json.at("files")) {
                files.push_back({file.at("name"), file.at("bytes"), file.at("sha256")});
            }
        }
    } catch (const nlohmann::json::exception&) {
        files.clear(); // anybody can write a file of this name
    }
    return files;
}

bool is_as_written(const fs::path& folder, const sim::WrittenFile& file) {
    const fs::path name = file.name;
    std::error_code error;
    // Names of this folder only.
    return !name.empty() && name.is_relative() && *name.lexically_normal().begin() != ".." &&
           fs::is_regular_file(folder / name, error) && fs::file_size(folder / name, error) == file.bytes &&
           sim::sha256_of_file(folder / name) == file.sha256;
}

void remove_report(const fs::path& folder) {
    const std::vector<sim::WrittenFile> files = read_manifest(folder, report_kind);
    std::error_code error;
    for (const sim::WrittenFile& file : files) {
        if (is_as_written(folder, file)) {
            fs::remove(folder / file.name, error);
        }
    }
    if (!files.empty()) {
        fs::remove(folder / manifest_name, error);
    }
}

void forget_in_gallery(const fs::path& run) {
    const fs::path folder = fs::absolute(run).lexically_normal();
    const fs::path root = folder.has_filename() ? folder.parent_path() : folder.parent_path().parent_path();
    const std::vector<sim::WrittenFile> files = read_manifest(root, gallery_kind);
    std::error_code error;
    for (const sim::WrittenFile& file : files) {
        const fs::path name = file.name;
        if (name.filename() == "poster.png" && fs::equivalent((root / name).parent_path(), run, error) &&
            is_as_written(root, file)) {
            fs::remove(root / name, error);
        }
    }
    if (!files.empty()) {
        fs::remove(root / manifest_name, error);
    }
}

void write_manifest(const fs::path& folder, const char* kind, const std::vector<std::string>& names) {
    Json files = Json::array();
    for (const std::string& name : names) {
        if (!name.empty()) {
            const sim::WrittenFile file = sim::describe_file(folder, name);
            files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
        }
    }
    const Json json = {{"version", 1}, {"kind", kind}, {"files", std::move(files)}};
    sim::write_file(folder / manifest_name, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

namespace {

/// Pictures that are in the page, and the folders that held them.
void remove_pictures(const fs::path& folder, Comparison& comparison) {
    std::error_code error;
    for (Case& c : comparison.cases) {
        for (Frame& frame : c.frames) {
            for (std::string* path : {&frame.reference_picture, &frame.candidate_picture, &frame.difference_picture}) {
                if (!path->empty() && !path->starts_with(candidates_folder)) {
                    fs::remove(folder / *path, error);
                    fs::remove((folder / *path).parent_path(), error); // if it is empty
                    path->clear();
                }
            }
        }
    }
    fs::remove(folder / pictures_folder, error);
}

} // namespace

void write_report(const fs::path& folder, Comparison comparison, PagePictures pictures) {
    write_report_page(folder, to_json(comparison), pictures);
    if (pictures == PagePictures::inside) {
        remove_pictures(folder, comparison);
    }
    sim::write_file(folder / "result.json", to_json(comparison));
    sim::write_file(folder / "junit.xml", to_junit(comparison));
    sim::write_file(folder / "summary.md", to_markdown(comparison));
    std::vector<std::string> names{"index.html", "result.json", "junit.xml", "summary.md"};
    for (const Case& c : comparison.cases) {
        names.push_back(c.film);
        for (const Frame& frame : c.frames) {
            names.insert(names.end(), {frame.reference_picture, frame.candidate_picture, frame.difference_picture});
        }
    }
    // What lies in the folder without having been written for the report is not its to remove.
    std::erase_if(names, [](const std::string& name) { return name.starts_with(candidates_folder); });
    sim::sync_files(folder); // the pictures were written without
    write_manifest(folder, report_kind, names);
}

} // namespace diff
