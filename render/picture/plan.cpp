#include "render/picture/plan.h"

#include "render/scene/camera.h"
#include "sim/base/error.h"

#include <cmath>
#include <utility>

namespace render {

RenderSettings render_settings(const sim::OutputDef& output) {
    RenderSettings settings;
    settings.camera = output.camera;
    settings.gl = output.gl;
    settings.shadow_size = output.shadow_size;
    settings.soft_shadows = output.soft_shadows;
    settings.smooth_edges = output.smooth_edges;
    return settings;
}

PicturePlan::PicturePlan(const sim::SceneDef& scene, int width, int height, const RenderSettings& settings)
    : scene_(scene),
      camera_(find_camera(scene, settings.camera.empty() ? scene.output.camera : settings.camera)),
      viewport_{width, height, settings.shadow_size}, geometry_(make_scene_geometry(scene, camera_)),
      settings_(settings) {
    CHECK(width > 0 && height > 0 && settings.shadow_size > 8);
    CHECK(settings.reads_ids || !settings.smooth_edges);
}

DrawList PicturePlan::list(const sim::SceneDef& colored, const sim::Snapshot& snapshot) const {
    return make_draw_list(colored, geometry_, camera_, snapshot, viewport_);
}

std::vector<DrawList> PicturePlan::lists(const sim::SceneDef& colored, std::span<const sim::Snapshot> states) const {
    return make_draw_lists(colored, geometry_, camera_, states, viewport_);
}

glm::dmat4 PicturePlan::clip_from_world(const sim::Snapshot& snapshot) const {
    const double aspect = static_cast<double>(viewport_.width) / viewport_.height;
    return glm::dmat4(make_camera(view_point(camera_view(camera_, snapshot, aspect), aspect), {1.0, 2.0}).clip_from_world);
}

Image PicturePlan::picture(const RawPicture& raw, const DrawList& list) const {
    return settings_.smooth_edges ? smooth_edges(raw, geometry_, list, viewport_) : flipped(raw);
}

std::vector<std::uint16_t> PicturePlan::deep_picture(const RawPicture& raw, const DrawList& list) const {
    CHECK(settings_.is_deep);
    return settings_.smooth_edges ? smooth_edges_deep(raw, geometry_, list, viewport_) : flipped_deep(raw);
}

std::vector<std::uint32_t> body_ids(const RawPicture& raw, const DrawList& list) {
    std::vector<std::uint32_t> bodies;
    bodies.reserve(raw.ids.size());
    const auto width = static_cast<std::size_t>(raw.width);
    for (std::size_t y = static_cast<std::size_t>(raw.height); y-- > 0;) {
        for (std::size_t x = 0; x < width; ++x) {
            bodies.push_back(list.body_of_id.at(raw.ids[y * width + x]));
        }
    }
    return bodies;
}

std::vector<sim::Snapshot> states_in_shutter(const sim::Snapshot& snapshot, double shutter, int count) {
    CHECK(count >= 1);
    std::vector<sim::Snapshot> states;
    for (int i = 0; i < count; ++i) {
        states.push_back(moved(snapshot, shutter * ((i + 0.5) / count - 0.5)));
    }
    return states;
}

void PictureMean::add(Image image, const PixelRect& rect) {
    if (count_++ == 0) {
        mean_ = std::move(image);
        return;
    }
    // Without the outermost pixels, unless they are the picture's border.
    const int left = rect.x == 0 ? 0 : 1;
    const int bottom = rect.y == 0 ? 0 : 1;
    const int top = rect.y + rect.height == mean_.height ? 0 : 1;
    const int right = rect.x + rect.width == mean_.width ? 0 : 1;
    const PixelRect kept{rect.x + left, rect.y + bottom, rect.width - left - right, rect.height - bottom - top};
    CHECK(count_ == 2 || kept == rect_);
    rect_ = kept;
    if (count_ == 2) {
        sum_.assign(3 * static_cast<std::size_t>(kept.width) * static_cast<std::size_t>(kept.height), 0);
        for (int row = 0; row < kept.height; ++row) {
            add_squares(mean_row(row), row);
        }
    }
    const std::size_t stride = 3 * static_cast<std::size_t>(image.width);
    const std::uint8_t* first =
        image.rgb.data() + static_cast<std::size_t>(top) * stride + 3 * static_cast<std::size_t>(left);
    for (int row = 0; row < kept.height; ++row) {
        add_squares(first + static_cast<std::size_t>(row) * stride, row);
    }
}

/// To a row of the sum. Squares stand for light: close to the display's gamma of 2.2.
void PictureMean::add_squares(const std::uint8_t* values, int row) {
    const std::size_t count = 3 * static_cast<std::size_t>(rect_.width);
    std::uint32_t* sum = sum_.data() + static_cast<std::size_t>(row) * count;
    for (std::size_t k = 0; k < count; ++k) {
        sum[k] += static_cast<std::uint32_t>(values[k]) * values[k];
    }
}

/// A row of the rectangle in the mean.
std::uint8_t* PictureMean::mean_row(int row) {
    const auto y = static_cast<std::size_t>(mean_.height - rect_.y - rect_.height + row);
    return mean_.rgb.data() + 3 * (y * static_cast<std::size_t>(mean_.width) + static_cast<std::size_t>(rect_.x));
}

Image PictureMean::take() {
    CHECK(count_ > 0);
    const float share = 1.0f / static_cast<float>(count_);
    const std::size_t values = 3 * static_cast<std::size_t>(rect_.width);
    for (int row = 0; count_ > 1 && row < rect_.height; ++row) {
        const std::uint32_t* sum = sum_.data() + static_cast<std::size_t>(row) * values;
        std::uint8_t* to = mean_row(row);
        for (std::size_t k = 0; k < values; ++k) {
            to[k] = static_cast<std::uint8_t>(std::sqrt(static_cast<float>(sum[k]) * share) + 0.5f);
        }
    }
    count_ = 0;
    return std::move(mean_);
}

} // namespace render
