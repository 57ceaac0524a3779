#include "sim/base/file_io.h"
#include "sim/record/trajectory.h"
#include "sim/record/trajectory_contacts.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>

namespace sim {

using namespace hdf5;

namespace {

/// [-] Quaternions of another program, in single precision, are this far from length one at most.
constexpr double orientation_error = 1e-5;

} // namespace

struct TrajectoryReader::Impl {
    Checker checker;
    Handle file;
    std::array<Handle, record_layouts.size()> records;
    TrajectoryInfo info;
    std::vector<std::int64_t> steps;
    std::optional<ContactReader> contacts;
    std::optional<ContactReader> impacts;

    explicit Impl(const std::filesystem::path& path)
        : checker{path, "cannot read", "not a whole trajectory: "} {}

    std::uintmax_t file_size() const;
    Handle open_dataset(const std::string& name) const;
    std::vector<hsize_t> dimensions(hid_t space) const;
    std::vector<std::string> read_texts(const std::string& name, bool is_attribute) const;
    std::string read_text_attribute(const std::string& name) const;
    void read_numbers(const std::string& name, hid_t memory_type, std::size_t size, void* data) const;
    void read_description();
    void read_steps();
    void open_records();
    std::vector<double> read_record(std::size_t dataset, std::size_t record) const;
};

// Nothing in the file can be longer: a size beyond it is damage, not a reason to allocate it.
std::uintmax_t TrajectoryReader::Impl::file_size() const {
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(checker.path, error);
    return error ? 0 : size;
}

Handle TrajectoryReader::Impl::open_dataset(const std::string& name) const {
    Handle dataset(H5Dopen2(file.get(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.is_valid()) {
        checker.fail("no readable dataset /" + name);
    }
    return dataset;
}

std::vector<hsize_t> TrajectoryReader::Impl::dimensions(hid_t space) const {
    const int rank = H5Sget_simple_extent_ndims(space);
    checker.check(rank);
    std::vector<hsize_t> size(static_cast<std::size_t>(rank));
    checker.check(H5Sget_simple_extent_dims(space, size.data(), nullptr));
    return size;
}

// Texts padded with zeros, from a dataset of the file or an attribute of its root.
std::vector<std::string> TrajectoryReader::Impl::read_texts(const std::string& name,
                                                            bool is_attribute) const {
    const Handle source =
        is_attribute ? Handle(H5Aopen(file.get(), name.c_str(), H5P_DEFAULT), H5Aclose) : open_dataset(name);
    if (!source.is_valid()) {
        checker.fail("no readable attribute " + name);
    }
    const hid_t id = source.get();
    const Handle type = checker.check(is_attribute ? H5Aget_type(id) : H5Dget_type(id), H5Tclose);
    if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) != 0) {
        checker.fail(name + " has the wrong type");
    }
    const Handle space = checker.check(is_attribute ? H5Aget_space(id) : H5Dget_space(id), H5Sclose);
    const std::vector<hsize_t> size = dimensions(space.get());
    const std::size_t count = size.empty() ? 1 : size[0];
    const std::size_t length = H5Tget_size(type.get());
    if (size.size() > 1 || length == 0 || count > file_size() / length) {
        checker.fail(name + " has the wrong size");
    }
    std::string bytes(count * length, '\0');
    if (count > 0) {
        checker.check(is_attribute ? H5Aread(id, type.get(), bytes.data())
                                   : H5Dread(id, type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()));
    }
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < count; ++i) {
        const std::string padded = bytes.substr(i * length, length);
        texts.push_back(padded.substr(0, padded.find('\0')));
    }
    return texts;
}

std::string TrajectoryReader::Impl::read_text_attribute(const std::string& name) const {
    const std::vector<std::string> texts = read_texts(name, true);
    if (texts.size() != 1) {
        checker.fail("attribute " + name + " has the wrong size");
    }
    return texts.front();
}

// A dataset of one dimension with `size` numbers.
void TrajectoryReader::Impl::read_numbers(const std::string& name, hid_t memory_type, std::size_t size,
                                          void* data) const {
    const Handle dataset = open_dataset(name);
    const Handle type = checker.check(H5Dget_type(dataset.get()), H5Tclose);
    if (H5Tget_class(type.get()) != H5Tget_class(memory_type)) {
        checker.fail("/" + name + " has the wrong type");
    }
    const Handle space = checker.check(H5Dget_space(dataset.get()), H5Sclose);
    if (dimensions(space.get()) != std::vector<hsize_t>{size}) {
        checker.fail("/" + name + " has the wrong size");
    }
    if (size > 0) {
        checker.check(H5Dread(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
    }
}

void TrajectoryReader::Impl::read_description() {
    if (H5Aexists(file.get(), format_attribute) > 0) {
        const Handle attribute = checker.check(H5Aopen(file.get(), format_attribute, H5P_DEFAULT), H5Aclose);
        std::int64_t version = 0;
        checker.check(H5Aread(attribute.get(), H5T_NATIVE_INT64, &version));
        if (version != format_version) {
            checker.fail("its format is " + std::to_string(version) + ", this program reads " +
                         std::to_string(format_version));
        }
    }
    info.scene_name = read_text_attribute("scene_name");
    if (!is_file_name(info.scene_name)) {
        checker.fail("scene_name cannot be the name of a file");
    }
    info.scene_text = read_text_attribute("scene_text");
    info.program_version = read_text_attribute("program_version");
    info.overrides = read_texts("overrides", true);
    info.body_names = read_texts("body/name", false);
    info.body_shapes = read_texts("body/shape", false);
    if (info.body_shapes.size() != info.body_names.size()) {
        checker.fail("/body/shape has the wrong size");
    }
    info.body_masses.resize(info.body_names.size());
    read_numbers("body/mass", H5T_NATIVE_DOUBLE, info.body_masses.size(), info.body_masses.data());
}

void TrajectoryReader::Impl::read_steps() {
    const Handle dataset = open_dataset(step_layout.name);
    const Handle space = checker.check(H5Dget_space(dataset.get()), H5Sclose);
    const std::vector<hsize_t> size = dimensions(space.get());
    if (size.size() != 1 || size[0] > file_size() / sizeof(std::int64_t)) {
        checker.fail("/step has the wrong size");
    }
    steps.resize(size[0]);
    read_numbers(step_layout.name, H5T_NATIVE_INT64, steps.size(), steps.data());
    const bool ascends =
        std::adjacent_find(steps.begin(), steps.end(), std::greater_equal<>()) == steps.end();
    if (steps.empty() || steps.front() < 0 || !ascends) {
        checker.fail("/step does not ascend");
    }
}

void TrajectoryReader::Impl::open_records() {
    for (std::size_t i = 0; i < record_layouts.size(); ++i) {
        const std::string name = record_layouts[i].name;
        records[i] = open_dataset(name);
        const Handle type = checker.check(H5Dget_type(records[i].get()), H5Tclose);
        if (H5Tget_class(type.get()) != H5T_FLOAT) {
            checker.fail("/" + name + " has the wrong type");
        }
        const Extent extent(record_layouts[i], info.body_names.size());
        std::vector<hsize_t> expected(extent.size.begin(), extent.size.begin() + extent.rank);
        expected[0] = steps.size();
        const Handle space = checker.check(H5Dget_space(records[i].get()), H5Sclose);
        if (dimensions(space.get()) != expected) {
            checker.fail("/" + name + " has the wrong size");
        }
    }
}

std::vector<double> TrajectoryReader::Impl::read_record(std::size_t dataset, std::size_t record) const {
    const Extent extent(record_layouts[dataset], info.body_names.size());
    std::vector<double> numbers(extent.numbers());
    if (numbers.empty()) {
        return numbers;
    }
    const hid_t id = records[dataset].get();
    const std::array<hsize_t, 3> start{record, 0, 0};
    const Handle space = checker.check(H5Dget_space(id), H5Sclose);
    checker.check(
        H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.size.data(), nullptr));
    const Handle memory = checker.check(H5Screate_simple(extent.rank, extent.size.data(), nullptr), H5Sclose);
    checker.check(H5Dread(id, H5T_NATIVE_DOUBLE, memory.get(), space.get(), H5P_DEFAULT, numbers.data()));
    return numbers;
}

void require_same_bodies(const TrajectoryInfo& info, const SceneDef& scene, const std::string& path) {
    const std::size_t count = info.body_names.size();
    if (scene.bodies.size() != count) {
        throw Error(ExitCode::usage, path + " has " + std::to_string(count) + " bodies, its scene " +
                                         std::to_string(scene.bodies.size()));
    }
    for (std::size_t i = 0; i < count; ++i) {
        const BodyDef& body = scene.bodies[i];
        const char* other = body.name != info.body_names[i]                    ? "name"
                            : body.mass.mass != info.body_masses[i]            ? "mass"
                            : shape_to_json(body.shape) != info.body_shapes[i] ? "shape"
                                                                               : nullptr;
        if (other != nullptr) {
            throw Error(ExitCode::usage, path + ": the body '" + info.body_names[i] + "' has another " + other +
                                             " in its scene");
        }
    }
}

TrajectoryReader::TrajectoryReader(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(path)) {
    silence();
    // HDF5's own message for a missing file is half a page; the system's is what a user needs.
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error)) {
        const std::string reason = error ? error.message() : "not a file";
        throw Error(ExitCode::io, "cannot read " + path.string() + ": " + reason);
    }
    impl_->file = impl_->checker.check(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    impl_->read_description();
    impl_->read_steps();
    impl_->open_records();
    impl_->contacts.emplace(impl_->checker, impl_->file.get(), "contact", impl_->steps.size());
    impl_->impacts.emplace(impl_->checker, impl_->file.get(), "impact", impl_->steps.size());
}

TrajectoryReader::~TrajectoryReader() = default;
TrajectoryReader::TrajectoryReader(TrajectoryReader&&) noexcept = default;
TrajectoryReader& TrajectoryReader::operator=(TrajectoryReader&&) noexcept = default;

const TrajectoryInfo& TrajectoryReader::info() const {
    return impl_->info;
}

const std::vector<std::int64_t>& TrajectoryReader::steps() const {
    return impl_->steps;
}

ContactDetail TrajectoryReader::contacts() const {
    return impl_->contacts->detail();
}

Snapshot TrajectoryReader::read(std::size_t record) const {
    CHECK(record < impl_->steps.size());
    silence();
    const std::vector<double> time = impl_->read_record(time_record, record);
    const std::vector<double> position = impl_->read_record(position_record, record);
    const std::vector<double> orientation = impl_->read_record(orientation_record, record);
    const std::vector<double> velocity = impl_->read_record(velocity_record, record);
    const std::vector<double> angular_velocity = impl_->read_record(angular_velocity_record, record);
    Snapshot snapshot;
    snapshot.step = impl_->steps[record];
    snapshot.time = time.front();
    snapshot.bodies.resize(impl_->info.body_names.size());
    for (std::size_t i = 0; i < snapshot.bodies.size(); ++i) {
        const auto vector_of = [i](const std::vector<double>& v) {
            return Vec3(v[3 * i], v[3 * i + 1], v[3 * i + 2]);
        };
        const double* q = &orientation[4 * i];
        BodySnapshot& body = snapshot.bodies[i];
        body = {vector_of(position), Quat(q[0], q[1], q[2], q[3]), vector_of(velocity), vector_of(angular_velocity)};
        // Also false where a number is none.
        const bool is_turn = std::abs(body.orientation.norm() - 1.0) <= orientation_error;
        if (!is_turn || !body.position.allFinite() || !body.velocity.allFinite() ||
            !body.angular_velocity.allFinite()) {
            impl_->checker.fail("record " + std::to_string(record) + " has a body '" + impl_->info.body_names[i] +
                                "' with " + (is_turn ? "numbers that are not finite" : "no orientation of length one"));
        }
    }
    snapshot.contact_count = impl_->contacts->count(record);
    snapshot.contacts = impl_->contacts->read(record, snapshot.bodies.size());
    snapshot.impacts = impl_->impacts->read(record, snapshot.bodies.size());
    return snapshot;
}

} // namespace sim
