#pragma once
/// Pixels that are not compared: rectangles, the bright pixels of a picture.
#include "render/compare/picture.h"
#include "render/compare/result.h"

#include <string>
#include <vector>

namespace diff {

struct Mask {
    std::vector<Box> boxes;
    std::vector<Picture> pictures; ///< pixels that are not black are left out

    bool is_empty() const { return boxes.empty() && pictures.empty(); }
};

/// Adds "X,Y,WIDTH,HEIGHT" [px] or a picture's file. Throws Error: usage if it is neither, io if the file cannot
/// be read.
void add_to_mask(const std::string& text, const PictureLimits& accepted, Mask& mask);

/// Gives candidate's masked pixels the reference's colours, and marks the texts of both that are masked; both have the
/// same size. Throws Error (missing_or_size) if a mask's picture has another size.
void apply_mask(const Mask& mask, Picture& reference, Picture& candidate);

} // namespace diff
