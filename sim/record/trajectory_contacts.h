#pragma once
/// The contacts, or impacts, of a trajectory file; the layout is told in sim/record/trajectory.h.
#include "sim/model/snapshot.h"
#include "sim/record/trajectory_hdf5.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace sim::hdf5 {

/// Appends contacts record by record.
class ContactWriter {
public:
    /// Creates the datasets of a group, "contact" or "impact", in an open file. Throws Error (io).
    ContactWriter(const Checker& checker, hid_t file, const std::string& group, ContactDetail detail);
    /// contacts: `count` of one record, or none where counts only are written.
    void append(std::int64_t count, std::span<const ContactSnapshot> contacts);
    /// Throws Error (io) if what is left cannot be written.
    void close();

private:
    /// A dataset that grows by rows.
    struct Table {
        Handle dataset;
        hsize_t columns = 1;
    };
    Table create(const ContactLayout& layout, hid_t file_type, hid_t file) const;
    void append_rows(const Table& table, hid_t memory_type, hsize_t first, hsize_t count, const void* data);

    Checker checker_;
    std::string group_;
    hsize_t records_ = 0;
    hsize_t contacts_ = 0;
    Table counts_;
    std::vector<Table> tables_; // bodies, sticking, then contact_layouts; none: counts only
};

/// Reads them back.
class ContactReader {
public:
    /// Throws Error (io) if they are damaged. `records`: of the trajectory.
    ContactReader(const Checker& checker, hid_t file, const std::string& group, std::size_t records);
    ContactDetail detail() const { return detail_; }
    std::int64_t count(std::size_t record) const { return first_[record + 1] - first_[record]; }
    /// The contacts of one record, of so many bodies. Throws Error (io).
    std::vector<ContactSnapshot> read(std::size_t record, std::size_t body_count) const;

private:
    Handle open(const ContactLayout& layout, hid_t file, hsize_t rows, H5T_class_t type) const;
    void read_rows(const Handle& dataset, hid_t memory_type, hsize_t columns, std::size_t record,
                   void* data) const;

    Checker checker_;
    std::string group_;
    ContactDetail detail_ = ContactDetail::none;
    std::vector<std::int64_t> first_; // [records + 1] row of each record
    std::vector<Handle> tables_;      // bodies, sticking, then contact_layouts
};

} // namespace sim::hdf5
