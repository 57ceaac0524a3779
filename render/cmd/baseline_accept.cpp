#include "render/cmd/baseline.h"
#include "render/cmd/baseline_place.h"
#include "render/cmd/baseline_record.h"
#include "render/cmd/slurm.h"
#include "render/cmd/workplace.h"
#include "render/compare/result.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/scene/tree.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <optional>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

/// Throws Error if the case's pictures in the report are not those that were drawn for it.
void check_reviewed(const fs::path& drawn, const std::string& name) {
    const std::optional<BaselineRecord> record = read_baseline_record(drawn);
    if (!record) {
        throw Error(ExitCode::missing_or_size,
                    fmt::format("the report has no pictures of {} to accept: {} is not there", name, drawn.string()));
    }
    for (const auto& [file, hash] : record->pictures) {
        if (sim::sha256_of_file(drawn / file) != hash) {
            throw Error(ExitCode::io, fmt::format("{} is not the picture that was drawn for the report",
                                                  (drawn / file).string()));
        }
    }
}

/// Names of the cases of a report that are not identical, with the folder of each one's baseline.
std::vector<std::pair<std::string, fs::path>> cases_of_report(const fs::path& report) {
    const fs::path path = report / "result.json";
    const nlohmann::json json = nlohmann::json::parse(sim::read_text_file(path), nullptr, false);
    std::vector<std::pair<std::string, fs::path>> cases;
    try {
        for (const nlohmann::json& each : json.at("cases")) {
            if (each.at("tier") != diff::name_of(diff::Tier::identical)) {
                const fs::path folder = each.at("reference").get<std::string>();
                if (!sim::is_file_name(folder.filename().string()) ||
                    !sim::is_file_name(folder.parent_path().filename().string())) {
                    throw Error(ExitCode::io,
                                fmt::format("cannot read {}: '{}' is the folder of no baseline", path.string(),
                                            folder.string()));
                }
                cases.emplace_back(each.at("name"), folder);
            }
        }
    } catch (const nlohmann::json::exception&) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: it is no result of a comparison", path.string()));
    }
    return cases;
}

/// Makes the pictures of one case the baseline; returns its folder. reference: that folder, as the report has it.
fs::path accept_case(const BaselineOptions& options, const std::string& name, const fs::path& reference) {
    const std::string scene = reference.parent_path().filename().string();
    const std::string baseline = reference.filename().string();
    const fs::path drawn =
        fs::path(options.report) / "candidates" / scene / baseline.substr(0, baseline.find('@')) / "frames";
    check_reviewed(drawn, name);
    const fs::path folder = fs::path(options.folder) / scene / baseline;
    std::error_code error;
    fs::create_directories(folder.parent_path(), error);
    const FolderLock lock(folder.parent_path(), FolderLock::Kind::alone, true);
    const fs::path fresh = folder.string() + ".part";
    remove_fresh(fresh);
    for (const fs::path& file : baseline_files(drawn)) {
        fs::create_directories((fresh / file).parent_path(), error);
        fs::copy_file(drawn / file, fresh / file, fs::copy_options::overwrite_existing, error);
        if (error) {
            remove_fresh(fresh);
            throw Error(ExitCode::io,
                        fmt::format("cannot copy {} to {}: {}", drawn.string(), fresh.string(), error.message()));
        }
    }
    replace_folder(fresh, folder);
    return folder;
}

} // namespace

std::string accept_command(const BaselineOptions& options, const std::string& report) {
    const bool is_elsewhere = options.folder != BaselineOptions().folder;
    return "tumble baseline accept " + shell_word(report) + (is_elsewhere ? " --baselines " + shell_word(options.folder) : "");
}

void accept_baselines(const BaselineOptions& options) {
    const std::vector<std::pair<std::string, fs::path>> found = cases_of_report(options.report);
    std::vector<std::string> names;
    for (const auto& [name, folder] : found) {
        names.push_back(name);
    }
    const auto contains = [](const std::vector<std::string>& all, const std::string& name) {
        return std::find(all.begin(), all.end(), name) != all.end();
    };
    for (const std::string& name : options.cases) {
        if (!contains(names, name)) {
            throw Error(ExitCode::usage, fmt::format("{} has no case '{}' that changed{}", options.report, name,
                                                     sim::suggestion(name, names)));
        }
    }
    if (found.empty() && !options.is_quiet) {
        std::printf("nothing to accept: all cases of %s are identical\n", options.report.c_str());
    }
    std::exception_ptr failure; // the first, once the others are accepted
    for (const auto& [name, reference] : found) {
        if (!options.cases.empty() && !contains(options.cases, name)) {
            continue;
        }
        try {
            const fs::path folder = accept_case(options, name, reference);
            if (!options.is_quiet) {
                std::printf("%s: %s is now what %s shows\n", name.c_str(), folder.c_str(), options.report.c_str());
            }
        } catch (const Error&) {
            failure = failure ? failure : std::current_exception();
        }
    }
    if (failure) {
        std::rethrow_exception(failure);
    }
}

} // namespace cmd
