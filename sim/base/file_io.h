#pragma once
/// Files that appear whole or not at all: written as NAME.part, renamed when complete.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace sim {

/// True for what may be the name of a file or folder that the program makes: 1 to 200 bytes of UTF-8, not "." or "..", no
/// "/", no control characters.
bool is_file_name(std::string_view name);

/// The whole file. Throws Error (io).
std::string read_text_file(const std::filesystem::path& path);

/// The temporary name under which `path` is written: path + ".part".
std::filesystem::path part_path(const std::filesystem::path& path);

/// Flushes the finished part file to disk and renames it to `path`. Throws Error (io).
void commit_part(const std::filesystem::path& path);

/// Writes all bytes to the part file and commits it. Throws Error (io), removing the part file.
void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
/// The same, but until sync_files() has been called the file may be damaged by a power loss: for many files.
void write_file_unsynced(const std::filesystem::path& path, std::span<const std::uint8_t> bytes);
/// Flushes all that was written to the file system of `folder`. Throws Error (io).
void sync_files(const std::filesystem::path& folder);
void write_file(const std::filesystem::path& path, const std::string& text);

/// True where standard output is a pipe whose reader has gone, as `head` does when it has seen enough.
bool is_output_unread() noexcept;

/// SHA-256 of a file's bytes, 64 hexadecimal digits. Throws Error (io).
std::string sha256_of_file(const std::filesystem::path& path);

/// A file that has been written, for a report.
struct WrittenFile {
    std::string name;            ///< relative to the folder of the report
    std::uintmax_t bytes = 0;
    std::string sha256;          ///< 64 hexadecimal digits
};

/// Size and SHA-256 of folder / name. Throws Error (io).
WrittenFile describe_file(const std::filesystem::path& folder, const std::string& name);

} // namespace sim
