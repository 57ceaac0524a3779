#include "render/film/video_reader.h"

#include "render/film/av_handles.h"
#include "sim/base/error.h"

namespace render {

using sim::Error;
using sim::ExitCode;

struct VideoReader::Impl {
    std::filesystem::path path;
    InputFormat format;
    int stream = -1;
    CodecContext codec;
    Frame frame;
    Packet packet;
    Scaler scaler; // for the size and pixel format of the last frame
    bool is_at_end = false;

    explicit Impl(const std::filesystem::path& p)
        : path(p), frame(av_frame_alloc()), packet(av_packet_alloc()) {
        CHECK(frame != nullptr && packet != nullptr);
        quiet_libav();
        AVFormatContext* raw = nullptr;
        check(avformat_open_input(&raw, path.c_str(), nullptr, nullptr));
        format.reset(raw);
        check(avformat_find_stream_info(raw, nullptr));
        const AVCodec* decoder = nullptr;
        stream = check(av_find_best_stream(raw, AVMEDIA_TYPE_VIDEO, -1, -1, &decoder, 0));
        codec.reset(avcodec_alloc_context3(decoder));
        CHECK(codec != nullptr);
        check(avcodec_parameters_to_context(codec.get(), raw->streams[stream]->codecpar));
        codec->err_recognition =
            AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_EXPLODE; // a damaged frame is an error
        check(avcodec_open2(codec.get(), decoder, nullptr));
    }

    int check(int code) const {
        if (code < 0) {
            fail(av_text(code));
        }
        return code;
    }
    [[noreturn]] void fail(const std::string& reason) const {
        throw Error(ExitCode::io, "cannot read the film " + path.string() + ": " + reason);
    }

    // Hands packets to the decoder until it has a frame.
    bool decode() {
        while (true) {
            const int code = avcodec_receive_frame(codec.get(), frame.get());
            if (code == 0) {
                return true;
            }
            if (code == AVERROR_EOF) {
                return false;
            }
            if (code != AVERROR(EAGAIN)) {
                check(code);
            }
            feed();
        }
    }

    void feed() {
        while (!is_at_end) {
            const int code = av_read_frame(format.get(), packet.get());
            if (code == AVERROR_EOF) {
                is_at_end = true;
                check(avcodec_send_packet(codec.get(), nullptr));
                return;
            }
            check(code);
            const bool is_video = packet->stream_index == stream;
            const int sent = is_video ? avcodec_send_packet(codec.get(), packet.get()) : 0;
            av_packet_unref(packet.get());
            check(sent);
            if (is_video) {
                return;
            }
        }
    }

    // To RGB by the matrix and range the frame is tagged with; BT.709, limited, where it is not.
    void convert(Image& image) {
        scaler.reset(sws_getCachedContext(
            scaler.release(), frame->width, frame->height, static_cast<AVPixelFormat>(frame->format),
            frame->width, frame->height, AV_PIX_FMT_RGB24,
            SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT, nullptr, nullptr, nullptr));
        if (scaler == nullptr) {
            fail("its pixel format is not known");
        }
        const int space =
            frame->colorspace == AVCOL_SPC_UNSPECIFIED ? int{SWS_CS_ITU709} : int{frame->colorspace};
        const int* to_rgb = sws_getCoefficients(space);
        sws_setColorspaceDetails(scaler.get(), to_rgb, frame->color_range == AVCOL_RANGE_JPEG ? 1 : 0, to_rgb,
                                 1, 0, 1 << 16, 1 << 16);
        if (image.width != frame->width || image.height != frame->height) {
            image = Image(frame->width, frame->height);
        }
        std::uint8_t* rows[] = {image.rgb.data(), nullptr, nullptr, nullptr};
        const int strides[] = {image.width * 3, 0, 0, 0};
        check(sws_scale(scaler.get(), frame->data, frame->linesize, 0, frame->height, rows, strides));
    }
};

VideoReader::VideoReader(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(path)) {}
VideoReader::~VideoReader() = default;
VideoReader::VideoReader(VideoReader&&) noexcept = default;
VideoReader& VideoReader::operator=(VideoReader&&) noexcept = default;

bool VideoReader::read(Image& image) {
    if (!impl_->decode()) {
        return false;
    }
    impl_->convert(image);
    return true;
}

double VideoReader::fps() const {
    const AVRational rate = impl_->format->streams[impl_->stream]->avg_frame_rate;
    return rate.den > 0 ? static_cast<double>(rate.num) / rate.den : 0.0;
}

} // namespace render
