#pragma once
/// Values as bytes, for files that only the same program on the same kind of machine reads: `archive(value)` with a
/// ByteWriter puts them, with a ByteReader gets them, so that one list of them serves both.
#include "sim/base/error.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace sim {

/// A number, or a struct of numbers. Eigen's are such, too, though they have copy constructors.
template <typename T>
concept Plain = std::is_trivially_destructible_v<T> && !std::is_pointer_v<T>;

class ByteWriter {
public:
    template <Plain T>
    void operator()(const T& value) {
        append(&value, sizeof value);
    }
    template <Plain T>
    void operator()(const std::vector<T>& values) {
        (*this)(values.size());
        append(values.data(), values.size() * sizeof(T));
    }
    void operator()(const std::string& text) {
        (*this)(text.size());
        append(text.data(), text.size());
    }
    const std::string& bytes() const { return bytes_; }

private:
    void append(const void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }

    std::string bytes_;
};

class ByteReader {
public:
    /// bytes: live as long as this.
    explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}

    /// Throws Error (io) where the bytes end too early.
    template <Plain T>
    void operator()(T& value) {
        const std::string_view from = take(sizeof value);
        std::memcpy(static_cast<void*>(&value), from.data(), from.size());
    }
    template <Plain T>
    void operator()(std::vector<T>& values) {
        const std::string_view from = take_counted(sizeof(T));
        values.resize(from.size() / sizeof(T));
        if (!from.empty()) {
            std::memcpy(static_cast<void*>(values.data()), from.data(), from.size());
        }
    }
    void operator()(std::string& text) { text = take_counted(1); }
    /// [byte] not yet taken.
    std::size_t left() const { return bytes_.size(); }

private:
    std::string_view take(std::size_t size) {
        if (size > bytes_.size()) {
            throw Error(ExitCode::io, "bytes end too early");
        }
        const std::string_view taken = bytes_.substr(0, size);
        bytes_.remove_prefix(size);
        return taken;
    }
    std::string_view take_counted(std::size_t size) {
        std::size_t count = 0;
        (*this)(count);
        return take(std::min(count, bytes_.size() / size + 1) * size);
    }

    std::string_view bytes_;
};

/// FNV-1a over words of eight bytes: finds damage, stops nobody who means it.
inline std::uint64_t checksum(std::string_view bytes) {
    std::uint64_t hash = 14695981039346656037u;
    for (std::size_t at = 0; at < bytes.size(); at += sizeof hash) {
        std::uint64_t word = bytes.size();
        std::memcpy(&word, bytes.data() + at, std::min(sizeof word, bytes.size() - at));
        hash = (hash ^ word) * 1099511628211u;
    }
    return hash;
}

} // namespace sim
