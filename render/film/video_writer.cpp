#include "render/film/video_writer.h"

#include "render/film/av_handles.h"
#include "render/film/encoder.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace render {

using sim::Error;
using sim::ExitCode;

namespace {

/// SVT-AV1 has no other option for what it prints: 1 is errors only. Set before main(), while no thread reads the environment.
[[maybe_unused]] const int svt_is_quiet = setenv("SVT_LOG", "1", 0);

// Chroma from every source pixel, no shortcuts that depend on the processor.
constexpr int scaler_flags =
    SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT;

constexpr int chroma_left_h = 0;   // chroma position in 1/256 of a luma pixel: on the left column,
constexpr int chroma_left_v = 128; // between the two rows

int even(int size) {
    return size + size % 2;
}

} // namespace

void require_encoder(const VideoSettings& settings, int width, int height) {
    // Of libavcodec, which feeds x264: (width + 128) (height + 128) pixels of 8 bytes are less than 2^31.
    constexpr std::int64_t most_pixels = (std::int64_t{1} << 31) / 8 - 1;
    const std::int64_t pixels = (std::int64_t{even(width)} + 128) * (std::int64_t{even(height)} + 128);
    if (pixels > most_pixels) {
        throw Error(ExitCode::usage,
                    "a film of " + std::to_string(width) + "x" + std::to_string(height) + " has " +
                        std::to_string(pixels) + " pixels with the encoder's margin of 128 each way, expected at most " +
                        std::to_string(most_pixels) + ", x264's limit in libavcodec; choose a smaller size, or --no-video");
    }
    find_encoder(settings.encoder);
    if (settings.encoder != automatic_encoder) { // x264 takes whatever a scene may say, and longest to open
        quiet_libav();
        open_encoder(settings, even(width), even(height), true);
    }
}

struct VideoWriter::Impl {
    std::filesystem::path path;
    int width;                 // [px] of the pictures
    int height;                // [px]
    std::int64_t next_pts = 0; // frames added
    bool is_finished = false;
    OutputFormat format; // declared first: freed after what uses it
    IoContext io;
    AVStream* stream = nullptr; // owned by format
    CodecContext codec;
    Scaler scaler;
    Frame rgb; // [px] even(width) x even(height), RGB24
    Frame yuv; // the same as the encoder takes it
    Packet packet;

    Impl(const std::filesystem::path& p, int w, int h) : path(p), width(w), height(h) {}

    ~Impl() {
        io.reset();
        if (!is_finished) {
            std::error_code ignored; // nothing can be done about a part file that will not go
            std::filesystem::remove(sim::part_path(path), ignored);
        }
    }

    // A negative code of libav becomes an Error.
    int check(int code, ExitCode exit_code = ExitCode::io) const {
        if (code < 0) {
            fail(av_text(code), exit_code);
        }
        return code;
    }
    [[noreturn]] void fail(const std::string& reason, ExitCode exit_code = ExitCode::io) const {
        throw Error(exit_code, "cannot write " + path.string() + ": " + reason);
    }
    template <class T>
    void check_memory(const T& handle) const {
        if (handle == nullptr) {
            fail(av_text(AVERROR(ENOMEM)));
        }
    }

    void open_file();
    void open_codec(const VideoSettings& settings);
    void write_header(const VideoSettings& settings);
    void make_frames();
    void copy_padded(const Image& image);
    void encode(const AVFrame* frame);
};

void VideoWriter::Impl::open_file() {
    const std::string part = sim::part_path(path).string();
    AVFormatContext* raw_format = nullptr;
    // By the name without ".part".
    const AVOutputFormat* container = av_guess_format(nullptr, path.filename().string().c_str(), nullptr);
    check(avformat_alloc_output_context2(&raw_format, container, container == nullptr ? "mp4" : nullptr, part.c_str()));
    format.reset(raw_format);
    format->flags |= AVFMT_FLAG_BITEXACT; // no version of libavformat in the file
    // "file:" keeps a colon in the name from being read as a protocol. Fast start opens the file again by
    // url.
    const std::string url = "file:" + part;
    av_freep(&format->url);
    format->url = av_strdup(url.c_str());
    check_memory(format->url);
    AVIOContext* raw_io = nullptr;
    check(avio_open(&raw_io, url.c_str(), AVIO_FLAG_WRITE));
    io.reset(raw_io);
    format->pb = raw_io;
    stream = avformat_new_stream(format.get(), nullptr);
    check_memory(stream);
}

void VideoWriter::Impl::open_codec(const VideoSettings& settings) {
    try {
        codec = open_encoder(settings, even(width), even(height), (format->oformat->flags & AVFMT_GLOBALHEADER) != 0);
    } catch (const Error& error) {
        fail(error.what(), error.code());
    }
}

void VideoWriter::Impl::write_header(const VideoSettings& settings) {
    check(avcodec_parameters_from_context(stream->codecpar, codec.get()));
    if (codec->codec_id == AV_CODEC_ID_HEVC) { // in MP4
        stream->codecpar->codec_tag = MKTAG('h', 'v', 'c', '1'); // the name under which all players know it
    }
    stream->time_base = codec->time_base;
    stream->avg_frame_rate = codec->framerate;
    stream->r_frame_rate = codec->framerate;
    stream->sample_aspect_ratio = codec->sample_aspect_ratio;
    for (const auto& [key, value] : settings.metadata) {
        check(av_dict_set(&format->metadata, key.c_str(), value.c_str(), 0));
    }
    Dictionary options;
    if (av_opt_find(format->priv_data, "movflags", nullptr, 0, 0) != nullptr) {
        check(options.set("movflags", "+faststart+use_metadata_tags"));
    }
    check(avformat_write_header(format.get(), options.get()));
    if (options.first_key() != nullptr) {
        fail(std::string("the writer of films does not know the option '") + options.first_key() + "'");
    }
}

void VideoWriter::Impl::make_frames() {
    const auto make = [this](AVPixelFormat pixel_format) {
        Frame frame(av_frame_alloc());
        check_memory(frame);
        frame->format = pixel_format;
        frame->width = even(width);
        frame->height = even(height);
        check(av_frame_get_buffer(frame.get(), 0));
        return frame;
    };
    rgb = make(AV_PIX_FMT_RGB24);
    yuv = make(codec->pix_fmt);
    yuv->color_primaries = codec->color_primaries;
    yuv->color_trc = codec->color_trc;
    yuv->colorspace = codec->colorspace;
    yuv->color_range = codec->color_range;
    yuv->chroma_location = codec->chroma_sample_location;
    packet.reset(av_packet_alloc());
    check_memory(packet);

    scaler.reset(sws_alloc_context());
    check_memory(scaler);
    const auto set = [this](const char* key, std::int64_t value) {
        check(av_opt_set_int(scaler.get(), key, value, 0));
    };
    set("srcw", even(width));
    set("srch", even(height));
    set("src_format", AV_PIX_FMT_RGB24);
    set("src_range", 1);
    set("dstw", even(width));
    set("dsth", even(height));
    const int is_full = codec->color_range == AVCOL_RANGE_JPEG ? 1 : 0;
    set("dst_format", codec->pix_fmt);
    set("dst_range", is_full);
    if (is_full == 0) {
        set("dst_h_chr_pos", chroma_left_h);
        set("dst_v_chr_pos", chroma_left_v);
    }
    set("sws_flags", scaler_flags);
    check(sws_init_context(scaler.get(), nullptr, nullptr));
    const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
    constexpr int unity = 1 << 16; // contrast and saturation 1 in 16.16
    check(sws_setColorspaceDetails(scaler.get(), bt709, 1, bt709, is_full, 0, unity, unity));
}

void VideoWriter::Impl::copy_padded(const Image& image) {
    const std::size_t row_bytes = static_cast<std::size_t>(width) * 3;
    for (int y = 0; y < rgb->height; ++y) {
        const std::uint8_t* source =
            image.rgb.data() + row_bytes * static_cast<std::size_t>(std::min(y, height - 1));
        std::uint8_t* target = rgb->data[0] + static_cast<std::ptrdiff_t>(rgb->linesize[0]) * y;
        std::memcpy(target, source, row_bytes);
        if (rgb->width > width) {
            std::memcpy(target + row_bytes, source + row_bytes - 3, 3);
        }
    }
}

// A null frame asks for what the encoder still holds.
void VideoWriter::Impl::encode(const AVFrame* frame) {
    check(avcodec_send_frame(codec.get(), frame));
    while (true) {
        const int received = avcodec_receive_packet(codec.get(), packet.get());
        if (received == AVERROR(EAGAIN) || received == AVERROR_EOF) {
            return;
        }
        check(received);
        packet->duration = 1; // [frame]: the last frame is shown as long as the others
        av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
        packet->stream_index = stream->index;
        check(av_interleaved_write_frame(format.get(), packet.get())); // takes the packet's data
    }
}

VideoWriter::VideoWriter(const std::filesystem::path& path, int width, int height,
                         const VideoSettings& settings)
    : impl_(std::make_unique<Impl>(path, width, height)) {
    CHECK(width >= 1 && height >= 1);
    quiet_libav();
    impl_->open_file();
    impl_->open_codec(settings);
    impl_->write_header(settings);
    impl_->make_frames();
}

VideoWriter::~VideoWriter() = default;
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;

void VideoWriter::add(const Image& image) {
    CHECK(image.width == impl_->width && image.height == impl_->height);
    impl_->check(av_frame_make_writable(impl_->rgb.get()));
    impl_->check(av_frame_make_writable(impl_->yuv.get())); // the encoder may still hold the last one
    impl_->copy_padded(image);
    impl_->check(sws_scale_frame(impl_->scaler.get(), impl_->yuv.get(), impl_->rgb.get()));
    impl_->yuv->pts = impl_->next_pts++;
    impl_->encode(impl_->yuv.get());
}

void VideoWriter::finish() {
    CHECK(impl_->next_pts > 0 && !impl_->is_finished);
    impl_->encode(nullptr);
    impl_->check(av_write_trailer(impl_->format.get()));
    avio_flush(impl_->io.get());
    impl_->check(impl_->io->error);
    impl_->format->pb = nullptr;
    impl_->check(avio_close(impl_->io.release()));
    sim::commit_part(impl_->path);
    impl_->is_finished = true;
}

} // namespace render
