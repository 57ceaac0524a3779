#pragma once
/// The first video stream of a file -> pictures (sole user of libav for reading).
#include "render/picture/image.h"

#include <filesystem>
#include <memory>

namespace render {

class VideoReader {
public:
    /// Throws Error (io) if the file cannot be read or has no video that can be decoded.
    explicit VideoReader(const std::filesystem::path& path);
    ~VideoReader();
    VideoReader(VideoReader&&) noexcept;
    VideoReader& operator=(VideoReader&&) noexcept;

    /// The next frame in the order shown; false at the end. Throws Error (io).
    bool read(Image& image);

    /// [1/s] average rate as the file says.
    double fps() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
