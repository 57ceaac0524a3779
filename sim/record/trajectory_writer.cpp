#include "sim/base/file_io.h"
#include "sim/model/shape.h"
#include "sim/record/trajectory.h"
#include "sim/record/trajectory_contacts.h"
#include "sim/record/trajectory_hdf5.h"

#include <algorithm>
#include <optional>

namespace sim {

using namespace hdf5;

namespace {

// Records are written in chunks of about this size [byte]: much smaller ones cost time, much larger ones
// space.
constexpr std::size_t chunk_bytes = 1 << 14;

/// Texts one after the other, each padded with zeros to the longest.
struct PaddedTexts {
    std::size_t length = 1;
    std::string bytes;

    explicit PaddedTexts(const std::vector<std::string>& texts) {
        for (const std::string& text : texts) {
            length = std::max(length, text.size());
        }
        for (const std::string& text : texts) {
            bytes += text;
            bytes.append(length - text.size(), '\0');
        }
    }
};

// The numbers of one record of one dataset.
void gather(const Snapshot& snapshot, std::size_t dataset, std::vector<double>& numbers) {
    numbers.clear();
    if (dataset == time_record) {
        numbers.push_back(snapshot.time);
        return;
    }
    for (const BodySnapshot& body : snapshot.bodies) {
        const Quat& q = body.orientation;
        const Vec3& v = dataset == position_record   ? body.position
                        : dataset == velocity_record ? body.velocity
                                                     : body.angular_velocity;
        if (dataset == orientation_record) {
            numbers.insert(numbers.end(), {q.w(), q.x(), q.y(), q.z()});
        } else {
            numbers.insert(numbers.end(), {v.x(), v.y(), v.z()});
        }
    }
}

} // namespace

struct TrajectoryWriter::Impl {
    Checker checker;
    std::size_t body_count;
    hsize_t record_count = 0;
    std::int64_t last_step = -1;
    bool is_finished = false;
    Handle file;
    Handle step;
    std::array<Handle, record_layouts.size()> records;
    std::optional<ContactWriter> contacts;
    std::optional<ContactWriter> impacts;
    std::vector<double> numbers; // one record of one dataset

    Impl(const std::filesystem::path& path, std::size_t bodies)
        : checker{path, "cannot write", ""}, body_count(bodies) {}

    ~Impl() {
        silence();
        step = Handle();
        records = {};
        contacts.reset();
        impacts.reset();
        file = Handle();
        H5Eclear2(H5E_DEFAULT); // a full disk fails here once more
        if (!is_finished) {
            std::error_code ignored; // nothing can be done about a part file that will not go
            std::filesystem::remove(part_path(checker.path), ignored);
        }
    }

    void open();
    void describe(const SceneDef& scene);
    Handle write_bodies(const char* name, hid_t type, const void* data);
    Handle create_records(const char* name, hid_t file_type, const Extent& extent);
    void append_record(hid_t dataset, hid_t memory_type, const Extent& extent, const void* data);
};

void TrajectoryWriter::Impl::open() {
    const Handle access = checker.check(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // The format of HDF5 1.10: its own structures carry checksums too.
    checker.check(H5Pset_libver_bounds(access.get(), H5F_LIBVER_V110, H5F_LIBVER_V110));
    const Handle creation = checker.check(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    checker.check(H5Pset_obj_track_times(creation.get(), false));   // of the root group
    const std::string part = part_path(checker.path).string();
    file = checker.check(H5Fcreate(part.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()), H5Fclose);
}

void TrajectoryWriter::Impl::describe(const SceneDef& scene) {
    const Handle one = checker.check(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle version = checker.check(
        H5Acreate2(file.get(), format_attribute, H5T_STD_I64LE, one.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    checker.check(H5Awrite(version.get(), H5T_NATIVE_INT64, &format_version));
    write_text_attribute(checker, file.get(), "scene_name", scene.name);
    write_text_attribute(checker, file.get(), "scene_text", scene.text);
    write_text_attribute(checker, file.get(), "program_version", TUMBLE_VERSION);
    const PaddedTexts overrides(scene.overrides);
    const hsize_t count = scene.overrides.size();
    const Handle type = text_type(checker, overrides.length);
    const Handle space = checker.check(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Handle attribute = checker.check(
        H5Acreate2(file.get(), "overrides", type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (count > 0) {
        checker.check(H5Awrite(attribute.get(), type.get(), overrides.bytes.data()));
    }

    std::vector<std::string> names;
    std::vector<std::string> shapes;
    std::vector<double> masses;
    std::vector<double> releases;
    for (const BodyDef& body : scene.bodies) {
        names.push_back(body.name);
        shapes.push_back(shape_to_json(body.shape));
        masses.push_back(body.mass.mass);
        releases.push_back(body.release);
    }
    const Handle settings = checker.check(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    checker.check(H5Pset_obj_track_times(settings.get(), false));
    const Handle group =
        checker.check(H5Gcreate2(file.get(), "body", H5P_DEFAULT, settings.get(), H5P_DEFAULT), H5Gclose);
    const PaddedTexts padded_names(names);
    write_bodies("body/name", text_type(checker, padded_names.length).get(), padded_names.bytes.data());
    const PaddedTexts padded_shapes(shapes);
    write_bodies("body/shape", text_type(checker, padded_shapes.length).get(), padded_shapes.bytes.data());
    const Handle mass = write_bodies("body/mass", H5T_IEEE_F64LE, masses.data());
    write_text_attribute(checker, mass.get(), "unit", "kg");
    if (std::ranges::any_of(releases, [](double release) { return release > 0.0; })) {
        const Handle release = write_bodies("body/release", H5T_IEEE_F64LE, releases.data());
        write_text_attribute(checker, release.get(), "unit", "s");
    }
}

// A dataset of one entry a body. The type in memory is the type in the file: little-endian like the machine.
Handle TrajectoryWriter::Impl::write_bodies(const char* name, hid_t type, const void* data) {
    const hsize_t count = body_count;
    const hsize_t chunk = std::max<hsize_t>(1, count);
    const Handle space = checker.check(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Handle settings = dataset_settings(checker, 1, &chunk);
    Handle dataset = checker.check(
        H5Dcreate2(file.get(), name, type, space.get(), H5P_DEFAULT, settings.get(), H5P_DEFAULT), H5Dclose);
    if (count > 0) {
        checker.check(H5Dwrite(dataset.get(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
    }
    return dataset;
}

// An empty dataset that grows by `extent` a record.
Handle TrajectoryWriter::Impl::create_records(const char* name, hid_t file_type, const Extent& extent) {
    std::array<hsize_t, 3> size = extent.size;
    std::array<hsize_t, 3> limit = extent.size;
    std::array<hsize_t, 3> chunk = extent.size;
    size[0] = 0;
    limit[0] = H5S_UNLIMITED;
    chunk[0] = std::max<hsize_t>(1, chunk_bytes / (sizeof(double) * std::max<hsize_t>(1, extent.numbers())));
    chunk[1] = std::max<hsize_t>(1, chunk[1]); // a scene without bodies
    const Handle space = checker.check(H5Screate_simple(extent.rank, size.data(), limit.data()), H5Sclose);
    const Handle settings = dataset_settings(checker, extent.rank, chunk.data());
    return checker.check(
        H5Dcreate2(file.get(), name, file_type, space.get(), H5P_DEFAULT, settings.get(), H5P_DEFAULT),
        H5Dclose);
}

void TrajectoryWriter::Impl::append_record(hid_t dataset, hid_t memory_type, const Extent& extent,
                                           const void* data) {
    std::array<hsize_t, 3> size = extent.size;
    size[0] = record_count + 1;
    checker.check(H5Dset_extent(dataset, size.data()));
    if (extent.numbers() == 0) {
        return;
    }
    const std::array<hsize_t, 3> start{record_count, 0, 0};
    const Handle space = checker.check(H5Dget_space(dataset), H5Sclose);
    checker.check(
        H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, extent.size.data(), nullptr));
    const Handle memory = checker.check(H5Screate_simple(extent.rank, extent.size.data(), nullptr), H5Sclose);
    checker.check(H5Dwrite(dataset, memory_type, memory.get(), space.get(), H5P_DEFAULT, data));
}

TrajectoryWriter::TrajectoryWriter(const std::filesystem::path& path, const SceneDef& scene,
                                   ContactDetail contacts)
    : impl_(std::make_unique<Impl>(path, scene.bodies.size())) {
    silence();
    impl_->open();
    impl_->describe(scene);
    impl_->step = impl_->create_records(step_layout.name, H5T_STD_I64LE, Extent(step_layout, 0));
    for (std::size_t i = 0; i < record_layouts.size(); ++i) {
        const RecordLayout& layout = record_layouts[i];
        impl_->records[i] =
            impl_->create_records(layout.name, H5T_IEEE_F64LE, Extent(layout, impl_->body_count));
        write_text_attribute(impl_->checker, impl_->records[i].get(), "unit", layout.unit);
    }
    if (contacts != ContactDetail::none) {
        impl_->contacts.emplace(impl_->checker, impl_->file.get(), "contact", contacts);
    }
    if (contacts == ContactDetail::all) {
        impl_->impacts.emplace(impl_->checker, impl_->file.get(), "impact", contacts);
    }
}

TrajectoryWriter::~TrajectoryWriter() = default;
TrajectoryWriter::TrajectoryWriter(TrajectoryWriter&&) noexcept = default;
TrajectoryWriter& TrajectoryWriter::operator=(TrajectoryWriter&&) noexcept = default;

void TrajectoryWriter::append(const Snapshot& snapshot) {
    CHECK(snapshot.bodies.size() == impl_->body_count);
    CHECK(snapshot.step > impl_->last_step);
    silence();
    impl_->append_record(impl_->step.get(), H5T_NATIVE_INT64, Extent(step_layout, 0), &snapshot.step);
    for (std::size_t i = 0; i < record_layouts.size(); ++i) {
        gather(snapshot, i, impl_->numbers);
        impl_->append_record(impl_->records[i].get(), H5T_NATIVE_DOUBLE,
                             Extent(record_layouts[i], impl_->body_count), impl_->numbers.data());
    }
    if (impl_->contacts) {
        impl_->contacts->append(snapshot.contact_count, snapshot.contacts);
    }
    if (impl_->impacts) {
        impl_->impacts->append(static_cast<std::int64_t>(snapshot.impacts.size()), snapshot.impacts);
    }
    impl_->last_step = snapshot.step;
    ++impl_->record_count;
}

void TrajectoryWriter::finish() {
    CHECK(!impl_->is_finished);
    silence();
    impl_->checker.check(impl_->step.close());
    for (Handle& dataset : impl_->records) {
        impl_->checker.check(dataset.close());
    }
    if (impl_->contacts) {
        impl_->contacts->close();
    }
    if (impl_->impacts) {
        impl_->impacts->close();
    }
    impl_->checker.check(impl_->file.close());
    commit_part(impl_->checker.path);
    impl_->is_finished = true;
}

} // namespace sim
