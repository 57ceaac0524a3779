#include "render/compare/scene_change.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <vector>

namespace diff {

namespace {

using Triple = std::array<double, 3>;

/// Less is not seen: a tenth of a pixel of a picture of 1000 that opens by 40 degrees.
constexpr double least_degrees = 0.004;
constexpr double degrees = 180.0 / 3.14159265358979323846;
/// Less of a light's brightness is not seen.
constexpr double least_percent = 0.05;

Triple between(const Triple& from, const Triple& to) {
    return {to[0] - from[0], to[1] - from[1], to[2] - from[2]};
}

double length_of(const Triple& v) {
    return std::hypot(v[0], v[1], v[2]);
}

/// Between two directions.
double angle_between(const Triple& a, const Triple& b) {
    const Triple across{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    return degrees * std::atan2(length_of(across), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]);
}

void add_view(const ShownView& a, const ShownView& b, std::vector<std::string>& parts) {
    std::vector<std::string> how;
    const Triple sight = between(a.eye, a.target);
    const double moved = length_of(between(a.eye, b.eye));
    if (degrees * moved > least_degrees * length_of(sight)) {
        how.push_back(fmt::format("moved by {:.3g} mm", 1e3 * moved));
    }
    if (const double turned = angle_between(sight, between(b.eye, b.target)); turned > least_degrees) {
        how.push_back(fmt::format("turned by {:.3g} degrees", turned));
    }
    if (std::abs(a.fov_degrees - b.fov_degrees) > least_degrees) {
        how.push_back(fmt::format("opens by {:.4g} degrees, not {:.4g}", b.fov_degrees, a.fov_degrees));
    }
    if (!how.empty()) {
        parts.push_back(fmt::format("the camera {}", fmt::join(how, ", ")));
    }
}

void add_brightness(const char* name, const std::vector<double>& a, const std::vector<double>& b,
                    std::vector<std::string>& parts) {
    double before = 0.0;
    double after = 0.0;
    double apart = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        before += a[i];
        after += b[i];
        apart += std::abs(a[i] - b[i]);
    }
    const double percent = before > 0.0 ? 100.0 * (after / before - 1.0) : 0.0;
    if (std::abs(percent) >= least_percent) {
        parts.push_back(fmt::format("the {} is {:.3g} % {}", name, std::abs(percent), percent < 0.0 ? "darker" : "brighter"));
    } else if (100.0 * apart > least_percent * before) {
        parts.push_back(fmt::format("the {} has another colour", name));
    }
}

void add_light(const ShownLight& a, const ShownLight& b, std::vector<std::string>& parts) {
    if (const double turned = angle_between(a.to_sun, b.to_sun); turned > least_degrees) {
        parts.push_back(fmt::format("the sun turned by {:.3g} degrees", turned));
    }
    const auto both = [](const Triple& zenith, const Triple& horizon) {
        std::vector<double> all(zenith.begin(), zenith.end());
        all.insert(all.end(), horizon.begin(), horizon.end());
        return all;
    };
    add_brightness("sun", {a.sun.begin(), a.sun.end()}, {b.sun.begin(), b.sun.end()}, parts);
    add_brightness("sky", both(a.zenith, a.horizon), both(b.zenith, b.horizon), parts);
}

} // namespace

void read_scene(const nlohmann::json& json, BodyImage& image) {
    if (json.contains("view")) {
        const nlohmann::json& view = json.at("view");
        image.view = ShownView{view.at("eye"), view.at("target"), view.at("fov_degrees")};
    }
    if (json.contains("light")) {
        const nlohmann::json& light = json.at("light");
        image.light = ShownLight{light.at("to_sun"), light.at("sun"), light.at("zenith"), light.at("horizon")};
    }
}

std::string scene_change(const BodyImage& reference, const BodyImage& candidate) {
    std::vector<std::string> parts;
    if (reference.view && candidate.view) {
        add_view(*reference.view, *candidate.view, parts);
    }
    if (reference.light && candidate.light) {
        add_light(*reference.light, *candidate.light, parts);
    }
    return fmt::format("{}", fmt::join(parts, "; "));
}

} // namespace diff
