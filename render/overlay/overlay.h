#pragma once
/// Text, plots and legends over a picture, and what lies in the world, as sim::OverlayDef asks for them.
#include "render/overlay/body_colors.h"
#include "render/overlay/canvas.h"
#include "render/overlay/text.h"
#include "render/overlay/world_layer.h"

namespace render {

class Overlay {
public:
    /// `scene` must outlive it.
    explicit Overlay(const sim::SceneDef& scene);

    /// False: draw() changes nothing.
    bool is_needed() const { return needs_depth() || has_text_ || has_plots_ || colors_.is_needed(); }
    const BodyColors& colors() const { return colors_; }
    /// Draws what lies in the world, and so needs the picture's depths.
    bool needs_depth() const { return world_.is_needed(); }

    /// depth: of this picture; it may be empty if none is needed.
    void draw(Image& image, const sim::Snapshot& snapshot, const Notes& notes, const DepthPicture& depth);

private:
    void draw_text(Canvas& canvas, const sim::Snapshot& snapshot);
    void draw_plots(Canvas& canvas, const sim::Snapshot& snapshot, const Notes& notes);
    void draw_color_legend(Canvas& canvas);
    void draw_scale(Canvas& canvas, const glm::vec2& at, float width);
    void draw_contact_legend(Canvas& canvas);

    const sim::SceneDef& scene_;
    BodyColors colors_;
    WorldLayer world_;
    bool has_text_;
    bool has_plots_;
    float scale_ = 1.0f; ///< [px] 1/720 of the picture's height
    Font font_;
};

} // namespace render
