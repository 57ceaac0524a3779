#pragma once
/// HDF5's identifiers with an owner, its errors as Error, and the layout both halves of trajectory share.
/// Only trajectory_writer.cpp, trajectory_reader.cpp and trajectory_contacts include this.
#include "sim/base/error.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

namespace sim::hdf5 {

/// One of HDF5's identifiers and the function that closes it.
class Handle {
public:
    Handle() = default;
    Handle(hid_t id, herr_t (*closer)(hid_t)) : id_(id), closer_(closer) {}
    Handle(Handle&& other) noexcept
        : id_(std::exchange(other.id_, H5I_INVALID_HID)), closer_(other.closer_) {}
    Handle& operator=(Handle&& other) noexcept {
        std::swap(id_, other.id_);
        std::swap(closer_, other.closer_);
        return *this;
    }
    ~Handle() {
        if (id_ >= 0) {
            closer_(id_);
        }
    }

    hid_t get() const { return id_; }
    bool is_valid() const { return id_ >= 0; }
    /// Negative on failure: what was cached could not be written.
    herr_t close() { return closer_(std::exchange(id_, H5I_INVALID_HID)); }

private:
    hid_t id_ = H5I_INVALID_HID;
    herr_t (*closer_)(hid_t) = nullptr;
};

/// HDF5 prints its errors unless told not to, thread by thread; what matters arrives as a return value.
/// Nor may it close at exit what a full disk left open: it would try for ever.
inline void silence() {
    H5dont_atexit();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

inline herr_t keep_first_description(unsigned, const H5E_error2_t* error, void* text) noexcept {
    auto& description = *static_cast<std::string*>(text);
    if (description.empty() && error->desc != nullptr) {
        description = error->desc;
    }
    return 0;
}

/// The innermost reason of HDF5's last failure; the system's own message where there is one. HDF5 forgets it.
inline std::string last_error() {
    std::string text;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_first_description, &text);
    H5Eclear2(H5E_DEFAULT);
    constexpr std::string_view mark = "error message = '";
    const std::size_t begin = text.find(mark);
    if (begin != std::string::npos) {
        const std::size_t from = begin + mark.size();
        return text.substr(from, text.find('\'', from) - from);
    }
    return text.empty() ? "unknown HDF5 error" : text;
}

/// Turns HDF5's return codes into Error (io) about one file.
struct Checker {
    std::filesystem::path path;
    const char* what;  ///< "cannot read", "cannot write"
    const char* about; ///< before the reason, may be empty

    [[noreturn]] void fail(const std::string& reason) const {
        throw Error(ExitCode::io, std::string(what) + " " + path.string() + ": " + about + reason);
    }
    void check(herr_t status) const {
        if (status < 0) {
            fail(last_error());
        }
    }
    Handle check(hid_t id, herr_t (*closer)(hid_t)) const {
        if (id < 0) {
            fail(last_error());
        }
        return Handle(id, closer);
    }
};

/// The datasets with one record a frame.
struct RecordLayout {
    const char* name;
    int columns; ///< numbers a body; 0: one number a record
    const char* unit;
};
enum RecordIndex {
    time_record,
    position_record,
    orientation_record,
    velocity_record,
    angular_velocity_record
};
inline constexpr std::array<RecordLayout, 5> record_layouts{{{"time", 0, "s"},
                                                             {"position", 3, "m"},
                                                             {"orientation", 4, "1"},
                                                             {"velocity", 3, "m/s"},
                                                             {"angular_velocity", 3, "rad/s"}}};
inline constexpr RecordLayout step_layout{"step", 0, "1"};

/// The contacts of all records, one after the other; names within their group.
struct ContactLayout {
    const char* name;
    hsize_t columns;
    const char* unit;
};
enum ContactIndex { contact_point, contact_normal, contact_impulse };
inline constexpr ContactLayout contact_bodies_layout{"bodies", 2, "1"};
inline constexpr ContactLayout contact_sticking_layout{"sticking", 1, "1"};
inline constexpr std::array<ContactLayout, 3> contact_layouts{
    {{"point", 3, "m"}, {"normal", 3, "1"}, {"impulse", 3, "N s"}}};

/// Attribute of the root: the layout of the file, counted up when a reader of the one before would misread it. Files
/// without it are of the first.
inline constexpr const char* format_attribute = "format_version";
inline constexpr std::int64_t format_version = 1;

/// Settings of a dataset in chunks, each with a checksum, and without the time of writing.
inline Handle dataset_settings(const Checker& checker, int rank, const hsize_t* chunk) {
    Handle settings = checker.check(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    checker.check(H5Pset_chunk(settings.get(), rank, chunk));
    checker.check(H5Pset_fletcher32(settings.get()));
    checker.check(H5Pset_obj_track_times(settings.get(), false));
    return settings;
}

/// Texts have a fixed length, padded with zeros: unlike HDF5's variable ones they are covered by checksums.
inline Handle text_type(const Checker& checker, std::size_t length) {
    Handle type = checker.check(H5Tcopy(H5T_C_S1), H5Tclose);
    checker.check(H5Tset_size(type.get(), std::max<std::size_t>(length, 1)));
    checker.check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD));
    checker.check(H5Tset_cset(type.get(), H5T_CSET_UTF8));
    return type;
}

inline void write_text_attribute(const Checker& checker, hid_t object, const char* name,
                                 const std::string& text) {
    const Handle type = text_type(checker, text.size());
    const Handle space = checker.check(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle attribute =
        checker.check(H5Acreate2(object, name, type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    checker.check(H5Awrite(attribute.get(), type.get(), text.c_str()));
}

/// The extent of one record: 1, body_count, columns (or only 1).
struct Extent {
    int rank = 1;
    std::array<hsize_t, 3> size{1, 1, 1};

    Extent(const RecordLayout& layout, std::size_t body_count) {
        if (layout.columns > 0) {
            rank = 3;
            size = {1, body_count, static_cast<hsize_t>(layout.columns)};
        }
    }
    hsize_t numbers() const { return size[0] * size[1] * size[2]; }
};

} // namespace sim::hdf5
