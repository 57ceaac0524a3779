#pragma once
/// Decodes a film in the tests: what a player would show, by a conversion that does not use swscale.
#include "render/film/av_handles.h"
#include "render/picture/image.h"
#include "sim/base/rational.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace test {

/// One decoded picture: planes of 4:2:0, limited range.
struct Yuv {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> y;  ///< [height * width]
    std::vector<std::uint8_t> cb; ///< [height / 2 * width / 2]
    std::vector<std::uint8_t> cr; ///< [height / 2 * width / 2]
};

struct Film {
    int width = 0;
    int height = 0;
    sim::Rational fps;                ///< average rate as the file says
    std::vector<sim::Rational> times; ///< [s] of each frame, in the order shown
    std::vector<Yuv> frames;
    std::map<std::string, std::string> metadata;
    bool is_tagged_bt709 = false; ///< primaries, transfer, matrix and limited range
};

inline int check_av(int code, const char* what) {
    if (code < 0) {
        throw std::runtime_error(std::string(what) + " failed");
    }
    return code;
}

inline Yuv copy_planes(const AVFrame& frame) {
    Yuv yuv;
    yuv.width = frame.width;
    yuv.height = frame.height;
    const auto copy = [&frame](int plane, int width, int height) {
        std::vector<std::uint8_t> out;
        for (int row = 0; row < height; ++row) {
            const std::uint8_t* begin =
                frame.data[plane] + static_cast<std::ptrdiff_t>(frame.linesize[plane]) * row;
            out.insert(out.end(), begin, begin + width);
        }
        return out;
    };
    yuv.y = copy(0, frame.width, frame.height);
    yuv.cb = copy(1, frame.width / 2, frame.height / 2);
    yuv.cr = copy(2, frame.width / 2, frame.height / 2);
    return yuv;
}

inline Film read_film(const std::filesystem::path& path) {
    AVFormatContext* raw = nullptr;
    check_av(render::avformat_open_input(&raw, path.c_str(), nullptr, nullptr), "open");
    const render::InputFormat format(raw);
    check_av(render::avformat_find_stream_info(raw, nullptr), "stream info");
    const int index =
        check_av(render::av_find_best_stream(raw, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0), "best stream");
    const AVStream& stream = *raw->streams[index];
    const render::CodecContext codec(render::avcodec_alloc_context3(render::avcodec_find_decoder(stream.codecpar->codec_id)));
    check_av(render::avcodec_parameters_to_context(codec.get(), stream.codecpar), "parameters");
    check_av(render::avcodec_open2(codec.get(), nullptr, nullptr), "open decoder");

    Film film;
    film.width = stream.codecpar->width;
    film.height = stream.codecpar->height;
    film.fps = {stream.avg_frame_rate.num, stream.avg_frame_rate.den};
    film.is_tagged_bt709 = stream.codecpar->color_primaries == AVCOL_PRI_BT709 &&
                           stream.codecpar->color_trc == AVCOL_TRC_BT709 &&
                           stream.codecpar->color_space == AVCOL_SPC_BT709 &&
                           stream.codecpar->color_range == AVCOL_RANGE_MPEG;
    const AVDictionaryEntry* entry = nullptr;
    while ((entry = render::av_dict_get(raw->metadata, "", entry, AV_DICT_IGNORE_SUFFIX)) != nullptr) {
        film.metadata[entry->key] = entry->value;
    }
    const render::Packet packet(render::av_packet_alloc());
    const render::Frame frame(render::av_frame_alloc());
    const auto drain = [&] {
        while (render::avcodec_receive_frame(codec.get(), frame.get()) == 0) {
            film.frames.push_back(copy_planes(*frame));
            film.times.push_back(sim::make_rational(frame->pts * stream.time_base.num, stream.time_base.den));
        }
    };
    while (render::av_read_frame(raw, packet.get()) == 0) {
        if (packet->stream_index == index) {
            check_av(render::avcodec_send_packet(codec.get(), packet.get()), "decode");
            drain();
        }
        render::av_packet_unref(packet.get());
    }
    check_av(render::avcodec_send_packet(codec.get(), nullptr), "flush");
    drain();
    return film;
}

/// BT.709, limited range, full precision: what a pixel of this colour becomes.
struct YcbcrColor {
    double y = 0, cb = 0, cr = 0;
};
inline YcbcrColor to_bt709(double r, double g, double b) {
    const double luma = (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.0;
    return {16 + 219 * luma, 128 + 224 * (b / 255.0 - luma) / 1.8556,
            128 + 224 * (r / 255.0 - luma) / 1.5748};
}

/// The picture as RGB, chroma repeated over its 2 x 2 pixels.
inline render::Image to_rgb(const Yuv& yuv) {
    render::Image image(yuv.width, yuv.height);
    for (int row = 0; row < yuv.height; ++row) {
        for (int col = 0; col < yuv.width; ++col) {
            const std::size_t chroma = static_cast<std::size_t>(row / 2) * (yuv.width / 2) + col / 2;
            const std::size_t pixel = static_cast<std::size_t>(row) * yuv.width + col;
            const double luma = (yuv.y[pixel] - 16) / 219.0;
            const double pb = (yuv.cb[chroma] - 128) / 224.0;
            const double pr = (yuv.cr[chroma] - 128) / 224.0;
            const double r = luma + 1.5748 * pr;
            const double b = luma + 1.8556 * pb;
            const double g = (luma - 0.2126 * r - 0.0722 * b) / 0.7152;
            const double rgb[3] = {r, g, b};
            for (int c = 0; c < 3; ++c) {
                image.rgb[pixel * 3 + c] =
                    static_cast<std::uint8_t>(std::lround(std::clamp(rgb[c], 0.0, 1.0) * 255));
            }
        }
    }
    return image;
}

/// Peak signal-to-noise ratio [dB] over the upper left part that both have.
inline double psnr(const render::Image& a, const render::Image& b) {
    const int width = std::min(a.width, b.width);
    const int height = std::min(a.height, b.height);
    double sum = 0;
    for (int row = 0; row < height; ++row) {
        for (int i = 0; i < width * 3; ++i) {
            const double d = double(a.rgb[static_cast<std::size_t>(row) * a.width * 3 + i]) -
                             double(b.rgb[static_cast<std::size_t>(row) * b.width * 3 + i]);
            sum += d * d;
        }
    }
    const double mean = sum / (double(width) * height * 3);
    return mean == 0 ? 200.0 : 10 * std::log10(255.0 * 255.0 / mean);
}

} // namespace test
