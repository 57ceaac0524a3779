#include "render/film/encoder.h"

#include "sim/base/error.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <set>
#include <utility>
#include <vector>

namespace render {

using sim::Error;
using sim::ExitCode;

namespace {

// One thread and no code path chosen by the processor: with x264's defaults both bytes and decoded pixels
// change with the number of cores and with SSE4.2 or AVX2.
const std::string reproducible_x264 = "threads=1:lookahead-threads=1:cpu-independent=1";

// Quicker search for motion in the preset that films have by default: 40 % less time, files larger by a quarter.
constexpr const char* quick_search = ":subme=1:me=dia:partitions=none";

// The same of x265, which also would write to stderr by itself.
constexpr const char* reproducible_x265 = "pools=none:frame-threads=1:log-level=none";

/// A codec that films are made with, the names of its containers, and pixels of 8 and 10 bits a colour in the order of
/// preference.
struct FilmCodec {
    AVCodecID id;
    const char* extension;
    std::array<AVPixelFormat, 2> pixels_8;
    std::array<AVPixelFormat, 2> pixels_10;
};

constexpr FilmCodec video_420(AVCodecID id, const char* extension) {
    return {id, extension, {AV_PIX_FMT_YUV420P, AV_PIX_FMT_NONE}, {AV_PIX_FMT_YUV420P10, AV_PIX_FMT_P010}};
}

// ProRes has no 8 bits; FFV1 keeps red, green and blue as they are.
constexpr FilmCodec film_codecs[] = {
    video_420(AV_CODEC_ID_H264, ".mp4"),
    video_420(AV_CODEC_ID_HEVC, ".mp4"),
    video_420(AV_CODEC_ID_AV1, ".mp4"),
    video_420(AV_CODEC_ID_VP9, ".webm"),
    {AV_CODEC_ID_PRORES, ".mov", {AV_PIX_FMT_YUV422P10, AV_PIX_FMT_NONE}, {AV_PIX_FMT_YUV422P10, AV_PIX_FMT_NONE}},
    {AV_CODEC_ID_FFV1, ".mkv", {AV_PIX_FMT_BGR0, AV_PIX_FMT_NONE}, {AV_PIX_FMT_GBRP10, AV_PIX_FMT_NONE}},
};

/// Null if no films are made with it.
const FilmCodec* film_codec(const AVCodec& codec) {
    const auto* known = std::ranges::find(film_codecs, codec.id, &FilmCodec::id);
    return av_codec_is_encoder(&codec) != 0 && known != std::end(film_codecs) ? known : nullptr;
}

void check(int code) {
    if (code < 0) {
        throw Error(ExitCode::io, av_text(code));
    }
}

/// Effort and quality, under the names that the encoder has for them.
void set_options(AVCodecContext& codec, const AVCodec& encoder, const VideoSettings& settings, Dictionary& options) {
    const std::string name = encoder.name;
    const auto has = [&](const char* option) {
        return encoder.priv_class != nullptr && av_opt_find(codec.priv_data, option, nullptr, 0, 0) != nullptr;
    };
    const std::string quality = std::to_string(settings.crf);
    if (codec.codec_id == AV_CODEC_ID_FFV1) {
        codec.level = 3; // the version that archives keep; lossless
        return;
    }
    if (name == "libx264" || name == "libx265") {
        check(options.set("preset", settings.preset.c_str()));
    }
    if (name == "libx264") {
        const bool is_quick = settings.preset == "veryfast";
        check(options.set("x264-params", (reproducible_x264 + (is_quick ? quick_search : "")).c_str()));
    } else if (name == "libx265") {
        check(options.set("x265-params", reproducible_x265));
    }
    if (has("crf")) {
        check(options.set("crf", quality.c_str()));
    } else if (has("cq")) { // of NVENC: quality as such, no bit rate
        check(options.set("rc", "vbr"));
        check(options.set("cq", quality.c_str()));
    } else if (has("qp")) {
        check(options.set("qp", quality.c_str()));
    } else if (codec.codec_id == AV_CODEC_ID_PRORES) {
        check(options.set("vendor", "apl0")); // what other programs expect; its profile decides on the quality
    } else {
        codec.flags |= AV_CODEC_FLAG_QSCALE;
        codec.global_quality = settings.crf * FF_QP2LAMBDA;
    }
}

/// Those of the encoder's that have as many bits; none: the first of the codec's, which it then refuses.
AVPixelFormat pixel_format(const AVCodec& encoder, int bits) {
    const FilmCodec& known = *film_codec(encoder);
    const std::array<AVPixelFormat, 2>& wanted = bits == 10 ? known.pixels_10 : known.pixels_8;
    for (const AVPixelFormat format : wanted) {
        for (const AVPixelFormat* has = encoder.pix_fmts; has != nullptr && *has != AV_PIX_FMT_NONE; ++has) {
            if (*has == format) {
                return format;
            }
        }
    }
    throw Error(ExitCode::usage, fmt::format("{} has no pixels of {} bits a colour that films are made with",
                                             encoder.name, bits));
}

/// Size, rate, colours and what they mean.
void set_format(AVCodecContext& codec, const VideoSettings& settings, int width, int height) {
    constexpr std::int64_t int_limit = std::numeric_limits<int>::max();
    if (settings.fps.num <= 0 || settings.fps.num > int_limit || settings.fps.den > int_limit) {
        throw Error(ExitCode::usage, "frame rate out of range");
    }
    const AVRational fps{static_cast<int>(settings.fps.num), static_cast<int>(settings.fps.den)};
    codec.width = width;
    codec.height = height;
    codec.pix_fmt = pixel_format(*codec.codec, settings.bits);
    codec.time_base = av_inv_q(fps);
    codec.framerate = fps;
    codec.sample_aspect_ratio = {1, 1};
    codec.color_primaries = AVCOL_PRI_BT709;
    codec.color_trc = AVCOL_TRC_BT709;
    const bool is_rgb = codec.codec_id == AV_CODEC_ID_FFV1;
    codec.colorspace = is_rgb ? AVCOL_SPC_RGB : AVCOL_SPC_BT709;
    codec.color_range = is_rgb ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
    codec.chroma_sample_location = is_rgb ? AVCHROMA_LOC_UNSPECIFIED : AVCHROMA_LOC_LEFT;
    codec.thread_count = 1;
    codec.flags |= AV_CODEC_FLAG_BITEXACT;
}

} // namespace

const AVCodec& find_encoder(const std::string& name) {
    const std::string word = name == automatic_encoder ? "libx264" : name;
    const AVCodec* codec = avcodec_find_encoder_by_name(word.c_str());
    if (codec == nullptr || film_codec(*codec) == nullptr) {
        throw Error(ExitCode::usage, fmt::format("this libavcodec has no encoder '{}' of films, but: {}", word,
                                                 fmt::join(encoder_names(), ", ")));
    }
    return *codec;
}

std::vector<std::string> encoder_names() {
    std::set<std::string> names;
    void* place = nullptr;
    while (const AVCodec* codec = av_codec_iterate(&place)) {
        if (film_codec(*codec) != nullptr) {
            names.insert(codec->name);
        }
    }
    return {names.begin(), names.end()};
}

std::string film_extension(const std::string& encoder) {
    if (encoder == automatic_encoder) {
        return film_extensions.front();
    }
    const AVCodec* codec = avcodec_find_encoder_by_name(encoder.c_str());
    const FilmCodec* known = codec == nullptr ? nullptr : film_codec(*codec);
    return known == nullptr ? film_extensions.front() : known->extension;
}

CodecContext open_encoder(const VideoSettings& settings, int width, int height, bool is_headed_by_file) {
    const AVCodec& encoder = find_encoder(settings.encoder);
    CodecContext codec(avcodec_alloc_context3(&encoder));
    if (codec == nullptr) {
        throw std::bad_alloc();
    }
    set_format(*codec, settings, width, height);
    if (is_headed_by_file) {
        codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    Dictionary options;
    set_options(*codec, encoder, settings, options);
    const int opened = avcodec_open2(codec.get(), &encoder, options.get());
    if (opened < 0) {
        throw Error(ExitCode::usage,
                    fmt::format("{} refuses a film of {}x{} with crf {} and preset '{}': {}", encoder.name, width,
                                height, settings.crf, settings.preset, av_text(opened)));
    }
    if (options.first_key() != nullptr) {
        throw Error(ExitCode::usage, fmt::format("{} does not know the option '{}'", encoder.name, options.first_key()));
    }
    return codec;
}

} // namespace render
