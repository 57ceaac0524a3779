#pragma once
/// Which body each pixel shows, as `tumble run --body-ids` and baselines keep it beside a picture: a comparison can
/// name bodies and leave some out.
#include "render/compare/difference.h"
#include "render/compare/picture.h"
#include "render/compare/result.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace diff {

/// Where a picture was taken from.
struct ShownView {
    std::array<double, 3> eye{};    ///< [m]
    std::array<double, 3> target{}; ///< [m]
    double fov_degrees = 0.0;       ///< vertical
};

/// What a picture was lit by: linear RGB.
struct ShownLight {
    std::array<double, 3> to_sun{}; ///< unit
    std::array<double, 3> sun{};
    std::array<double, 3> zenith{};
    std::array<double, 3> horizon{};
};

struct BodyImage {
    int width = 0;                                ///< [px]
    int height = 0;                               ///< [px]
    std::vector<std::uint32_t> ids;               ///< [height * width] index into names plus 1; 0: none
    std::vector<std::string> names;               ///< [body_count]
    std::vector<std::array<double, 3>> positions; ///< [body_count] [m] centres of mass
    std::vector<std::array<double, 4>> orientations; ///< [body_count] unit quaternions w x y z; of older files empty
    std::optional<ShownView> view;   ///< of older files none, as
    std::optional<ShownLight> light; ///< this
};

/// The image beside PICTURE.png: PICTURE.bodies.png and PICTURE.bodies.json; none if there is none.
/// Throws Error (io) if one of the two is damaged.
std::optional<BodyImage> read_body_image(const std::filesystem::path& picture, const PictureLimits& accepted);

/// Makes white the pixels that show one of the bodies and their neighbours, which their edges reach.
void mask_bodies(const BodyImage& image, const std::vector<std::string>& names, Picture& pixels);

/// Names the bodies of clusters, and lists what happened to bodies; of those that stand still, what a moved camera or
/// another light does to them is said once. All are of one size; `map` is of the same two pictures.
void name_bodies(const BodyImage& reference, const BodyImage& candidate, const DifferenceMap& map, Frame& frame);

} // namespace diff
