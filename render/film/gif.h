#pragma once
/// An animated GIF of pictures, by libavcodec: 256 colours for all of them, chosen by median cut (Heckbert 1982), and ordered
/// dithering (Bayer 1973), which does not crawl from picture to picture.
#include "render/picture/image.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace render {

struct AnimationPictures {
    int count = 0;                         ///< at least one
    std::function<Image(int)> picture;     ///< all of one size; each is asked for twice
    std::function<double(int)> start_time; ///< [s] of 0..count, where count is the end; GIF knows hundredths
};

/// Played for ever. Same pictures, same bytes. Throws Error (io).
std::vector<std::uint8_t> encode_gif(const AnimationPictures& pictures);

} // namespace render
