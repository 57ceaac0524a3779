#pragma once
/// Plain data on what a scene writes and draws over its pictures.
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace sim {

/// What may be drawn over a picture; the words of `overlay.show`, in this order.
enum class Shown {
    title,         ///< the scene's title
    time,          ///< [s]
    contacts,      ///< number of contacts that carry a load
    energy,        ///< kinetic and potential [J]
    points,        ///< contact points, sticking and sliding ones in two colours
    normals,       ///< of contacts, from b to a
    impulses,      ///< of contacts, as arrows
    trails,        ///< where bodies' centres have been
    contact_paths, ///< where bodies have been touched, on the body and in the world
    plots,         ///< the scene's plots
};
inline constexpr int shown_count = 10;

/// What bodies are coloured by.
enum class ColorBy { look, material, body, speed, contacts, impulse };

/// Where the plots are.
enum class PlotCorner { bottom_right, top_right };

/// Where the logo is.
enum class LogoCorner { top_right, top_left, bottom_right, bottom_left };

/// Where a caption is. A card covers the whole picture.
enum class CaptionPlace { bottom, top, middle, card };

/// Text over the pictures for a time.
struct CaptionDef {
    std::string text;            ///< lines end at "\n" and where they are too long
    CaptionPlace place = CaptionPlace::bottom;
    double time = 0.0;           ///< [s] of the film
    double duration = 3.0;       ///< [s] > 0
    double fade = 0.3;           ///< [s] in, unless the film begins with it, and out
};

struct OverlayDef {
    std::array<bool, shown_count> show{};
    ColorBy color_by = ColorBy::look;
    std::optional<std::array<double, 2>> color_range; ///< of the quantity; unset: chosen from the scene
    double arrow_scale = 0.0;                         ///< [m/(N s)] length of impulse arrows; 0: chosen
    double trail_time = 0.0;                          ///< [s] length of a trail; 0: all of it
    std::vector<int> bodies; ///< indices into bodies: those with trails and contact paths
    PlotCorner plots_at = PlotCorner::bottom_right;
    double zero_height = 0.0; ///< [m] where potential energy counts from
    std::string logo;         ///< a PNG file's bytes; empty: none
    LogoCorner logo_at = LogoCorner::top_right;
    double logo_height = 0.1; ///< [-] of the picture's, or of its width where that is less

    bool shows(Shown what) const { return show[static_cast<std::size_t>(what)]; }
};

enum class PlotQuantity {
    energy,      ///< kinetic, potential and their sum [J], of all bodies
    inclination, ///< angle between a body's z axis and the vertical [degrees]
    distance,    ///< of a body's centre from where it was at the start [m]
    contacts,    ///< number of contacts that carry a load
};

/// A plot of one quantity over time.
struct PlotDef {
    std::string title;
    PlotQuantity quantity = PlotQuantity::energy;
    std::vector<int> bodies; ///< indices into bodies, one curve each; energy, contacts: none
    std::optional<std::array<double, 2>> range; ///< of the value axis; unset: grows with the values
    int closed_form_on =
        -1; ///< index into bodies: the incline that the bodies slide down, for the closed form
};

/// How much of the contacts a snapshot holds.
enum class ContactDetail { none, count, all };

} // namespace sim
