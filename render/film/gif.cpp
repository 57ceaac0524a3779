#include "render/film/gif.h"

#include "render/film/av_handles.h"
#include "sim/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace render {
namespace {

using sim::Error;
using sim::ExitCode;

/// Colours are told apart by so many bits a channel.
constexpr int bits = 6;
constexpr int levels = 1 << bits;
constexpr std::size_t bin_count = std::size_t{1} << (3 * bits);
constexpr std::size_t most_colors = 256;

using Bin = std::array<int, 3>;

Bin bin_at(std::size_t index) {
    const auto i = static_cast<int>(index);
    return {i >> (2 * bits), i >> bits & (levels - 1), i & (levels - 1)};
}

/// Of display values 0..255.
std::size_t bin_of(int r, int g, int b) {
    constexpr int shift = 8 - bits;
    return static_cast<std::size_t>(((r >> shift) << (2 * bits)) | ((g >> shift) << bits) | (b >> shift));
}

/// Bins that share a colour: bins[first] to bins[last - 1].
struct ColorBox {
    std::size_t first = 0;
    std::size_t last = 0;
    int axis = 0;       ///< along which they differ most
    double spread = 0.0; ///< along it, times the pixels
};

class Palette {
public:
    explicit Palette(const std::vector<std::uint32_t>& histogram) : histogram_(histogram) {
        for (std::size_t i = 0; i < bin_count; ++i) {
            if (histogram[i] > 0) {
                bins_.push_back(i);
            }
        }
        std::vector<ColorBox> boxes{measured(0, bins_.size())};
        while (boxes.size() < most_colors) {
            const auto widest = std::ranges::max_element(boxes, {}, &ColorBox::spread);
            if (widest->spread == 0.0) {
                break;
            }
            const ColorBox whole = *widest;
            const std::size_t middle = split(whole);
            *widest = measured(whole.first, middle);
            boxes.push_back(measured(middle, whole.last));
        }
        for (const ColorBox& box : boxes) {
            colors_.push_back(mean(box));
        }
        find_nearest();
    }

    std::uint8_t nearest(std::size_t bin) const { return nearest_[bin]; }
    const std::vector<Bin>& colors() const { return colors_; } ///< display values 0..255

private:
    ColorBox measured(std::size_t first, std::size_t last) const {
        Bin lower{levels, levels, levels}, upper{0, 0, 0};
        double pixels = 0.0;
        for (std::size_t i = first; i < last; ++i) {
            const Bin bin = bin_at(bins_[i]);
            pixels += histogram_[bins_[i]];
            for (std::size_t k = 0; k < 3; ++k) {
                lower[k] = std::min(lower[k], bin[k]);
                upper[k] = std::max(upper[k], bin[k]);
            }
        }
        ColorBox box{first, last, 0, 0.0};
        for (std::size_t k = 0; k < 3; ++k) {
            const double side = upper[k] - lower[k];
            if (side * std::sqrt(pixels) > box.spread) { // large areas count, but no colour is lost for them
                box.axis = static_cast<int>(k);
                box.spread = side * std::sqrt(pixels);
            }
        }
        return box;
    }

    /// Half the pixels on each side, at least a bin.
    std::size_t split(const ColorBox& box) {
        const auto begin = bins_.begin() + static_cast<std::ptrdiff_t>(box.first);
        const auto end = bins_.begin() + static_cast<std::ptrdiff_t>(box.last);
        const auto k = static_cast<std::size_t>(box.axis);
        std::sort(begin, end, [&](std::size_t a, std::size_t b) {
            return std::pair(bin_at(a)[k], a) < std::pair(bin_at(b)[k], b);
        });
        double pixels = 0.0;
        for (std::size_t i = box.first; i < box.last; ++i) {
            pixels += histogram_[bins_[i]];
        }
        std::size_t middle = box.first;
        for (double left = 0.0; middle + 1 < box.last && left < 0.5 * pixels; ++middle) {
            left += histogram_[bins_[middle]];
        }
        return std::max(middle, box.first + 1);
    }

    Bin mean(const ColorBox& box) const {
        std::array<double, 3> sum{};
        double pixels = 0.0;
        for (std::size_t i = box.first; i < box.last; ++i) {
            const Bin bin = bin_at(bins_[i]);
            const double weight = histogram_[bins_[i]];
            pixels += weight;
            for (std::size_t k = 0; k < 3; ++k) {
                sum[k] += weight * (bin[k] + 0.5) * (256.0 / levels);
            }
        }
        Bin color{};
        for (std::size_t k = 0; k < 3; ++k) {
            color[k] = std::clamp(static_cast<int>(sum[k] / std::max(pixels, 1.0)), 0, 255);
        }
        return color;
    }

    void find_nearest() {
        nearest_.resize(bin_count);
        constexpr int width = 256 / levels;
        for (std::size_t i = 0; i < bin_count; ++i) {
            const Bin bin = bin_at(i);
            int least = std::numeric_limits<int>::max();
            for (std::size_t c = 0; c < colors_.size(); ++c) {
                int distance = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const int d = bin[k] * width + width / 2 - colors_[c][k];
                    distance += d * d;
                }
                if (distance < least) {
                    least = distance;
                    nearest_[i] = static_cast<std::uint8_t>(c);
                }
            }
        }
    }

    const std::vector<std::uint32_t>& histogram_;
    std::vector<std::size_t> bins_; ///< that occur
    std::vector<Bin> colors_;
    std::vector<std::uint8_t> nearest_; ///< [bin_count]
};

/// Added to display values before they are rounded to a colour: a row of the pattern is 4 px.
int dither(int x, int y) {
    constexpr std::array<int, 16> pattern{0, 8, 2, 10, 12, 4, 14, 6, 3, 11, 1, 9, 15, 7, 13, 5};
    return pattern[static_cast<std::size_t>(4 * (y % 4) + x % 4)] - 8;
}

Palette palette_of(const AnimationPictures& pictures) {
    std::vector<std::uint32_t> histogram(bin_count);
    for (int i = 0; i < pictures.count; ++i) {
        const Image image = pictures.picture(i);
        for (std::size_t k = 0; k + 2 < image.rgb.size(); k += 3) {
            ++histogram[bin_of(image.rgb[k], image.rgb[k + 1], image.rgb[k + 2])];
        }
    }
    return Palette(histogram);
}

int checked(int code) {
    if (code < 0) {
        throw Error(ExitCode::io, "cannot encode the animation: " + av_text(code));
    }
    return code;
}

template <class Handle>
Handle owned(typename Handle::pointer raw) {
    if (raw == nullptr) {
        checked(AVERROR(ENOMEM));
    }
    return Handle(raw);
}

/// Encodes pictures of indices into a buffer.
class GifWriter {
public:
    GifWriter(int width, int height) {
        quiet_libav();
        AVFormatContext* raw = nullptr;
        checked(avformat_alloc_output_context2(&raw, nullptr, "gif", nullptr));
        format_.reset(raw);
        format_->flags |= AVFMT_FLAG_BITEXACT;
        checked(avio_open_dyn_buf(&format_->pb));
        const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_GIF);
        codec_ = owned<CodecContext>(codec != nullptr ? avcodec_alloc_context3(codec) : nullptr);
        codec_->width = width;
        codec_->height = height;
        codec_->pix_fmt = AV_PIX_FMT_PAL8;
        codec_->time_base = {1, 100};
        codec_->flags |= AV_CODEC_FLAG_BITEXACT;
        checked(avcodec_open2(codec_.get(), codec, nullptr));
        stream_ = avformat_new_stream(format_.get(), nullptr);
        checked(stream_ == nullptr ? AVERROR(ENOMEM) : 0);
        checked(avcodec_parameters_from_context(stream_->codecpar, codec_.get()));
        stream_->time_base = codec_->time_base;
        checked(avformat_write_header(format_.get(), nullptr));
        packet_ = owned<Packet>(av_packet_alloc());
    }
    ~GifWriter() { close(); }
    GifWriter(const GifWriter&) = delete;
    GifWriter& operator=(const GifWriter&) = delete;

    void add(const Image& image, const Palette& palette, std::int64_t start, std::int64_t duration) {
        const Frame frame = owned<Frame>(av_frame_alloc());
        frame->width = image.width;
        frame->height = image.height;
        frame->format = AV_PIX_FMT_PAL8;
        frame->pts = start;
        checked(av_frame_get_buffer(frame.get(), 0));
        auto* colors = reinterpret_cast<std::uint32_t*>(frame->data[1]);
        std::fill_n(colors, most_colors, 0xFF000000u);
        for (std::size_t i = 0; i < palette.colors().size(); ++i) {
            const auto [r, g, b] = palette.colors()[i];
            colors[i] = 0xFF000000u | static_cast<std::uint32_t>(r << 16 | g << 8 | b);
        }
        for (int y = 0; y < image.height; ++y) {
            const std::uint8_t* from = image.rgb.data() + static_cast<std::size_t>(3) * static_cast<std::size_t>(y * image.width);
            std::uint8_t* to = frame->data[0] + static_cast<std::ptrdiff_t>(y) * frame->linesize[0];
            for (int x = 0; x < image.width; ++x) {
                const auto value = [&](int k) { return std::clamp(from[3 * x + k] + dither(x, y), 0, 255); };
                to[x] = palette.nearest(bin_of(value(0), value(1), value(2)));
            }
        }
        duration_ = duration;
        encode(frame.get());
    }

    std::vector<std::uint8_t> finish() {
        encode(nullptr);
        checked(av_write_trailer(format_.get()));
        return close();
    }

private:
    void encode(const AVFrame* frame) {
        checked(avcodec_send_frame(codec_.get(), frame));
        for (;;) {
            const int code = avcodec_receive_packet(codec_.get(), packet_.get());
            if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) {
                return;
            }
            checked(code);
            packet_->stream_index = stream_->index;
            packet_->duration = duration_;
            checked(av_write_frame(format_.get(), packet_.get()));
            av_packet_unref(packet_.get());
        }
    }

    /// The buffer's bytes.
    std::vector<std::uint8_t> close() {
        std::vector<std::uint8_t> bytes;
        if (format_->pb != nullptr) {
            std::uint8_t* buffer = nullptr;
            const int size = avio_close_dyn_buf(std::exchange(format_->pb, nullptr), &buffer);
            bytes.assign(buffer, buffer + size);
            av_free(buffer);
        }
        return bytes;
    }

    OutputFormat format_;
    AVStream* stream_ = nullptr; ///< owned by format_
    CodecContext codec_;
    Packet packet_;
    std::int64_t duration_ = 0; ///< [1/100 s] of the last picture
};

} // namespace

std::vector<std::uint8_t> encode_gif(const AnimationPictures& pictures) {
    const Palette palette = palette_of(pictures);
    const auto hundredths = [&](int i) { return static_cast<std::int64_t>(std::llround(100.0 * pictures.start_time(i))); };
    const Image first = pictures.picture(0);
    GifWriter writer(first.width, first.height);
    for (int i = 0; i < pictures.count; ++i) {
        writer.add(i == 0 ? first : pictures.picture(i), palette, hundredths(i), hundredths(i + 1) - hundredths(i));
    }
    return writer.finish();
}

} // namespace render
