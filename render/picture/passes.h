#pragma once
/// Passes: what is seen at each pixel, as numbers. What they mean: render/film/README.md.
#include "render/picture/depth_picture.h"
#include "render/picture/plan.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <cstdint>
#include <string>
#include <vector>

namespace render {

/// One number a pixel, the top row first; one of the two lists is filled.
struct Channel {
    std::string name; ///< "depth.Z"
    std::vector<float> values{};
    std::vector<std::uint32_t> counts{};
};

/// A picture and what it was drawn of.
struct PassSource {
    const PicturePlan& plan;
    const RawPicture& raw; ///< whole, with ids
    const DrawList& list;
    const DepthPicture& depth;
    const sim::Snapshot& snapshot;
    double frame_time; ///< [s] simulated, to the next frame
};

/// Samples of PNG files, the top row first: bodies before nothing, RGBA; and the depth in millimetres, 16 bits, the high byte
/// first, 65535 from there on.
std::vector<std::uint8_t> rgba_samples(const PassSource& source);
std::vector<std::uint8_t> depth16_samples(const PassSource& source);
/// The picture, RGB of 16 bits, the high byte first.
std::vector<std::uint8_t> rgb16_samples(const PassSource& source);

/// Channels of those passes of OpenEXR files that the scene's output asks for.
std::vector<Channel> make_passes(const PassSource& source, const sim::OutputDef& output);

/// The bytes of an OpenEXR file of channels of width x height pixels. Throws Error (io).
std::vector<std::uint8_t> encode_exr(const std::vector<Channel>& channels, int width, int height);

} // namespace render
