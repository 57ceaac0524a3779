#pragma once
/// Text, contacts, paths, plots and legends over a picture, as sim::OverlayDef asks for them.
#include "render/body_colors.h"
#include "render/canvas.h"
#include "render/depth_picture.h"
#include "render/notes.h"
#include "render/text.h"

namespace render {

class Overlay {
public:
    /// `scene` must outlive it.
    explicit Overlay(const sim::SceneDef& scene);

    /// False: draw() changes nothing.
    bool is_needed() const { return needs_depth() || has_text_ || has_plots_ || colors_.is_needed(); }
    const BodyColors& colors() const { return colors_; }
    /// Draws what lies in the world, and so needs the picture's depths.
    bool needs_depth() const { return has_contacts_ || has_paths_; }

    /// depth: of this picture; it may be empty if none is needed.
    void draw(Image& image, const sim::Snapshot& snapshot, const Notes& notes, const DepthPicture& depth);

private:
    class Projection;

    void draw_paths(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot,
                    const Notes& notes) const;
    void draw_contacts(Canvas& canvas, const Projection& projection, const sim::Snapshot& snapshot) const;
    void draw_text(Canvas& canvas, const sim::Snapshot& snapshot);
    void draw_plots(Canvas& canvas, const sim::Snapshot& snapshot, const Notes& notes);
    void draw_color_legend(Canvas& canvas);
    void draw_scale(Canvas& canvas, const glm::vec2& at, float width);
    void draw_contact_legend(Canvas& canvas);

    const sim::SceneDef& scene_;
    BodyColors colors_;
    bool has_contacts_;
    bool has_paths_;
    bool has_text_;
    bool has_plots_;
    double view_;        ///< [m] length scale of the view
    double arrow_scale_; ///< [m/(N s)]
    float scale_ = 1.0f; ///< [px] 1/720 of the picture's height
    Font font_;
};

} // namespace render
