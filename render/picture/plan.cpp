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

Image PicturePlan::picture(const RawPicture& raw, const DrawList& list) const {
    return settings_.smooth_edges ? smooth_edges(raw, geometry_, list) : flipped(raw);
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

void PictureMean::add(const Image& image) {
    sum_.resize(image.rgb.size());
    // Squares stand for light: close to the display's gamma of 2.2.
    for (std::size_t k = 0; k < sum_.size(); ++k) {
        sum_[k] += static_cast<std::uint32_t>(image.rgb[k]) * image.rgb[k];
    }
    width_ = image.width;
    height_ = image.height;
    ++count_;
}

Image PictureMean::take() {
    CHECK(count_ > 0);
    Image image(width_, height_);
    const float share = 1.0f / static_cast<float>(count_);
    for (std::size_t k = 0; k < sum_.size(); ++k) {
        image.rgb[k] = static_cast<std::uint8_t>(std::sqrt(static_cast<float>(sum_[k]) * share) + 0.5f);
        sum_[k] = 0;
    }
    count_ = 0;
    return image;
}

} // namespace render
