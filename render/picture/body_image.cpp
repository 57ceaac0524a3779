#include "render/picture/body_image.h"

#include "render/picture/image.h"
#include "render/scene/camera.h"
#include "sim/base/error.h"
#include "sim/base/file_io.h"

#include <nlohmann/json.hpp>

namespace render {

std::vector<NamedBytes> encode_body_image(const std::string& frame, const sim::SceneDef& scene,
                                          const sim::Snapshot& snapshot, const std::vector<std::uint32_t>& ids) {
    Image image(scene.output.width, scene.output.height);
    CHECK(ids.size() * 3 == image.rgb.size());
    for (std::size_t i = 0; i < ids.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            image.rgb[3 * i + c] = static_cast<std::uint8_t>(ids[i] >> (8 * c));
        }
    }
    nlohmann::ordered_json names = nlohmann::ordered_json::array();
    nlohmann::ordered_json positions = nlohmann::ordered_json::array();
    nlohmann::ordered_json orientations = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const sim::Vec3& x = snapshot.bodies[i].position;
        names.push_back(scene.bodies[i].name);
        positions.push_back({x.x(), x.y(), x.z()});
        const sim::Quat& q = snapshot.bodies[i].orientation;
        orientations.push_back({q.w(), q.x(), q.y(), q.z()});
    }
    const double aspect = static_cast<double>(scene.output.width) / scene.output.height;
    const View view = camera_view(find_camera(scene, scene.output.camera), snapshot, aspect);
    const sim::LightDef& light = scene.light;
    const auto array_of = [](const sim::Vec3& v) { return nlohmann::ordered_json{v.x(), v.y(), v.z()}; };
    const nlohmann::ordered_json json = {
        {"names", names},
        {"positions", positions},
        {"orientations", orientations},
        {"view", {{"eye", array_of(view.eye)}, {"target", array_of(view.target)}, {"fov_degrees", view.fov_degrees}}},
        {"light",
         {{"to_sun", array_of(light.to_sun)},
          {"sun", array_of(light.sun_intensity * light.sun_color)},
          {"zenith", array_of(light.sky_intensity * light.sky_zenith)},
          {"horizon", array_of(light.sky_intensity * light.sky_horizon)}}}};
    const std::string stem = std::filesystem::path(frame).replace_extension().string() + ".bodies";
    const std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
    return {{stem + ".png", encode_png(image)}, {stem + ".json", {text.begin(), text.end()}}};
}

std::vector<std::string> write_body_image(const std::filesystem::path& folder, const std::string& frame,
                                          const sim::SceneDef& scene, const sim::Snapshot& snapshot,
                                          const std::vector<std::uint32_t>& ids) {
    std::vector<std::string> names;
    for (const auto& [name, bytes] : encode_body_image(frame, scene, snapshot, ids)) {
        sim::write_file(folder / name, bytes);
        names.push_back(name);
    }
    return names;
}

} // namespace render
