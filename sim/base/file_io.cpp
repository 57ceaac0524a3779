#include "sim/base/file_io.h"

#include "sim/base/error.h"
#include "sim/base/utf8.h"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace sim {

namespace {

constexpr std::size_t chunk_size = 1 << 16; // [byte] read at a time
constexpr std::size_t longest_name = 200; // [byte]: with what is appended to it, a file system's 255
constexpr std::size_t most_text = 1 << 28;  // [byte] of a file read as a whole: 256 MiB

bool is_utf8(std::string_view text) {
    while (const std::size_t length = utf8_length(text)) {
        text.remove_prefix(length);
    }
    return text.empty();
}

[[noreturn]] void fail(const char* what, const std::filesystem::path& path, int error_number) {
    throw Error(ExitCode::io,
                std::string("cannot ") + what + " " + path.string() + ": " + std::strerror(error_number));
}

/// An open file descriptor; the destructor only releases it.
class Descriptor {
public:
    /// Messages say "cannot <what> <shown>".
    Descriptor(const std::filesystem::path& path, int flags, const char* what,
               const std::filesystem::path& shown)
        : shown_(shown), what_(what) {
        do {
            fd_ = ::open(path.c_str(), flags | O_CLOEXEC, 0666);
        } while (fd_ < 0 && errno == EINTR);
        if (fd_ < 0) {
            fail(what, shown, errno);
        }
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (fd_ >= 0) {
            ::close(fd_);
        }
    }

    /// Bytes read, 0 at the end of the file.
    std::size_t read(std::span<char> buffer) {
        while (true) {
            const ssize_t n = ::read(fd_, buffer.data(), buffer.size());
            if (n >= 0) {
                return static_cast<std::size_t>(n);
            }
            if (errno != EINTR) {
                fail(what_, shown_, errno);
            }
        }
    }

    void write_all(std::span<const std::uint8_t> bytes) {
        while (!bytes.empty()) {
            const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
            if (n < 0) {
                if (errno == EINTR) {
                    continue;
                }
                fail(what_, shown_, errno);
            }
            bytes = bytes.subspan(static_cast<std::size_t>(n));
        }
    }

    void sync() {
        if (::fsync(fd_) != 0) {
            fail(what_, shown_, errno);
        }
    }

    void sync_file_system() {
        if (::syncfs(fd_) != 0) {
            fail(what_, shown_, errno);
        }
    }

    void close() {
        const int fd = std::exchange(fd_, -1);
        if (::close(fd) != 0) {
            fail(what_, shown_, errno);
        }
    }

private:
    std::filesystem::path shown_;
    const char* what_;
    int fd_ = -1;
};

/// Makes a rename in `folder` last through a power loss. Some file systems cannot sync a folder (EINVAL).
void sync_folder(const std::filesystem::path& folder) {
    const std::filesystem::path name = folder.empty() ? "." : folder;
    const int fd = ::open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd < 0) {
        return; // a folder we may write but not read: the rename itself has succeeded
    }
    const int result = ::fsync(fd);
    const int error_number = errno;
    ::close(fd);
    if (result != 0 && error_number != EINVAL) {
        fail("write", name, error_number);
    }
}

void rename_part(const std::filesystem::path& path) {
    if (::rename(part_path(path).c_str(), path.c_str()) != 0) {
        fail("write", path, errno);
    }
}

/// The part file, then what makes it whole; removes it if either fails.
template <class Commit>
void write_part(const std::filesystem::path& path, std::span<const std::uint8_t> bytes,
                const Commit& commit) {
    const std::filesystem::path part = part_path(path);
    try {
        Descriptor file(part, O_WRONLY | O_CREAT | O_TRUNC, "write", path);
        file.write_all(bytes);
        file.close();
        commit();
    } catch (...) {
        ::unlink(part.c_str()); // fails only where there is nothing to remove
        throw;
    }
}

} // namespace

bool is_file_name(std::string_view name) {
    const auto is_bad = [](unsigned char c) { return c < 0x20 || c == 0x7f || c == '/'; };
    return !name.empty() && name.size() <= longest_name && name != "." && name != ".." && is_utf8(name) &&
           std::none_of(name.begin(), name.end(), is_bad);
}

std::string read_text_file(const std::filesystem::path& path) {
    Descriptor file(path, O_RDONLY, "read", path);
    std::string text;
    std::array<char, chunk_size> buffer;
    while (const std::size_t n = file.read(buffer)) {
        text.append(buffer.data(), n);
        if (text.size() > most_text) {
            throw Error(ExitCode::io, "cannot read " + path.string() + ": it is larger than 256 MiB");
        }
    }
    return text;
}

std::filesystem::path part_path(const std::filesystem::path& path) {
    std::filesystem::path part = path;
    part += ".part";
    return part;
}

void commit_part(const std::filesystem::path& path) {
    const std::filesystem::path part = part_path(path);
    Descriptor file(part, O_RDONLY, "write", path);
    file.sync();
    file.close();
    rename_part(path);
    sync_folder(path.parent_path());
}

void write_file(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
    write_part(path, bytes, [&] { commit_part(path); });
}

void write_file_unsynced(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
    write_part(path, bytes, [&] { rename_part(path); });
}

void sync_files(const std::filesystem::path& folder) {
    Descriptor descriptor(folder, O_RDONLY | O_DIRECTORY, "write", folder);
    descriptor.sync_file_system();
    descriptor.close();
}

bool is_output_unread() noexcept {
    pollfd output{STDOUT_FILENO, POLLOUT, 0};
    return ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

void write_file(const std::filesystem::path& path, const std::string& text) {
    write_file(path, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
}

std::string sha256_of_file(const std::filesystem::path& path) {
    const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
    const auto check = [&path](bool ok) {
        if (!ok) {
            throw Error(ExitCode::io, "cannot compute the SHA-256 of " + path.string());
        }
    };
    check(context != nullptr && EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr) == 1);
    Descriptor file(path, O_RDONLY, "read", path);
    std::array<char, chunk_size> buffer;
    while (const std::size_t n = file.read(buffer)) {
        check(EVP_DigestUpdate(context.get(), buffer.data(), n) == 1);
    }
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned int length = 0;
    check(EVP_DigestFinal_ex(context.get(), digest.data(), &length) == 1);
    std::string text;
    for (unsigned int i = 0; i < length; ++i) {
        constexpr const char* digits = "0123456789abcdef";
        text += digits[digest[i] >> 4];
        text += digits[digest[i] & 15];
    }
    return text;
}

WrittenFile describe_file(const std::filesystem::path& folder, const std::string& name) {
    const std::filesystem::path path = folder / name;
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(path, error);
    if (error) {
        throw Error(ExitCode::io, "cannot read " + path.string() + ": " + error.message());
    }
    return {name, bytes, sha256_of_file(path)};
}

} // namespace sim
