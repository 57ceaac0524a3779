#include "sim/record/trajectory_contacts.h"

#include <algorithm>
#include <limits>

namespace sim::hdf5 {

namespace {

constexpr std::size_t bodies_table = 0;
constexpr std::size_t sticking_table = 1;
constexpr std::size_t first_vector_table = 2;

/// In no group of its own: its name begins with that of the group.
constexpr ContactLayout counts_layout{"_count", 1, "1"};

std::string path_of(const std::string& group, const ContactLayout& layout) {
    return std::string_view(layout.name) == counts_layout.name ? group + layout.name : group + "/" + layout.name;
}

/// Rows in a chunk.
constexpr hsize_t chunk_rows = 1024;

Eigen::Vector3f& vector_of(ContactSnapshot& contact, std::size_t layout) {
    return layout == contact_point    ? contact.point
           : layout == contact_normal ? contact.normal
                                      : contact.impulse;
}

/// Which rows of a table are meant.
Handle select_rows(const Checker& checker, hid_t dataset, hsize_t first, hsize_t count, hsize_t columns) {
    Handle space = checker.check(H5Dget_space(dataset), H5Sclose);
    const std::array<hsize_t, 2> start{first, 0};
    const std::array<hsize_t, 2> size{count, columns};
    checker.check(
        H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, size.data(), nullptr));
    return space;
}

Handle memory_space(const Checker& checker, hsize_t count, hsize_t columns) {
    const std::array<hsize_t, 2> size{count, columns};
    return checker.check(H5Screate_simple(2, size.data(), nullptr), H5Sclose);
}

} // namespace

// --- writing ---------------------------------------------------------------------------------------------

ContactWriter::ContactWriter(const Checker& checker, hid_t file, const std::string& group_name, ContactDetail detail)
    : checker_(checker), group_(group_name), counts_(create(counts_layout, H5T_STD_I64LE, file)) {
    if (detail != ContactDetail::all) {
        return;
    }
    const Handle settings = checker_.check(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
    checker_.check(H5Pset_obj_track_times(settings.get(), false));
    const Handle group =
        checker_.check(H5Gcreate2(file, group_.c_str(), H5P_DEFAULT, settings.get(), H5P_DEFAULT), H5Gclose);
    tables_.push_back(create(contact_bodies_layout, H5T_STD_I32LE, file));
    tables_.push_back(create(contact_sticking_layout, H5T_STD_I8LE, file));
    for (const ContactLayout& layout : contact_layouts) {
        tables_.push_back(create(layout, H5T_IEEE_F32LE, file));
    }
}

ContactWriter::Table ContactWriter::create(const ContactLayout& layout, hid_t file_type, hid_t file) const {
    const std::array<hsize_t, 2> size{0, layout.columns};
    const std::array<hsize_t, 2> limit{H5S_UNLIMITED, layout.columns};
    const std::array<hsize_t, 2> chunk{chunk_rows, layout.columns};
    const Handle space = checker_.check(H5Screate_simple(2, size.data(), limit.data()), H5Sclose);
    const Handle settings = dataset_settings(checker_, 2, chunk.data());
    Table table{checker_.check(H5Dcreate2(file, path_of(group_, layout).c_str(), file_type, space.get(), H5P_DEFAULT,
                                          settings.get(), H5P_DEFAULT),
                               H5Dclose),
                layout.columns};
    write_text_attribute(checker_, table.dataset.get(), "unit", layout.unit);
    return table;
}

void ContactWriter::append_rows(const Table& table, hid_t memory_type, hsize_t first, hsize_t count,
                                const void* data) {
    if (count == 0) {
        return;
    }
    const std::array<hsize_t, 2> size{first + count, table.columns};
    checker_.check(H5Dset_extent(table.dataset.get(), size.data()));
    const Handle rows = select_rows(checker_, table.dataset.get(), first, count, table.columns);
    const Handle memory = memory_space(checker_, count, table.columns);
    checker_.check(H5Dwrite(table.dataset.get(), memory_type, memory.get(), rows.get(), H5P_DEFAULT, data));
}

void ContactWriter::append(std::int64_t contact_count, std::span<const ContactSnapshot> contacts) {
    append_rows(counts_, H5T_NATIVE_INT64, records_++, 1, &contact_count);
    if (tables_.empty()) {
        return;
    }
    const hsize_t count = contacts.size();
    std::vector<std::int32_t> bodies;
    std::vector<std::int8_t> sticking;
    for (const ContactSnapshot& contact : contacts) {
        bodies.insert(bodies.end(), contact.bodies.begin(), contact.bodies.end());
        sticking.push_back(contact.is_sticking ? 1 : 0);
    }
    append_rows(tables_[bodies_table], H5T_NATIVE_INT32, contacts_, count, bodies.data());
    append_rows(tables_[sticking_table], H5T_NATIVE_INT8, contacts_, count, sticking.data());
    for (std::size_t i = 0; i < contact_layouts.size(); ++i) {
        std::vector<float> numbers;
        for (ContactSnapshot contact : contacts) {
            const Eigen::Vector3f& v = vector_of(contact, i);
            numbers.insert(numbers.end(), {v.x(), v.y(), v.z()});
        }
        append_rows(tables_[first_vector_table + i], H5T_NATIVE_FLOAT, contacts_, count, numbers.data());
    }
    contacts_ += count;
}

void ContactWriter::close() {
    checker_.check(counts_.dataset.close());
    for (Table& table : tables_) {
        checker_.check(table.dataset.close());
    }
}

// --- reading ---------------------------------------------------------------------------------------------

ContactReader::ContactReader(const Checker& checker, hid_t file, const std::string& group, std::size_t records)
    : checker_(checker), group_(group), first_(records + 1, 0) {
    const std::string counts_path = path_of(group_, counts_layout);
    if (H5Lexists(file, counts_path.c_str(), H5P_DEFAULT) <= 0) {
        return;
    }
    const Handle counts = open(counts_layout, file, records, H5T_INTEGER);
    std::vector<std::int64_t> numbers(records);
    checker_.check(H5Dread(counts.get(), H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()));
    for (std::size_t i = 0; i < records; ++i) {
        if (numbers[i] < 0 || numbers[i] > std::numeric_limits<std::int32_t>::max()) {
            checker_.fail("/" + counts_path + " is out of range");
        }
        first_[i + 1] = first_[i] + numbers[i];
    }
    detail_ = ContactDetail::count;
    if (H5Lexists(file, group_.c_str(), H5P_DEFAULT) <= 0) {
        return;
    }
    const auto rows = static_cast<hsize_t>(first_.back());
    tables_.push_back(open(contact_bodies_layout, file, rows, H5T_INTEGER));
    tables_.push_back(open(contact_sticking_layout, file, rows, H5T_INTEGER));
    for (const ContactLayout& layout : contact_layouts) {
        tables_.push_back(open(layout, file, rows, H5T_FLOAT));
    }
    detail_ = ContactDetail::all;
}

Handle ContactReader::open(const ContactLayout& layout, hid_t file, hsize_t rows, H5T_class_t type) const {
    const std::string name = path_of(group_, layout);
    Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!dataset.is_valid()) {
        checker_.fail("no readable dataset /" + name);
    }
    const Handle stored = checker_.check(H5Dget_type(dataset.get()), H5Tclose);
    if (H5Tget_class(stored.get()) != type) {
        checker_.fail("/" + name + " has the wrong type");
    }
    const Handle space = checker_.check(H5Dget_space(dataset.get()), H5Sclose);
    std::array<hsize_t, 2> size{};
    if (H5Sget_simple_extent_ndims(space.get()) != 2 ||
        H5Sget_simple_extent_dims(space.get(), size.data(), nullptr) < 0 || size[0] != rows ||
        size[1] != layout.columns) {
        checker_.fail("/" + name + " has the wrong size");
    }
    return dataset;
}

void ContactReader::read_rows(const Handle& dataset, hid_t memory_type, hsize_t columns, std::size_t record,
                              void* data) const {
    const auto first = static_cast<hsize_t>(first_[record]);
    const hsize_t count = static_cast<hsize_t>(first_[record + 1]) - first;
    const Handle rows = select_rows(checker_, dataset.get(), first, count, columns);
    const Handle memory = memory_space(checker_, count, columns);
    checker_.check(H5Dread(dataset.get(), memory_type, memory.get(), rows.get(), H5P_DEFAULT, data));
}

std::vector<ContactSnapshot> ContactReader::read(std::size_t record, std::size_t body_count) const {
    const auto size = static_cast<std::size_t>(count(record));
    if (tables_.empty() || size == 0) {
        return {};
    }
    std::vector<ContactSnapshot> contacts(size);
    std::vector<std::int32_t> bodies(2 * size);
    std::vector<std::int8_t> sticking(size);
    std::vector<float> numbers(3 * size);
    read_rows(tables_[bodies_table], H5T_NATIVE_INT32, 2, record, bodies.data());
    read_rows(tables_[sticking_table], H5T_NATIVE_INT8, 1, record, sticking.data());
    for (std::size_t i = 0; i < size; ++i) {
        contacts[i].bodies = {bodies[2 * i], bodies[2 * i + 1]};
        contacts[i].is_sticking = sticking[i] != 0;
        for (const std::int32_t body : contacts[i].bodies) {
            if (body < 0 || static_cast<std::size_t>(body) >= body_count) {
                checker_.fail("/" + path_of(group_, contact_bodies_layout) + " is out of range");
            }
        }
    }
    for (std::size_t k = 0; k < contact_layouts.size(); ++k) {
        read_rows(tables_[first_vector_table + k], H5T_NATIVE_FLOAT, 3, record, numbers.data());
        for (std::size_t i = 0; i < size; ++i) {
            vector_of(contacts[i], k) = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
        }
    }
    return contacts;
}

} // namespace sim::hdf5
