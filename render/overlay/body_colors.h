#pragma once
/// Bodies coloured by material, by body or by a quantity, and what the legend says of it.
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <glm/glm.hpp>

#include <array>
#include <string>
#include <vector>

namespace render {

/// A colour and what it stands for.
struct LegendEntry {
    glm::vec3 color; ///< display values
    std::string text;
};

class BodyColors {
public:
    /// `scene` must outlive it.
    explicit BodyColors(const sim::SceneDef& scene);

    /// False: bodies look as the scene says.
    bool is_needed() const { return scene_.overlay.color_by != sim::ColorBy::look; }
    /// By a quantity, on a scale.
    bool is_scale() const { return scene_.overlay.color_by >= sim::ColorBy::speed; }

    /// Linear RGB [body_count]; bodies that cannot move keep their own.
    std::vector<sim::Vec3> of(const sim::Snapshot& snapshot) const;

    /// Of the scale.
    const std::array<double, 2>& range() const { return range_; }
    const std::string& title() const { return title_; }
    /// Of materials or bodies; empty if they are too many.
    const std::vector<LegendEntry>& entries() const { return entries_; }

private:
    void name_categories();
    std::array<double, 2> chosen_range() const;
    std::vector<double> quantities(const sim::Snapshot& snapshot) const;

    const sim::SceneDef& scene_;
    std::string title_;
    std::array<double, 2> range_{0.0, 1.0};
    std::vector<int> category_; ///< [body_count] of materials or bodies, -1: keeps its look
    std::vector<LegendEntry> entries_;
};

} // namespace render
