#pragma once
/// What lies in the world over a picture: contacts, impulses as arrows, impacts, trails and contact paths.
#include "render/overlay/body_colors.h"
#include "render/overlay/canvas.h"
#include "render/overlay/notes.h"
#include "render/picture/depth_picture.h"

#include <vector>

namespace render {

/// A body's own colour as seen on the screen, made light enough for a dark panel.
glm::vec3 panel_color(const sim::BodyDef& body);

class WorldLayer {
public:
    /// `scene` must outlive it.
    explicit WorldLayer(const sim::SceneDef& scene);

    bool is_needed() const { return has_contacts_ || has_paths_; }
    /// Kinds of contacts and their colours; empty if none has one.
    std::vector<LegendEntry> legend() const;

    /// scale [px]: 1/720 of the picture's height. depth: of this picture.
    void draw(Canvas& canvas, const sim::Snapshot& snapshot, const Notes& notes, const DepthPicture& depth,
              float scale) const;

private:
    class Projection;
    struct Arrow;

    void draw_paths(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot,
                    const Notes& notes) const;
    void draw_contacts(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot) const;
    void draw_impacts(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot) const;
    void draw_arrow(Canvas& canvas, const Projection& projection, const Arrow& arrow) const;
    float side_of(const sim::ContactSnapshot& contact) const;

    const sim::SceneDef& scene_;
    bool has_contacts_;
    bool has_paths_;
    double view_;         ///< [m] length scale of the view
    double arrow_scale_;  ///< [m/(N s)] of contacts, over one step
    double impact_scale_; ///< [m/(N s)] of impacts
};

} // namespace render
