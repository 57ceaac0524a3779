#pragma once
/// Text, plots and legends over a picture, and what lies in the world, as sim::OverlayDef asks for them.
#include "render/overlay/body_colors.h"
#include "render/overlay/canvas.h"
#include "render/overlay/text.h"
#include "render/overlay/world_layer.h"

namespace render {

/// What a picture shows.
struct Moment {
    double film_time = 0.0; ///< [s]
    const sim::Snapshot& snapshot;
    const Notes& notes;
    const DepthPicture& depth; ///< of the picture; may be empty if none is needed
};

/// Throws Error (usage) for a text over the pictures with a letter that the font lacks, and a logo that is no picture.
void check_overlay(const sim::SceneDef& scene);

class Overlay {
public:
    /// `scene` must outlive it.
    explicit Overlay(const sim::SceneDef& scene);

    /// False: draw() changes nothing.
    bool is_needed() const {
        return needs_depth() || has_text_ || has_plots_ || colors_.is_needed() || !scene_.captions.empty() || !scene_.overlay.logo.empty();
    }
    const BodyColors& colors() const { return colors_; }
    /// Draws what lies in the world, and so needs the picture's depths.
    bool needs_depth() const { return world_.is_needed(); }

    void draw(Image& image, const Moment& moment);

private:
    void draw_text(Canvas& canvas, const sim::Snapshot& snapshot);
    void draw_plots(Canvas& canvas, const sim::Snapshot& snapshot, const Notes& notes);
    void draw_color_legend(Canvas& canvas);
    void draw_scale(Canvas& canvas, const glm::vec2& at, float width);
    void draw_contact_legend(Canvas& canvas);
    void draw_caption(Canvas& canvas, const sim::CaptionDef& caption, double film_time);
    void fit_logo(int picture_size);
    void draw_logo(Canvas& canvas) const;
    /// [px] by which what is in this corner gives way to the logo.
    float beside_logo(sim::LogoCorner corner) const;
    /// [px] where a panel at the top begins that reaches from `left` to the right edge: below the title where it is as wide.
    float top_from(float left) const;

    const sim::SceneDef& scene_;
    BodyColors colors_;
    WorldLayer world_;
    bool has_text_;
    bool has_plots_;
    float scale_ = 1.0f; ///< [px] 1/720 of the picture's height, or of its width where that is less
    glm::vec2 text_end_{0.0f}; ///< [px] lower right corner of the title's panel
    Font font_;
    AlphaImage logo_; ///< as high as the last picture needed it
};

} // namespace render
