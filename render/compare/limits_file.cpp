#include "render/compare/limits_file.h"

#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace diff {

namespace {

/// Room above what known-good pairs have shown.
constexpr double margin = 1.25;

/// Largest value of a gate in all frames, with room above it; at least `least`.
double proposed_limit(const Comparison& comparison, const std::string& gate_name, double least) {
    double limit = least;
    for (const Case& result : comparison.cases) {
        for (const Frame& frame : result.frames) {
            for (const Gate& gate : frame.gates) {
                if (gate.name == gate_name) {
                    limit = std::max(limit, std::ceil(100.0 * margin * gate.value) / 100.0);
                }
            }
        }
    }
    return limit;
}

} // namespace

std::string proposed_limits(const Comparison& comparison, const Limits& least) {
    nlohmann::ordered_json json;
    for (std::size_t i = 0; i < gate_count; ++i) {
        const auto id = static_cast<GateId>(i);
        const double limit = proposed_limit(comparison, name_of(id), least[id].value);
        if (limit < not_asked) {
            json[name_of(id)] = limit;
        }
    }
    return json.dump(2) + "\n";
}

Limits read_limits(const std::filesystem::path& path) {
    const nlohmann::json json = nlohmann::json::parse(sim::read_text_file(path), nullptr, false);
    if (!json.is_object()) {
        throw sim::Error(sim::ExitCode::usage, path.string() + ": expected a JSON object of gates and their limits");
    }
    Limits limits;
    for (const auto& [name, value] : json.items()) {
        std::size_t i = 0;
        std::string known;
        while (i < gate_count && name != name_of(static_cast<GateId>(i))) {
            known += fmt::format("{}'{}'", i == 0 ? "" : ", ", name_of(static_cast<GateId>(i)));
            ++i;
        }
        if (i == gate_count) {
            throw sim::Error(sim::ExitCode::usage,
                             fmt::format("{}: no gate is called '{}'; there are {}", path.string(), name, known));
        }
        if (!value.is_number() || value.get<double>() < 0.0) {
            throw sim::Error(sim::ExitCode::usage,
                             fmt::format("{}: '{}': expected a number >= 0", path.string(), name));
        }
        limits.of[i] = {value.get<double>(), path.string()};
    }
    return limits;
}

} // namespace diff
