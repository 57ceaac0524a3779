#pragma once
/// HDF5's identifiers with an owner, its errors as Error, and the layout both halves of trajectory share.
/// Only trajectory_writer.cpp and trajectory_reader.cpp include this.
#include "sim/error.h"

#include <hdf5.h>

#include <array>
#include <cstddef>
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
