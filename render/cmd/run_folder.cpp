#include "render/cmd/run_folder.h"

#include "render/compare/report.h"
#include "sim/base/error.h"
#include "sim/record/summary.h"

#include <fmt/format.h>

#include <algorithm>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

std::string read_summary(const fs::path& folder) {
    const fs::path path = folder / summary_name;
    std::error_code error;
    if (!fs::exists(path, error)) {
        return {};
    }
    std::string text = sim::read_text_file(path);
    if (!sim::files_of_summary(text)) {
        throw Error(ExitCode::io, fmt::format("cannot read {}: it is damaged", path.string()));
    }
    return text;
}

void require_same_simulation(const fs::path& folder, const fs::path& trajectory) {
    const std::string summary = read_summary(folder);
    std::error_code error;
    if (fs::equivalent(folder / trajectory_name, trajectory, error)) {
        return;
    }
    // The hash of the one that lies there, or lay there when the summary was written; empty: none did.
    std::string there;
    if (fs::exists(folder / trajectory_name, error)) {
        there = sim::sha256_of_file(folder / trajectory_name);
    } else if (!summary.empty()) {
        const auto files = *sim::files_of_summary(summary);
        const auto listed = std::ranges::find(files, trajectory_name, &sim::WrittenFile::name);
        there = listed != files.end() ? listed->sha256 : "unknown";
    }
    if (!there.empty() && there != sim::sha256_of_file(trajectory)) {
        throw Error(ExitCode::usage,
                    fmt::format("{} holds another simulation than {}; choose another folder with --out",
                                folder.string(), trajectory.string()));
    }
}

void require_no_file_of_run(const fs::path& file) {
    const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
    const std::string summary = read_summary(folder);
    if (summary.empty()) {
        return;
    }
    const std::vector<sim::WrittenFile> files = *sim::files_of_summary(summary);
    if (std::ranges::find(files, file.filename().string(), &sim::WrittenFile::name) != files.end()) {
        throw Error(ExitCode::usage, fmt::format("{} is a file of the run in {}; choose another name", file.string(),
                                                 fs::proximate(folder).string()));
    }
}

void forget_run(const Workplace& workplace, const std::string& scene, bool keeps_checkpoint) {
    diff::forget_in_gallery(workplace.folder());
    workplace.remove_file(summary_name); // first: it lists the others
    for (const std::string& name : run_names(scene)) {
        if (!keeps_checkpoint || (name != checkpoint_name && name != states_name)) {
            workplace.remove_file(name);
        }
    }
}

void forget_products(const Workplace& workplace, const std::string& scene, bool keeps_frames) {
    const fs::path& folder = workplace.folder();
    diff::forget_in_gallery(folder);
    if (const std::string summary = read_summary(folder); !summary.empty()) {
        std::vector<sim::WrittenFile> files = *sim::files_of_summary(summary);
        std::erase_if(files, [&](const sim::WrittenFile& file) {
            const bool stays = file.name == trajectory_name || (keeps_frames && file.name.starts_with("frames/"));
            return !stays || !diff::is_as_written(folder, file);
        });
        sim::write_file(folder / summary_name, sim::summary_with_files(summary, files));
    }
    for (const std::string& name : product_names(scene)) {
        workplace.remove_file(name);
    }
}

} // namespace cmd
