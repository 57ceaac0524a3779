#include "render/overlay/body_colors.h"

#include "render/overlay/palette.h"
#include "render/overlay/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace render {

namespace {

/// Categories that a legend can hold.
constexpr std::size_t most_entries = 10;
/// Ends of the scales where the scene sets none: contacts of one body, and a load in weights of a mean body.
constexpr double usual_contacts = 16.0;
constexpr double usual_load = 5.0;

std::string material_text(const sim::MaterialDef& material) {
    std::string text;
    if (material.restitution) {
        text += fmt::format("e {:.3g}", *material.restitution);
    }
    if (material.mu_d) {
        text += fmt::format("{}\u03bc {:.3g}", text.empty() ? "" : "  ", *material.mu_d);
    }
    return text.empty() ? "no material of its own" : text;
}

} // namespace

BodyColors::BodyColors(const sim::SceneDef& scene) : scene_(scene) {
    switch (scene.overlay.color_by) {
    case sim::ColorBy::look:
        return;
    case sim::ColorBy::material:
    case sim::ColorBy::body:
        name_categories();
        return;
    case sim::ColorBy::speed:
        title_ = "speed [m/s]";
        break;
    case sim::ColorBy::contacts:
        title_ = "contacts of a body";
        break;
    case sim::ColorBy::impulse:
        title_ = "normal impulses in a step [N s]";
        break;
    }
    range_ = scene.overlay.color_range.value_or(chosen_range());
}

void BodyColors::name_categories() {
    const bool by_material = scene_.overlay.color_by == sim::ColorBy::material;
    title_ = by_material ? "material" : "body";
    std::vector<std::string> names;
    for (const sim::BodyDef& body : scene_.bodies) {
        if (body.is_static()) {
            category_.push_back(-1);
            continue;
        }
        const std::string name = by_material ? material_text(body.material) : body.name;
        const auto known = std::ranges::find(names, name);
        category_.push_back(static_cast<int>(known - names.begin()));
        if (known == names.end()) {
            names.push_back(name);
        }
    }
    for (std::size_t i = 0; i < names.size() && names.size() <= most_entries; ++i) {
        entries_.push_back({category_color(static_cast<int>(i)), names[i]});
    }
}

/// What most bodies can be expected to stay in: the speed of a fall from a quarter of the highest body's
/// height, so many contacts, or the load of so many bodies.
std::array<double, 2> BodyColors::chosen_range() const {
    double height = 0.0;
    double mass = 0.0;
    double count = 0.0;
    for (const sim::BodyDef& body : scene_.bodies) {
        if (!body.is_static()) {
            height = std::max(height, body.pose.position.z());
            mass += body.mass.mass;
            count += 1.0;
        }
    }
    const double g = scene_.step.gravity.norm();
    const double upper = scene_.overlay.color_by == sim::ColorBy::speed ? std::sqrt(0.5 * g * height)
                         : scene_.overlay.color_by == sim::ColorBy::contacts
                             ? usual_contacts
                             : usual_load * mass / std::max(count, 1.0) * g * scene_.step.time_step.value();
    return nice_range(0.0, upper > 0.0 ? upper : 1.0);
}

std::vector<double> BodyColors::quantities(const sim::Snapshot& snapshot) const {
    std::vector<double> result(scene_.bodies.size(), 0.0);
    if (scene_.overlay.color_by == sim::ColorBy::speed) {
        for (std::size_t i = 0; i < result.size(); ++i) {
            result[i] = snapshot.bodies[i].velocity.norm();
        }
        return result;
    }
    const bool counts = scene_.overlay.color_by == sim::ColorBy::contacts;
    for (const sim::ContactSnapshot& contact : snapshot.contacts) {
        const double p_n = std::abs(static_cast<double>(contact.impulse.dot(contact.normal)));
        for (const std::int32_t body : contact.bodies) {
            result[static_cast<std::size_t>(body)] += counts ? 1.0 : p_n;
        }
    }
    return result;
}

std::vector<sim::Vec3> BodyColors::of(const sim::Snapshot& snapshot) const {
    const auto linear = [](const glm::vec3& color) {
        const glm::vec3 light = linear_from_display(color);
        return sim::Vec3(light.x, light.y, light.z);
    };
    const std::vector<double> values = is_scale() ? quantities(snapshot) : std::vector<double>();
    std::vector<sim::Vec3> colors;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
        const sim::BodyDef& body = scene_.bodies[i];
        if (is_scale() ? body.is_static() : category_[i] < 0) {
            colors.push_back(body.look.color);
        } else if (is_scale()) {
            const double share = (values[i] - range_[0]) / (range_[1] - range_[0]);
            colors.push_back(linear(scale_color(static_cast<float>(share))));
        } else {
            colors.push_back(linear(category_color(category_[i])));
        }
    }
    return colors;
}

} // namespace render
