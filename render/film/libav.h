#pragma once
/// FFmpeg's functions under their own names, of libraries that are loaded when the first of them is called: with some
/// hundred that they need in turn they take longer to load than those that every command needs, and only films and GIFs
/// need them.
extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/dict.h>
#include <libavutil/frame.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

namespace render {

/// The address of a function of FFmpeg's. Throws Error (io): why the libraries cannot be loaded.
void* libav_function(const char* name);

// Within this namespace these are found before the functions themselves, to which nothing is linked.
#define TUMBLE_LIBAV(name)                                                                                             \
    inline constexpr auto name = [](auto... arguments) {                                                               \
        static const auto function = reinterpret_cast<decltype(&::name)>(libav_function(#name));                       \
        return function(arguments...);                                                                                 \
    };
TUMBLE_LIBAV(av_codec_is_encoder)
TUMBLE_LIBAV(av_codec_iterate)
TUMBLE_LIBAV(av_dict_free)
TUMBLE_LIBAV(av_dict_get)
TUMBLE_LIBAV(av_dict_set)
TUMBLE_LIBAV(av_find_best_stream)
TUMBLE_LIBAV(av_frame_alloc)
TUMBLE_LIBAV(av_frame_free)
TUMBLE_LIBAV(av_frame_get_buffer)
TUMBLE_LIBAV(av_frame_make_writable)
TUMBLE_LIBAV(av_free)
TUMBLE_LIBAV(av_freep)
TUMBLE_LIBAV(av_guess_format)
TUMBLE_LIBAV(av_interleaved_write_frame)
TUMBLE_LIBAV(av_log_set_level)
TUMBLE_LIBAV(av_opt_find)
TUMBLE_LIBAV(av_opt_set_int)
TUMBLE_LIBAV(av_packet_alloc)
TUMBLE_LIBAV(av_packet_free)
TUMBLE_LIBAV(av_packet_rescale_ts)
TUMBLE_LIBAV(av_packet_unref)
TUMBLE_LIBAV(av_read_frame)
TUMBLE_LIBAV(av_strdup)
TUMBLE_LIBAV(av_strerror)
TUMBLE_LIBAV(av_write_frame)
TUMBLE_LIBAV(av_write_trailer)
TUMBLE_LIBAV(avcodec_alloc_context3)
TUMBLE_LIBAV(avcodec_find_decoder)
TUMBLE_LIBAV(avcodec_find_encoder)
TUMBLE_LIBAV(avcodec_find_encoder_by_name)
TUMBLE_LIBAV(avcodec_free_context)
TUMBLE_LIBAV(avcodec_is_open)
TUMBLE_LIBAV(avcodec_open2)
TUMBLE_LIBAV(avcodec_parameters_from_context)
TUMBLE_LIBAV(avcodec_parameters_to_context)
TUMBLE_LIBAV(avcodec_receive_frame)
TUMBLE_LIBAV(avcodec_receive_packet)
TUMBLE_LIBAV(avcodec_send_frame)
TUMBLE_LIBAV(avcodec_send_packet)
TUMBLE_LIBAV(avformat_alloc_output_context2)
TUMBLE_LIBAV(avformat_close_input)
TUMBLE_LIBAV(avformat_find_stream_info)
TUMBLE_LIBAV(avformat_free_context)
TUMBLE_LIBAV(avformat_new_stream)
TUMBLE_LIBAV(avformat_open_input)
TUMBLE_LIBAV(avformat_write_header)
TUMBLE_LIBAV(avio_close)
TUMBLE_LIBAV(avio_close_dyn_buf)
TUMBLE_LIBAV(avio_flush)
TUMBLE_LIBAV(avio_open)
TUMBLE_LIBAV(avio_open_dyn_buf)
TUMBLE_LIBAV(sws_alloc_context)
TUMBLE_LIBAV(sws_freeContext)
TUMBLE_LIBAV(sws_getCachedContext)
TUMBLE_LIBAV(sws_getCoefficients)
TUMBLE_LIBAV(sws_init_context)
TUMBLE_LIBAV(sws_scale)
TUMBLE_LIBAV(sws_scale_frame)
TUMBLE_LIBAV(sws_setColorspaceDetails)
#undef TUMBLE_LIBAV

} // namespace render
