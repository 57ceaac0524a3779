#include "render/compare/history.h"

#include "render/compare/utf8.h"
#include "sim/base/error.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>

namespace diff {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

constexpr std::size_t most_runs = 20;    ///< of a case that a report shows
constexpr std::size_t flaky_runs = 10;   ///< the last ones, that tell whether a case is flaky
constexpr std::ptrdiff_t flaky_turns = 3; ///< of the verdict among them; broken and mended again are two

std::string line_of(const Case& result, const std::string& program, const std::string& time) {
    double curve = 0.0;
    int largest = 0;
    for (const Frame& frame : result.frames) {
        curve = std::max(curve, frame.curve);
        largest = std::max(largest, frame.largest_difference);
    }
    const nlohmann::ordered_json json = {{"time", time},
                                         {"case", as_utf8(result.name)},
                                         {"status", name_of(result.status)},
                                         {"tier", name_of(result.tier)},
                                         {"is_failed", result.is_failed},
                                         {"curve", curve},
                                         {"largest_difference", largest},
                                         {"program", program}};
    return json.dump() + "\n";
}

[[noreturn]] void fail(const fs::path& path, const char* what) {
    throw Error(ExitCode::io, fmt::format("cannot {} {}: {}", what, path.string(), std::strerror(errno)));
}

} // namespace

void append_history(const fs::path& path, const Comparison& comparison, const std::string& time) {
    std::string lines;
    for (const Case& result : comparison.cases) {
        lines += line_of(result, comparison.program, time);
    }
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (file < 0) {
        fail(path, "open");
    }
    const ssize_t written = ::write(file, lines.data(), lines.size()); // at once: appended as a whole
    const bool is_closed = ::close(file) == 0;
    if (written != static_cast<ssize_t>(lines.size()) || !is_closed) {
        fail(path, "write");
    }
}

void read_history(const fs::path& path, Comparison& comparison) {
    std::ifstream in(path);
    if (!in) {
        fail(path, "open");
    }
    std::map<std::string, std::vector<PastRun>> runs;
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
        try {
            const nlohmann::json json = nlohmann::json::parse(line);
            runs[json.at("case")].push_back({json.at("time"), json.at("is_failed"), json.at("curve")});
        } catch (const nlohmann::json::exception&) {
            throw Error(ExitCode::io, fmt::format("cannot read {}:{}: it is no record of a comparison", path.string(), number));
        }
    }
    for (Case& result : comparison.cases) {
        result.history = std::move(runs[as_utf8(result.name)]);
        if (result.history.size() > most_runs) {
            result.history.erase(result.history.begin(), result.history.end() - most_runs);
        }
    }
}

bool is_flaky(const Case& result) {
    const std::size_t count = std::min(result.history.size(), flaky_runs);
    std::ptrdiff_t turns = 0;
    for (std::size_t i = result.history.size() - count; i + 1 < result.history.size(); ++i) {
        turns += result.history[i].is_failed != result.history[i + 1].is_failed;
    }
    return turns >= flaky_turns;
}

} // namespace diff
