/// Keys of cameras, light, and what is drawn over the pictures.
#include "sim/scene/key_groups.h"

namespace sim {
namespace {

using namespace key_groups;

const Keys camera_key_keys{
    {"time", number, "s", required_key, "larger than that of the key before", not_negative, ""},
    {"eye", vector, "m", required_key, "where the camera is", any, ""},
    {"target", vector, "m", required_key, "what it looks at", any, ""},
    {"fov_degrees", number, "degrees", none, "opening there; left out: that of the camera", {1.0, 150.0}, ""},
    {"easing", choice, "", "\"smooth\"",
     "how it moves on to the next key: `smooth`, through both without a stop; `stop`, at rest at both; `linear`, at one "
     "speed; `cut`, not at all, and the next key begins a new shot", any, "smooth stop linear cut"},
};

} // namespace

std::vector<SectionSpec> view_sections() {
    return {
        {"camera",
         "[[camera]]",
         "A view.",
         {
             {"name", text, "", required_key, "how `output.camera` calls it; unique", any, ""},
             {"kind", choice, "", "\"keys\"",
              "`keys`: fixed, or moving from key to key; `orbit`: the eye turns about the target's vertical, around a "
              "body if one is named; `follow`: eye and target are offsets from a body's centre of mass; `track`: the "
              "eye stays, the target is an offset from a body's centre of mass and may be left out; `frame`: looks "
              "along the line from eye to target, from where the bodies fill the picture, whatever its format",
              any, "keys orbit follow track frame"},
             {"fov_degrees", number, "degrees", "40",
              "vertical opening; a picture narrower than 16:9 is opened until it is as wide as one of 16:9", {1.0, 150.0},
              ""},
             {"eye", vector, "m", none, "where the camera is; with target", any, ""},
             {"target", vector, "m", none, "what it looks at; with eye", any, ""},
             {"keys", tables, "", none, "instead of eye and target: see below", any, "[{ time = ... }]"},
             {"period", number, "s", "20", "of an orbit", positive, ""},
             {"body", text, "", none, "name of the body to orbit, follow or track", any, ""},
             {"bodies", texts, "", none, "names of the bodies to frame; left out: all that move", any, ""},
         }},
        {"camera.keys", "keys = [{ ... }]", "What a moving camera sees at one time.", camera_key_keys},
        {"light",
         "[light]",
         "Sun and sky.",
         {
             {"to_sun", direction, "", "[0.4, -0.5, 0.8]", "from the ground towards the sun", any, ""},
             {"sun_color", color, "", "[1.0, 0.96, 0.90]", "of its light", unit_interval, ""},
             {"sun_intensity", number, "", "3.4",
              "its brightness: a white surface that faces it has this radiance", not_negative, ""},
             {"sky_zenith", color, "", "[0.90, 0.95, 1.00]",
              "colour straight above: most of the light in shadows", unit_interval, ""},
             {"sky_horizon", color, "", "[0.07, 0.10, 0.16]", "colour at the horizon: the background", unit_interval, ""},
             {"sky_intensity", number, "", "1.0", "its brightness", not_negative, ""},
         }},
    };
}

std::vector<SectionSpec> overlay_sections() {
    return {
        {"overlay",
         "[overlay]",
         "Text, contacts, paths and plots over the pictures, and what bodies are coloured by.",
         {
             {"show", words, "", "[]",
              "what is drawn: the scene's `title`; `time`, number of loaded `contacts` and `energy` as text; "
              "contact `points` (sticking and sliding in two colours), `normals`, and `impulses` as arrows, of contacts "
              "in a step and of impacts since the frame before, each at a scale of its own; `trails` of "
              "centres of mass; `contact_paths`, where bodies were touched, on them and in the world; the `plots`",
              any, "title time contacts energy points normals impulses trails contact_paths plots"},
             {"color_by", choice, "", "\"look\"",
              "`look`: as the bodies say; `material`, `body`: a colour each; `speed` [m/s], number of "
              "`contacts`, sum of normal `impulse`s in one step [N s]: moving bodies on a scale, with a legend",
              any, "look material body speed contacts impulse"},
             {"color_range", interval, "", none, "of that scale; left out: chosen from the scene", any, ""},
             {"arrow_scale", number, "m/(N s)", none, "length of the arrow of a contact's impulse; left out: chosen "
              "from the scene", positive, ""},
             {"trail_time", number, "s", none, "how far back trails reach; left out: to the start", positive, ""},
             {"bodies", texts, "", none, "names of the bodies with trails and contact paths; left out: all "
              "that move", any, ""},
             {"plots_at", choice, "", "\"bottom_right\"", "corner of the picture that the plots are in", any,
              "bottom_right top_right"},
             {"zero_height", number, "m", "0", "where potential energy counts from", any, ""},
             {"logo", text, "", none, "PNG file, relative to the scene file, that is drawn in a corner, over cards too; the "
              "run keeps it as data:image/png;base64,...", any, ""},
             {"logo_at", choice, "", "\"top_right\"", "that corner", any, "top_right top_left bottom_right bottom_left"},
             {"logo_height", number, "", "0.1", "its height, as a share of the picture's, or of its width where that is less", {0.0, 1.0, true}, ""},
         }},
        {"caption", "[[caption]]", "Text over the pictures for a time.",
         {
             {"text", text, "", required_key, "lines end at \\n and where they are too long for the picture", any, ""},
             {"place", choice, "", "\"bottom\"", "where it is; a `card` covers the whole picture", any,
              "bottom top middle card"},
             {"time", number, "s", "0", "of the film, when it comes", not_negative, ""},
             {"duration", number, "s", "3", "how long it stays", positive, ""},
             {"fade", number, "s", "0.3", "how long it takes to come, unless the film begins with it, and to go",
              not_negative, ""},
         }},
        {"plot",
         "[[plot]]",
         "A curve over time that grows with the film; drawn if `overlay.show` has \"plots\".",
         {
             {"title", text, "", "\"\"", "above the plot; left out: the quantity", any, ""},
             {"quantity", choice, "", required_key,
              "`energy`: kinetic, potential and their sum [J], without that in springs; `inclination` of a body's z axis to the "
              "vertical [degrees]; `distance` of a body's centre of mass from its place at the start [m]; "
              "number of loaded `contacts`", any, "energy inclination distance contacts"},
             {"bodies", texts, "", none, "names of the bodies, a curve each; not for energy and contacts", any, ""},
             {"range", interval, "", none, "of the quantity; left out: grows with it", any, ""},
             {"closed_form_on", text, "", none,
              "name of the box down whose top the bodies slide: with the distance that Coulomb's friction "
              "gives in closed form, as a dashed curve", any, ""},
         }},
    };
}

} // namespace sim
