#include "render/cmd/export.h"

#include "render/cmd/gltf.h"
#include "render/cmd/interrupt.h"
#include "render/scene/camera.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"
#include "sim/record/trajectory.h"
#include "sim/scene/file.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>

namespace cmd {

namespace fs = std::filesystem;
using sim::Error;
using sim::ExitCode;

namespace {

constexpr const char* csv_head =
    "step,time_s,body,x_m,y_m,z_m,qw,qx,qy,qz,vx_m_s,vy_m_s,vz_m_s,wx_rad_s,wy_rad_s,wz_rad_s\n";

bool is_opening_moved(const sim::CameraDef& camera) {
    const auto opening = [&](const sim::CameraKey& key) {
        return key.fov_degrees > 0.0 ? key.fov_degrees : camera.fov_degrees;
    };
    return std::ranges::adjacent_find(camera.keys, std::ranges::not_equal_to(), opening) != camera.keys.end();
}

/// A name as one field: in quotes, those in it doubled.
std::string csv_text(const std::string& text) {
    std::string field = "\"";
    for (const char c : text) {
        field += c == '"' ? "\"\"" : std::string(1, c);
    }
    return field + "\"";
}

/// Of the bodies that are there. names: as fields.
std::string csv_rows(const sim::SceneDef& scene, const std::vector<std::string>& names, const sim::Snapshot& state) {
    std::string rows;
    for (std::size_t i = 0; i < state.bodies.size(); ++i) {
        if (!scene.bodies[i].is_there(state.time)) {
            continue;
        }
        const sim::BodySnapshot& b = state.bodies[i];
        rows +=
            fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", state.step, state.time, names[i],
                        b.position.x(), b.position.y(), b.position.z(), b.orientation.w(), b.orientation.x(),
                        b.orientation.y(), b.orientation.z(), b.velocity.x(), b.velocity.y(), b.velocity.z(),
                        b.angular_velocity.x(), b.angular_velocity.y(), b.angular_velocity.z());
    }
    return rows;
}

/// Removes the part file unless it was committed.
struct PartFile {
    fs::path path;
    std::FILE* file = nullptr;
    bool is_committed = false;

    ~PartFile() {
        if (file != nullptr) {
            std::fclose(file);
        }
        if (!path.empty() && !is_committed) {
            std::error_code error;
            fs::remove(path, error);
        }
    }
};

/// A row a body and record, in bounded memory.
void write_csv(const std::string& name, const sim::SceneDef& scene, const sim::TrajectoryReader& trajectory) {
    const bool is_stdout = name == "-";
    PartFile part{is_stdout ? fs::path() : sim::part_path(name)};
    std::FILE* file = stdout;
    if (!is_stdout) {
        file = part.file = std::fopen(part.path.c_str(), "wb");
    }
    const auto fail = [&] {
        throw Error(ExitCode::io, fmt::format("cannot write {}", is_stdout ? "standard output" : name));
    };
    if (file == nullptr) {
        fail();
    }
    std::vector<std::string> names;
    for (const sim::BodyDef& body : scene.bodies) {
        names.push_back(csv_text(body.name));
    }
    bool is_good = std::fputs(csv_head, file) >= 0;
    for (std::size_t record = 0; record < trajectory.steps().size() && is_good; ++record) {
        if (is_interrupted()) {
            throw Error(ExitCode::interrupted, "interrupted; no file was made");
        }
        is_good = std::fputs(csv_rows(scene, names, trajectory.read(record)).c_str(), file) >= 0;
    }
    is_good = std::fflush(file) == 0 && is_good;
    if (!is_good && !(is_stdout && sim::is_output_unread())) {
        fail();
    }
    if (!is_stdout) {
        part.file = nullptr;
        if (std::fclose(file) != 0) {
            fail();
        }
        sim::commit_part(name);
        part.is_committed = true;
    }
}

} // namespace

void add_export_options(CLI::App& verb, ExportOptions& options) {
    verb.add_option("RUN", options.run, "Folder of a run, or its trajectory.h5")->required()->type_name("");
    verb.add_option("--gltf", options.gltf,
                    "A binary glTF 2.0 file: bodies, materials, camera, sun, animation")
        ->type_name("FILE");
    verb.add_option("--csv", options.csv, "A row a body and record: pose and velocities; -: standard output")
        ->type_name("FILE");
    verb.add_flag("--quiet", options.is_quiet, "Only errors are printed");
}

void export_run(const ExportOptions& options) {
    if (options.gltf.empty() && options.csv.empty()) {
        throw Error(ExitCode::usage, "export: expected --gltf FILE or --csv FILE");
    }
    if (!options.gltf.empty() && fs::path(options.gltf).extension() != ".glb") {
        throw Error(ExitCode::usage,
                    fmt::format("--gltf '{}': expected a name that ends in .glb", options.gltf));
    }
    if (!options.csv.empty() && options.csv != "-" && fs::path(options.csv).extension() != ".csv") {
        throw Error(ExitCode::usage,
                    fmt::format("--csv '{}': expected a name that ends in .csv, or - for standard output", options.csv));
    }
    std::error_code error;
    const fs::path path = fs::is_directory(options.run, error) ? fs::path(options.run) / "trajectory.h5"
                                                               : fs::path(options.run);
    const sim::TrajectoryReader trajectory(path);
    if (trajectory.steps().empty()) {
        throw Error(ExitCode::usage, fmt::format("{} has no record", path.string()));
    }
    const sim::TrajectoryInfo& info = trajectory.info();
    const sim::SceneDef scene = sim::parse_scene(info.scene_text, info.scene_name + ".toml", info.overrides);
    if (!options.csv.empty()) {
        write_csv(options.csv, scene, trajectory);
    }
    if (options.gltf.empty()) {
        return;
    }
    const GltfSummary summary = write_gltf(options.gltf, scene, trajectory);
    if (!options.is_quiet) {
        fmt::print("{}: {} nodes, {} of {} poses kept\n", options.gltf, summary.nodes, summary.keys,
                   summary.records);
        const sim::CameraDef& camera = render::find_camera(scene, scene.output.camera);
        if (is_opening_moved(camera)) {
            fmt::print("{}: glTF moves no camera's opening: that of '{}' stays as it is at the start\n", options.gltf,
                       camera.name);
        }
    }
}

} // namespace cmd
