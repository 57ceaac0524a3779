#include "render/compare/picture.h"

#include "render/compare/png_reader.h"
#include "sim/base/error.h"

#include <fmt/format.h>
#include <libdeflate.h>
#include <stb_image.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <sys/stat.h>
#include <unistd.h>

namespace diff {

namespace {

using sim::Error;
using sim::ExitCode;

/// Of libdeflate: a difference picture of 1920x1080 takes 3 ms.
constexpr int deflate_level = 1;

struct CompressorDeleter {
    void operator()(libdeflate_compressor* p) const noexcept { libdeflate_free_compressor(p); }
};

struct StbDeleter {
    void operator()(std::uint8_t* p) const noexcept { stbi_image_free(p); }
};

class OpenFile {
public:
    explicit OpenFile(const std::filesystem::path& path) : fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
    OpenFile(const OpenFile&) = delete;
    OpenFile& operator=(const OpenFile&) = delete;
    ~OpenFile() {
        if (fd >= 0) {
            ::close(fd);
        }
    }
    const int fd;
};

[[noreturn]] void fail_to_read(const std::filesystem::path& path, int error_number) {
    throw Error(ExitCode::io, "cannot read " + path.string() + ": " + std::strerror(error_number));
}

void decode_jpeg(std::span<const std::uint8_t> bytes, const std::string& name, const PictureLimits& limits,
                 Picture& picture) {
    const auto fail = [&name]() {
        throw Error(ExitCode::io, name + ": damaged JPEG file: " + stbi_failure_reason());
    };
    CHECK(bytes.size() <= INT_MAX);
    const int size = static_cast<int>(bytes.size());
    int channels = 0;
    if (stbi_info_from_memory(bytes.data(), size, &picture.width, &picture.height, &channels) == 0) {
        fail();
    }
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(picture.width) * static_cast<std::uint64_t>(picture.height);
    if (pixels > limits.pixels) {
        throw Error(ExitCode::io, fmt::format("{}: {}x{} pixels are more than the {} accepted", name, picture.width,
                                              picture.height, limits.pixels));
    }
    const std::unique_ptr<std::uint8_t, StbDeleter> decoded(
        stbi_load_from_memory(bytes.data(), size, &picture.width, &picture.height, &channels, 3));
    if (decoded == nullptr) {
        fail();
    }
    picture.rgb.assign(decoded.get(), decoded.get() + pixels * 3);
    picture.alpha.clear();
    picture.fine_hash = 0;
    picture.texts.clear();
}

void put_u32(std::uint8_t* at, std::uint32_t value) {
    for (int i = 0; i < 4; ++i) {
        at[i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
    }
}

/// Appends one chunk: length, type, data, CRC of type and data (PNG specification, sec. 5.3).
void append_chunk(Bytes& file, const char* type, std::span<const std::uint8_t> data) {
    const std::size_t start = file.size();
    file.resize(start + 12 + data.size());
    std::uint8_t* chunk = file.data() + start;
    put_u32(chunk, static_cast<std::uint32_t>(data.size()));
    std::memcpy(chunk + 4, type, 4);
    std::copy(data.begin(), data.end(), chunk + 8);
    put_u32(chunk + 8 + data.size(), libdeflate_crc32(0, chunk + 4, 4 + data.size()));
}

/// A PNG file of rows without filter; type: PNG's colour type, of 8 bits a sample.
Bytes encode_rows(int width, int height, std::uint8_t type, std::span<const std::uint8_t> pixels,
                  std::span<const std::uint8_t> palette) {
    CHECK(width > 0 && height > 0);
    const std::size_t row_bytes = pixels.size() / static_cast<std::size_t>(height);
    Bytes raw;
    raw.reserve(pixels.size() + static_cast<std::size_t>(height));
    for (std::size_t at = 0; at < pixels.size(); at += row_bytes) {
        raw.push_back(0);
        raw.insert(raw.end(), pixels.data() + at, pixels.data() + at + row_bytes);
    }
    const std::unique_ptr<libdeflate_compressor, CompressorDeleter> compressor(
        libdeflate_alloc_compressor(deflate_level));
    CHECK(compressor != nullptr);
    Bytes packed(libdeflate_zlib_compress_bound(compressor.get(), raw.size()));
    packed.resize(
        libdeflate_zlib_compress(compressor.get(), raw.data(), raw.size(), packed.data(), packed.size()));
    CHECK(!packed.empty());
    std::array<std::uint8_t, 13> header{0, 0, 0, 0, 0, 0, 0, 0, 8, type, 0, 0, 0};
    put_u32(header.data(), static_cast<std::uint32_t>(width));
    put_u32(header.data() + 4, static_cast<std::uint32_t>(height));
    Bytes file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    append_chunk(file, "IHDR", header);
    if (!palette.empty()) {
        append_chunk(file, "PLTE", palette);
    }
    append_chunk(file, "IDAT", packed);
    append_chunk(file, "IEND", {});
    return file;
}

} // namespace

void read_file(const std::filesystem::path& path, const PictureLimits& limits, Bytes& bytes) {
    const OpenFile file(path);
    struct stat info {};
    if (file.fd < 0 || ::fstat(file.fd, &info) != 0) {
        fail_to_read(path, errno);
    }
    if (!S_ISREG(info.st_mode)) {
        throw Error(ExitCode::io, "cannot read " + path.string() + ": it is no file");
    }
    const auto size = static_cast<std::uint64_t>(info.st_size);
    if (size > limits.file_bytes) {
        throw Error(ExitCode::io, fmt::format("{}: {} bytes are more than the {} accepted", path.string(), size,
                                              limits.file_bytes));
    }
    bytes.resize(size);
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t n = ::read(file.fd, bytes.data() + done, bytes.size() - done);
        if (n < 0 && errno == EINTR) {
            continue;
        }
        if (n < 0) {
            fail_to_read(path, errno);
        }
        if (n == 0) {
            throw Error(ExitCode::io, "cannot read " + path.string() + ": it has become shorter meanwhile");
        }
        done += static_cast<std::size_t>(n);
    }
}

void decode_picture(std::span<const std::uint8_t> bytes, const std::string& name, const PictureLimits& limits,
                    Picture& picture, ReaderMemory& memory) {
    constexpr std::array<std::uint8_t, 3> jpeg{0xff, 0xd8, 0xff};
    if (is_png(bytes)) {
        decode_png(bytes, name, limits, picture, memory);
    } else if (bytes.size() > jpeg.size() && std::equal(jpeg.begin(), jpeg.end(), bytes.begin())) {
        decode_jpeg(bytes, name, limits, picture);
    } else {
        throw Error(ExitCode::io, name + ": neither a PNG nor a JPEG file");
    }
}

std::pair<int, int> size_of_picture(std::span<const std::uint8_t> bytes, const std::string& name,
                                    const PictureLimits& limits) {
    if (is_png(bytes)) {
        return size_of_png(bytes, name, limits);
    }
    Picture picture;
    ReaderMemory memory;
    decode_picture(bytes, name, limits, picture, memory);
    return {picture.width, picture.height};
}

bool is_equal(const Picture& a, const Picture& b) {
    return a.width == b.width && a.height == b.height && a.fine_hash == b.fine_hash && a.rgb == b.rgb &&
           a.alpha == b.alpha;
}

Bytes encode_png(const IndexedPicture& picture) {
    return encode_rows(picture.width, picture.height, 3, picture.indices, picture.palette);
}

Bytes encode_png(const Picture& picture) {
    return encode_rows(picture.width, picture.height, 2, picture.rgb, {});
}

} // namespace diff
