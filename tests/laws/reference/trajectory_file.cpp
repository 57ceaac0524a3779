#include "tests/laws/reference/trajectory_file.h"

#include <hdf5.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cstring>
#include <numeric>
#include <stdexcept>

namespace reference {
namespace {

/// Closes an HDF5 handle of any kind at the end of a scope.
class Handle {
public:
    Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what) : id_(id), close_(close) {
        if (id_ < 0) {
            throw std::runtime_error("cannot open " + what);
        }
    }
    ~Handle() { close_(id_); }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    operator hid_t() const { return id_; }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

std::vector<hsize_t> sizes_of(hid_t dataset, const std::string& what) {
    const Handle space(H5Dget_space(dataset), H5Sclose, what);
    const int rank = H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> sizes(rank < 0 ? 0 : static_cast<std::size_t>(rank));
    H5Sget_simple_extent_dims(space, sizes.data(), nullptr);
    return sizes;
}

std::vector<double> read_doubles(hid_t file, const char* name, const std::string& path) {
    const std::string what = path + ": " + name;
    const Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, what);
    const std::vector<hsize_t> sizes = sizes_of(dataset, what);
    std::vector<double> values(std::accumulate(sizes.begin(), sizes.end(), hsize_t{1}, std::multiplies<>()));
    if (H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) {
        throw std::runtime_error("cannot read " + what);
    }
    return values;
}

/// A one-dimensional dataset of texts, of fixed or of variable length.
std::vector<std::string> read_texts(hid_t file, const char* name, const std::string& path) {
    const std::string what = path + ": " + name;
    const Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, what);
    const std::vector<hsize_t> sizes = sizes_of(dataset, what);
    const std::size_t count = sizes.empty() ? 0 : static_cast<std::size_t>(sizes[0]);
    const Handle type(H5Dget_type(dataset), H5Tclose, what);
    std::vector<std::string> texts;
    if (H5Tis_variable_str(type) > 0) {
        std::vector<char*> raw(count, nullptr);
        if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data()) < 0) {
            throw std::runtime_error("cannot read " + what);
        }
        for (char* text : raw) {
            texts.emplace_back(text ? text : "");
            H5free_memory(text);
        }
        return texts;
    }
    const std::size_t length = H5Tget_size(type);
    std::vector<char> raw(count * length);
    if (H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, raw.data()) < 0) {
        throw std::runtime_error("cannot read " + what);
    }
    for (std::size_t i = 0; i < count; ++i) {
        const char* text = raw.data() + i * length;
        texts.emplace_back(text, strnlen(text, length));
    }
    return texts;
}

/// One record of a [records, bodies, width] dataset.
std::vector<double> read_record(hid_t file, const char* name, hsize_t record,
                                const std::array<hsize_t, 2>& sizes) {
    const Handle dataset(H5Dopen2(file, name, H5P_DEFAULT), H5Dclose, name);
    const Handle space(H5Dget_space(dataset), H5Sclose, name);
    const std::array<hsize_t, 3> start{record, 0, 0}, count{1, sizes[0], sizes[1]};
    std::vector<double> values(sizes[0] * sizes[1]);
    const Handle memory(H5Screate_simple(3, count.data(), nullptr), H5Sclose, name);
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0 ||
        H5Dread(dataset, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, values.data()) < 0) {
        throw std::runtime_error("cannot read a record of " + std::string(name));
    }
    return values;
}

Vector vector_from(const nlohmann::json& values) {
    return {values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>()};
}

Polyhedron polyhedron_from(const nlohmann::json& shape) {
    Polyhedron solid;
    for (const nlohmann::json& point : shape.at("points")) {
        solid.vertices.push_back(vector_from(point));
    }
    for (const nlohmann::json& face : shape.at("faces")) {
        const auto corner = [&](std::size_t i) { return solid.vertices.at(face.at(i % face.size()).get<std::size_t>()); };
        solid.normals.push_back((corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized());
        for (std::size_t i = 0; i < face.size(); ++i) {
            if (face.at(i) < face.at((i + 1) % face.size())) { // each edge once
                solid.edges.push_back((corner(i + 1) - corner(i)).normalized());
            }
        }
    }
    return solid;
}

Piece piece_from(const nlohmann::json& shape) {
    const std::string kind = shape.at("kind").get<std::string>();
    if (kind == "box") {
        OrientedBox box;
        box.half_extents = vector_from(shape.at("half_extents"));
        return {box};
    }
    if (kind == "sphere") {
        return {Ball{Vector::Zero(), shape.at("radius").get<double>()}};
    }
    if (kind == "plane") {
        return {HalfSpace{}};
    }
    if (kind == "cylinder" || kind == "capsule") {
        const double radius = shape.at("radius").get<double>();
        const bool is_capsule = kind == "capsule";
        return {Rod{Vector::Zero(), Vector::UnitZ(), shape.at("half_length").get<double>(), is_capsule ? 0.0 : radius,
                    is_capsule ? radius : 0.0}};
    }
    if (kind == "hull") {
        return {polyhedron_from(shape)};
    }
    throw std::runtime_error("unknown kind of shape '" + kind + "'");
}

} // namespace

Solid solid_from_json(const std::string& text, bool is_static) {
    const nlohmann::json json = nlohmann::json::parse(text);
    Solid solid;
    solid.is_static = is_static;
    if (json.at("kind") != "compound") {
        solid.pieces.push_back(piece_from(json));
        return solid;
    }
    for (const nlohmann::json& part : json.at("parts")) {
        Piece piece = piece_from(part);
        const Vector position = vector_from(part.at("position"));
        const nlohmann::json& q = part.at("orientation");
        const Eigen::Quaterniond turn(q.at(0).get<double>(), q.at(1).get<double>(), q.at(2).get<double>(),
                                      q.at(3).get<double>());
        if (auto* box = std::get_if<OrientedBox>(&piece.shape)) {
            box->centre = position;
            box->axes = turn.normalized().toRotationMatrix();
        } else if (auto* ball = std::get_if<Ball>(&piece.shape)) {
            ball->centre = position;
        } else if (auto* rod = std::get_if<Rod>(&piece.shape)) {
            rod->centre = position;
            rod->axis = turn.normalized() * rod->axis;
        } else if (auto* polyhedron = std::get_if<Polyhedron>(&piece.shape)) {
            for (Vector& vertex : polyhedron->vertices) {
                vertex = turn.normalized() * vertex + position;
            }
            for (std::vector<Vector>* directions : {&polyhedron->normals, &polyhedron->edges}) {
                for (Vector& direction : *directions) {
                    direction = turn.normalized() * direction;
                }
            }
        }
        solid.pieces.push_back(piece);
    }
    return solid;
}

TrajectoryFile::TrajectoryFile(const std::string& path) : path_(path) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); // errors are thrown, not also printed
    file_ = static_cast<long>(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT));
    if (file_ < 0) {
        throw std::runtime_error("cannot open " + path);
    }
    time_ = read_doubles(file_, "/time", path);
    names_ = read_texts(file_, "/body/name", path);
    const std::vector<std::string> shapes = read_texts(file_, "/body/shape", path);
    const std::vector<double> mass = read_doubles(file_, "/body/mass", path);
    if (shapes.size() != names_.size() || mass.size() != names_.size()) {
        throw std::runtime_error(path + ": /body/name, /body/shape and /body/mass differ in length");
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        solids_.push_back(solid_from_json(shapes[i], mass[i] == 0.0));
    }
    for (const auto& [name, width] : {std::pair("/position", 3), std::pair("/orientation", 4)}) {
        const std::string what = path + ": " + name;
        const Handle dataset(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose, what);
        if (sizes_of(dataset, what) != std::vector<hsize_t>{time_.size(), names_.size(), hsize_t(width)}) {
            throw std::runtime_error(what + " has not the size [records, bodies, " + std::to_string(width) +
                                     "]");
        }
    }
}

TrajectoryFile::~TrajectoryFile() {
    if (file_ >= 0) {
        H5Fclose(file_);
    }
}

std::vector<Placement> TrajectoryFile::placements(std::size_t record) const {
    const std::vector<double> position = read_record(file_, "/position", record, {names_.size(), 3});
    const std::vector<double> turn = read_record(file_, "/orientation", record, {names_.size(), 4});
    std::vector<Placement> placements(names_.size());
    for (std::size_t i = 0; i < placements.size(); ++i) {
        placements[i].position = Vector(position[3 * i], position[3 * i + 1], position[3 * i + 2]);
        placements[i].orientation =
            Eigen::Quaterniond(turn[4 * i], turn[4 * i + 1], turn[4 * i + 2], turn[4 * i + 3]);
    }
    return placements;
}

} // namespace reference
