#pragma once
/// Pictures for the tests of comparing: shapes over a floor, drawn with a chosen pattern of samples a pixel. Shares
/// no code with render/ outside compare/.
#include "render/compare/picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace test {

struct Shape {
    enum class Kind { disc, box, wire } kind = Kind::disc;
    double x = 0, y = 0;   ///< centre [px]
    double size = 10;      ///< radius or half side; of a wire half its length [px]
    double angle = 0;      ///< [rad]
    std::array<double, 3> color{};
    double thickness = 0.9; ///< of a wire, half of it [px]
};

struct Scene {
    int width = 320;
    int height = 180;
    double contrast = 1.0;
    double shade = 0.15; ///< share by which boxes darken across
    std::array<double, 3> floor{150, 148, 140};
    std::array<double, 3> sky{190, 205, 230};
    std::vector<Shape> shapes;
};

/// Fractions 0..1, the same on every machine.
class Random {
public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}
    double operator()() { return engine_() / 4294967296.0; }
    double normal() {
        double sum = -6.0;
        for (int i = 0; i < 12; ++i) {
            sum += (*this)();
        }
        return sum;
    }

private:
    std::mt19937 engine_;
};

/// Shapes of all sizes, sorted back to front: `count` from 4 to 30 px and some wires.
inline Scene make_scene(std::uint32_t seed, int count, int wires) {
    Random random(seed);
    Scene scene;
    for (int i = 0; i < count; ++i) {
        Shape s;
        s.kind = random() < 0.5 ? Shape::Kind::disc : Shape::Kind::box;
        s.size = 3 + 15 * random() * random();
        s.x = scene.width * random();
        s.y = 60 + (scene.height - 60) * random();
        s.angle = 3 * random();
        s.color = {255 * random(), 255 * random(), 255 * random()};
        scene.shapes.push_back(s);
    }
    for (int i = 0; i < wires; ++i) {
        scene.shapes.push_back({Shape::Kind::wire, scene.width * random(), scene.height * random(), 60, 3 * random(),
                                {40, 40, 60}});
    }
    return scene;
}

inline std::array<double, 3> color_at(const Scene& scene, double x, double y) {
    for (std::size_t i = scene.shapes.size(); i-- > 0;) {
        const Shape& s = scene.shapes[i];
        if (std::abs(x - s.x) > 1.5 * s.size || std::abs(y - s.y) > 1.5 * s.size) {
            continue;
        }
        const double u = std::cos(s.angle) * (x - s.x) + std::sin(s.angle) * (y - s.y);
        const double v = std::cos(s.angle) * (y - s.y) - std::sin(s.angle) * (x - s.x);
        double shade = 0;
        switch (s.kind) {
        case Shape::Kind::disc:
            if (u * u + v * v > s.size * s.size) {
                continue;
            }
            shade = scene.shade * (u * u + v * v) / (s.size * s.size);
            break;
        case Shape::Kind::box:
            if (std::abs(u) > s.size || std::abs(v) > s.size) {
                continue;
            }
            shade = scene.shade * u / s.size;
            break;
        case Shape::Kind::wire:
            if (std::abs(u) > s.size || std::abs(v) > s.thickness) {
                continue;
            }
            break;
        }
        return {s.color[0] * (1 - shade), s.color[1] * (1 - shade), s.color[2] * (1 - shade)};
    }
    if (y < 50) {
        return scene.sky;
    }
    // A chequered floor in perspective.
    const double depth = 4000 / (y - 40);
    const bool is_dark = (static_cast<int>(std::floor((x - 160) * depth / 900)) + static_cast<int>(std::floor(depth / 9))) & 1;
    const double f = is_dark && depth < 150 ? 0.8 : 1.0;
    return {scene.floor[0] * f, scene.floor[1] * f, scene.floor[2] * f};
}

/// Where a pixel's samples lie [px], -0.5..0.5.
using Pattern = std::vector<std::array<double, 2>>;
inline Pattern grid_pattern(int n) {
    Pattern pattern;
    for (int i = 0; i < n * n; ++i) {
        pattern.push_back({(i % n + 0.5) / n - 0.5, (i / n + 0.5) / n - 0.5});
    }
    return pattern;
}
inline const Pattern rotated_pattern{{-0.125, -0.375}, {0.375, -0.125}, {-0.375, 0.125}, {0.125, 0.375}};

/// dx, dy: shift of the view [px].
inline diff::Picture paint(const Scene& scene, const Pattern& pattern, double dx = 0, double dy = 0) {
    diff::Picture picture;
    picture.width = scene.width;
    picture.height = scene.height;
    for (int y = 0; y < scene.height; ++y) {
        for (int x = 0; x < scene.width; ++x) {
            std::array<double, 3> sum{};
            for (const auto& [sx, sy] : pattern) {
                const auto color = color_at(scene, x + 0.5 + sx - dx, y + 0.5 + sy - dy);
                for (std::size_t c = 0; c < 3; ++c) {
                    sum[c] += color[c];
                }
            }
            for (const double s : sum) {
                picture.rgb.push_back(
                    static_cast<std::uint8_t>(std::clamp(s / static_cast<double>(pattern.size()) + 0.5, 0.0, 255.0)));
            }
        }
    }
    return picture;
}

/// Each channel changed by `change`, rounded.
template <typename Change>
diff::Picture each_channel(diff::Picture picture, Change change) {
    for (std::uint8_t& v : picture.rgb) {
        v = static_cast<std::uint8_t>(std::clamp(std::floor(change(double(v)) + 0.5), 0.0, 255.0));
    }
    return picture;
}

} // namespace test
