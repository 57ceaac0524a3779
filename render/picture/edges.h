#pragma once
/// Smooth edges: how much of each pixel its bodies cover, counted only where bodies meet.
///
/// OpenGL draws one colour and one part number at the centre of each pixel. Wherever the part numbers of 3 x
/// 3 pixels differ, eight rays a pixel are followed to the parts that these numbers name: flat faces, floors,
/// spheres, bands of surfaces of revolution. The pixel's colour is the mean of what the rays meet, each part
/// with the colour it has on the nearest pixels. The mean is one of display values, as in OpenGL's own
/// multisampling. A face of a box that is so thin that it holds no pixel centre nearby has the colour of the face
/// beside it; other parts as thin are lost.
#include "render/picture/image.h"
#include "render/scene/draw_list.h"

#include <cstdint>
#include <vector>

namespace render {

/// What OpenGL leaves of a rectangle of the picture: colours and part numbers at pixel centres, lowest row first.
struct RawPicture {
    int x = 0;                      ///< [px] from the picture's left edge
    int y = 0;                      ///< [px] from its lower edge
    int width = 0;                  ///< [px]
    int height = 0;                 ///< [px]
    std::vector<std::uint8_t> rgba; ///< [height * width * 4]
    std::vector<std::uint32_t> ids; ///< [height * width] as in DrawList; 0: sky
    std::vector<std::uint16_t> deep; ///< as rgba, 16 bits; empty unless RenderSettings asks for them
};

/// The rectangle as it is, top row first.
Image flipped(const RawPicture& raw);
std::vector<std::uint16_t> flipped_deep(const RawPicture& raw);

/// The rectangle with smooth edges, top row first. Its outermost pixels are right only at the picture's own border.
/// geometry, list: what it was drawn from.
Image smooth_edges(const RawPicture& raw, const SceneGeometry& geometry, const DrawList& list,
                   const Viewport& viewport);
std::vector<std::uint16_t> smooth_edges_deep(const RawPicture& raw, const SceneGeometry& geometry, const DrawList& list,
                                             const Viewport& viewport);

} // namespace render
