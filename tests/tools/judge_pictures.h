#pragma once
/// What is done to pictures, for judge_corpus: other samples, levels, focus and sizes.
#include "render/picture/image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>

namespace judge {

using render::Image;

inline std::uint8_t byte_of(double value) {
    return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

/// Of a picture `factor` times as large: the mean of the samples of each pixel that `takes` says.
inline Image sampled(const Image& large, int factor, const std::function<bool(int x, int y)>& takes) {
    Image image(large.width / factor, large.height / factor);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                int sum = 0;
                int count = 0;
                for (int k = 0; k < factor * factor; ++k) {
                    if (takes(k % factor, k / factor)) {
                        const int row = std::clamp(y * factor + k / factor, 0, large.height - 1);
                        sum += large.rgb[static_cast<std::size_t>((row * large.width + x * factor + k % factor) * 3 + c)];
                        ++count;
                    }
                }
                image.rgb[static_cast<std::size_t>((y * image.width + x) * 3 + c)] =
                    static_cast<std::uint8_t>((sum + count / 2) / count);
            }
        }
    }
    return image;
}

inline Image each_channel(Image image, const std::function<double(double)>& change) {
    for (std::uint8_t& v : image.rgb) {
        v = byte_of(change(v));
    }
    return image;
}

/// Weights of 3 x 3 neighbours: the middle, those beside it, those at the corners.
inline Image filtered(const Image& from, double middle, double beside, double corner) {
    Image image = from;
    for (int y = 1; y + 1 < from.height; ++y) {
        for (int x = 1; x + 1 < from.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                double sum = 0;
                for (int k = 0; k < 9; ++k) {
                    const double weight = k == 4 ? middle : k % 2 == 1 ? beside : corner;
                    sum += weight * from.rgb[static_cast<std::size_t>(((y + k / 3 - 1) * from.width + x + k % 3 - 1) * 3 + c)];
                }
                image.rgb[static_cast<std::size_t>((y * from.width + x) * 3 + c)] = byte_of(sum);
            }
        }
    }
    return image;
}

/// Drawn at half the size and enlarged.
inline Image half_resolution(const Image& from) {
    const Image small = sampled(from, 2, [](int, int) { return true; });
    Image image = from;
    for (int y = 0; y < from.height; ++y) {
        for (int x = 0; x < from.width; ++x) {
            for (int c = 0; c < 3; ++c) {
                const double sx = std::clamp((x - 0.5) / 2, 0.0, small.width - 1.001);
                const double sy = std::clamp((y - 0.5) / 2, 0.0, small.height - 1.001);
                const int i = static_cast<int>(sx);
                const int j = static_cast<int>(sy);
                const auto at = [&](int px, int py) {
                    return static_cast<double>(small.rgb[static_cast<std::size_t>((py * small.width + px) * 3 + c)]);
                };
                const double fx = sx - i;
                const double fy = sy - j;
                image.rgb[static_cast<std::size_t>((y * from.width + x) * 3 + c)] =
                    byte_of((1 - fy) * ((1 - fx) * at(i, j) + fx * at(i + 1, j)) +
                            fy * ((1 - fx) * at(i, j + 1) + fx * at(i + 1, j + 1)));
            }
        }
    }
    return image;
}

} // namespace judge
