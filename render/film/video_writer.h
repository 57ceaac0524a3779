#pragma once
/// Pictures in memory -> a film's file, in the process (sole user of libav for writing).
///
/// MP4 with 4:2:0 of H.264 by x264, or by another encoder of libavcodec's, in the container that fits; constant frame rate, index at the front (fast
/// start). RGB is converted by BT.709 to the limited range with chroma sited left, and the stream is tagged so. With
/// x264 the same pictures and settings give the same bytes on every x86-64 processor and for any number of cores, with
/// the same versions of libav and x264.
///
/// 4:2:0 has one chroma sample for 2 x 2 pixels and H.264 can crop only by these, so an odd width or height
/// is made even by repeating the last column or row: a film of 641 x 361 pictures is 642 x 362.
#include "render/picture/image.h"
#include "sim/base/rational.h"

#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace render {

/// The encoder's name that stands for x264.
inline constexpr const char* automatic_encoder = "auto";

struct VideoSettings {
    sim::Rational fps{60, 1};      ///< [1/s] > 0, numerator and denominator below 2^31
    int crf = 18;                  ///< rate factor [-] 0 (of x264: lossless) .. 51; 18 looks like the source
    std::string preset = "medium"; ///< of x264 and x265: effort against file size
    std::string encoder = automatic_encoder; ///< libavcodec's name: one of encoder_names()
    int bits = 8;                            ///< of a colour: 8, or 10 where the encoder has it
    /// Key and text, written into the file in this order ("title", "comment", ...).
    std::vector<std::pair<std::string, std::string>> metadata{};
};

/// Of libavcodec's encoders, those of H.264, HEVC, AV1, VP9, ProRes and FFV1, in alphabetical order.
std::vector<std::string> encoder_names();

/// All names that a film's file may end in; the first is that of automatic_encoder.
inline constexpr std::array film_extensions{".mp4", ".webm", ".mov", ".mkv"};
/// What the file of an encoder's films ends in, by the container that fits; of an unknown one as automatic_encoder.
std::string film_extension(const std::string& encoder);

/// Throws Error (usage) if the encoder is not there or refuses such pictures, or the film is larger [px] than any takes,
/// before anything is written.
void require_encoder(const VideoSettings& settings, int width, int height);

class VideoWriter {
public:
    /// Opens path + ".part". width, height [px] >= 1: size of every picture.
    /// Throws Error: io if the file cannot be written, usage if the encoder refuses size or settings.
    VideoWriter(const std::filesystem::path& path, int width, int height, const VideoSettings& settings);
    /// Without finish() the part file is removed.
    ~VideoWriter();
    VideoWriter(VideoWriter&&) noexcept;
    VideoWriter& operator=(VideoWriter&&) noexcept;

    /// Appends one frame. The picture has the size given at the start: CHECK. Throws Error (io).
    void add(const Image& image);

    /// Writes what the encoder still holds and the index, and gives the file its name. At least one frame has
    /// been added: CHECK. Throws Error (io).
    void finish();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace render
