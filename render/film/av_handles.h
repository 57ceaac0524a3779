#pragma once
/// Owners of libav's objects: one unique_ptr alias a type. Only this file calls a function that frees one.
#include "render/film/libav.h"

#include <array>
#include <memory>
#include <mutex>
#include <string>

namespace render {

/// What an error code of libav means.
inline std::string av_text(int code) {
    std::array<char, AV_ERROR_MAX_STRING_SIZE> text{};
    av_strerror(code, text.data(), text.size());
    return text.data();
}

struct AvDeleter {
    void operator()(AVCodecContext* p) const noexcept;
    void operator()(AVFrame* p) const noexcept { av_frame_free(&p); }
    void operator()(AVPacket* p) const noexcept { av_packet_free(&p); }
    void operator()(SwsContext* p) const noexcept { sws_freeContext(p); }
    void operator()(AVIOContext* p) const noexcept { avio_close(p); }
};

/// SVT-AV1 1.4 waits for ever where it is closed before a picture and the end.
inline void AvDeleter::operator()(AVCodecContext* p) const noexcept {
    if (avcodec_is_open(p) != 0 && p->codec_id == AV_CODEC_ID_AV1 && av_codec_is_encoder(p->codec) != 0) {
        const std::unique_ptr<AVFrame, AvDeleter> frame(av_frame_alloc());
        const std::unique_ptr<AVPacket, AvDeleter> packet(av_packet_alloc());
        if (frame != nullptr && packet != nullptr) {
            frame->format = p->pix_fmt;
            frame->width = p->width;
            frame->height = p->height;
            if (av_frame_get_buffer(frame.get(), 0) == 0) {
                avcodec_send_frame(p, frame.get());
            }
            avcodec_send_frame(p, nullptr);
            while (avcodec_receive_packet(p, packet.get()) == 0) {
            }
        }
    }
    avcodec_free_context(&p);
}

using CodecContext = std::unique_ptr<AVCodecContext, AvDeleter>;
using Frame = std::unique_ptr<AVFrame, AvDeleter>;
using Packet = std::unique_ptr<AVPacket, AvDeleter>;
using Scaler = std::unique_ptr<SwsContext, AvDeleter>;
using IoContext = std::unique_ptr<AVIOContext, AvDeleter>;

struct OutputFormatDeleter {
    void operator()(AVFormatContext* p) const noexcept { avformat_free_context(p); }
};
struct InputFormatDeleter {
    void operator()(AVFormatContext* p) const noexcept { avformat_close_input(&p); }
};
using OutputFormat = std::unique_ptr<AVFormatContext, OutputFormatDeleter>;
using InputFormat = std::unique_ptr<AVFormatContext, InputFormatDeleter>;

/// Options handed to libav; what it does not know stays behind.
class Dictionary {
public:
    Dictionary() = default;
    Dictionary(const Dictionary&) = delete;
    Dictionary& operator=(const Dictionary&) = delete;
    ~Dictionary() { av_dict_free(&options_); }

    /// Negative on failure.
    int set(const char* key, const char* value) noexcept { return av_dict_set(&options_, key, value, 0); }
    AVDictionary** get() noexcept { return &options_; }
    /// The first option that nobody took, or null.
    const char* first_key() const noexcept {
        const AVDictionaryEntry* entry = av_dict_get(options_, "", nullptr, AV_DICT_IGNORE_SUFFIX);
        return entry != nullptr ? entry->key : nullptr;
    }

private:
    AVDictionary* options_ = nullptr;
};

/// libav writes to stderr by itself; what matters arrives as a return value.
inline void quiet_libav() {
    static std::once_flag quiet;
    std::call_once(quiet, [] { av_log_set_level(AV_LOG_QUIET); });
}

} // namespace render
