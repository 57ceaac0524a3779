#pragma once
/// Plain data of one scene, as scene/file.cpp reads it. Body frames have their origin in the centre of mass.
#include "sim/base/math.h"
#include "sim/base/rational.h"
#include "sim/model/motion.h"
#include "sim/model/overlay_def.h"
#include "sim/model/shape.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace sim {

/// How impacts inside a step are handled.
enum class ImpactHandling {
    automatic, ///< see impact_handling()
    ahead,     ///< speculative contacts: placed before the impact, held by their predicted gap; cheap with many bodies
    stop,      ///< the step is divided at the time of impact; exact, one solve an impact
};

/// How the solver works. Every tolerance of the simulation lives here.
struct StepSettings {
    Rational time_step{1, 1000};               ///< h [s] > 0
    Vec3 gravity{0, 0, -9.81};                 ///< g [m/s^2]
    double tolerance = 1e-4;                   ///< [m] largest gap error of a resting contact and largest overlap
    double joint_tolerance = 1e-10;            ///< [m] largest gap of a joint
    double velocity_tolerance = 1e-7;          ///< [m/s] the iteration ends when no contact changes by more
    double resting_distance = 1e-4;            ///< eps_c [m]: an approach slower than sqrt(2 g eps_c) rests
    double resting_speed_floor = 1e-6;         ///< [m/s] least value of that threshold (zero gravity)
    int iteration_limit = 2000;                ///< sweeps of one solve; a step has ten times as many
    ImpactHandling impacts = ImpactHandling::automatic;
    bool warm_start = true;                    ///< start from the impulses of the last step
};

/// Surface behaviour. An unset value takes the partner's; two set values: geometric mean; none: 0.
struct MaterialDef {
    std::optional<double> restitution;         ///< e [-] 0..1
    std::optional<double> mu_s;                ///< [-] >= mu_d
    std::optional<double> mu_d;                ///< [-] >= 0
};

/// Pattern drawn on a surface so that its turning is seen.
enum class Pattern { plain, stripes, checker, grid };

/// How a body looks.
struct LookDef {
    Vec3 color{0.7, 0.7, 0.7};                 ///< linear RGB 0..1; a plane without one: floor_color
    Vec3 pattern_color{0.15, 0.15, 0.15};      ///< linear RGB 0..1; a plane without one: floor_line_color
    Pattern pattern = Pattern::plain;
    double roughness = 0.5;                    ///< [-] 0.05..1
    double metallic = 0.0;                     ///< [-] 0..1
    bool visible = true;
    /// Surface of revolution about the body's z axis, drawn instead of the shape: (radius, z) [m] points from
    /// bottom to top, z in the body frame (centre of mass at 0). Empty: the shape itself is drawn.
    std::vector<Eigen::Vector2d> lathe;
};

/// Colours of a plane whose scene names none: dark, so that bodies stand out.
inline const Vec3 floor_color{0.045, 0.053, 0.068};
inline const Vec3 floor_line_color{0.13, 0.15, 0.19};

/// One body. Pose and velocities at t = 0, or as it is released.
struct BodyDef {
    std::string name;
    Shape shape;                               ///< in the body frame: origin in the centre of mass
    MassProperties mass;                       ///< centre_of_mass == 0; mass == 0: static or kinematic
    Pose pose;                                 ///< world_from_body
    Vec3 velocity = Vec3::Zero();              ///< v [m/s] of the centre of mass
    Vec3 angular_velocity = Vec3::Zero();      ///< w [rad/s], world frame
    MaterialDef material;
    LookDef look;
    std::optional<Shape> drawn;                ///< instead of the shape, in the same frame
    Motion motion;                             ///< of a kinematic body: moved by keys; pose and velocities are its at t = 0
    double release = 0.0;                      ///< [s] >= 0, the end of a step: from then on it is there

    bool is_static() const { return mass.mass == 0.0; }                 ///< no force moves it
    bool is_kinematic() const { return !motion.is_empty(); }
    bool is_fixed() const { return is_static() && !is_kinematic(); }    ///< and no key
    bool is_there(double time) const { return release <= 0.0 || time >= release; }
    const Shape& drawn_shape() const { return drawn ? *drawn : shape; }
};

enum class JointKind {
    ball,    ///< the two anchors coincide
    hinge,   ///< and the two axes are parallel
    slider,  ///< the second anchor moves along the axis, and nothing turns
};

/// Holds a hinge at an angle, or a slider at a place; softly.
struct SpringDef {
    double stiffness = 0.0;                    ///< k [N m/rad] or [N/m] >= 0
    double damping = 0.0;                      ///< c [N m s/rad] or [N s/m] >= 0
    double rest = 0.0;                         ///< [rad] or [m] from the start, of a against b
};

/// Turns a hinge, or pushes a slider.
struct MotorDef {
    double speed = 0.0;                        ///< [rad/s] or [m/s] of a against b
    double limit = 0.0;                        ///< [N m] or [N] > 0 largest torque or force
};

/// Joint between two bodies; where the second is the world or static it holds the first in place.
struct JointDef {
    std::string name;
    JointKind kind = JointKind::ball;
    int body_a = -1;                           ///< index into bodies
    int body_b = -1;                           ///< index into bodies; -1: the world
    Vec3 anchor = Vec3::Zero();                ///< [m], world, at t = 0
    Vec3 axis{0, 1, 0};                        ///< unit, world, at t = 0; of a hinge or slider
    std::optional<SpringDef> spring;           ///< along or about that axis
    std::optional<MotorDef> motor;
    bool is_drawn = true;                      ///< as a rod from the anchor to body_a's centre
};

/// View at one instant.
struct CameraKey {
    double time = 0.0;                         ///< [s]
    Vec3 eye{10, -10, 6};                      ///< [m]
    Vec3 target = Vec3::Zero();                ///< [m]
    double fov_degrees = 0.0;                  ///< 0: that of the camera
    Easing easing = Easing::smooth;            ///< to the next key
};

enum class CameraKind { keys, orbit, follow, track, frame };

/// A body that a camera keeps in the picture, as a ball.
struct FramedBody {
    int body = -1;                             ///< index into bodies
    double radius = 0.0;                       ///< [m] of the ball about the centre of mass that holds the body
};

/// keys: one key is a fixed camera, more are joined. orbit: the first key's eye turns about its target once in
/// `period`; with a body both are offsets from its centre. follow: eye and target are offsets from a body's centre.
/// track: only the target is. frame: looks from the eye towards the target, from so far away that bodies fill the
/// picture.
struct CameraDef {
    std::string name = "main";
    CameraKind kind = CameraKind::keys;
    double fov_degrees = 40.0;                 ///< vertical, 1..150, of a picture of 16:9; see opening_degrees
    std::vector<CameraKey> keys;               ///< at least one
    double period = 20.0;                      ///< [s], orbit
    int body = -1;                             ///< index into bodies: orbit, follow, track; -1: none
    std::vector<FramedBody> framed;            ///< frame
    double distance = 0.0;                     ///< [m] of the eye from what it looks at, at the start; 0: as in keys
};

struct LightDef {
    Vec3 to_sun{0.4, -0.5, 0.8};               ///< direction towards the sun, unit
    Vec3 sun_color{1.0, 0.96, 0.90};           ///< linear RGB
    double sun_intensity = 3.4;                ///< [-] >= 0
    Vec3 sky_zenith{0.90, 0.95, 1.00};         ///< linear RGB
    Vec3 sky_horizon{0.07, 0.10, 0.16};        ///< linear RGB
    double sky_intensity = 1.0;                ///< [-] >= 0
};

/// Settings of the pictures that go together; each can be set by itself too.
enum class Preset {
    draft,      ///< as fast as can be
    standard,
    final,      ///< for the last run
};

/// How fast the film runs from a time on.
struct SpeedKey {
    double time = 0.0;                         ///< [s] of the film
    double speed = 1.0;                        ///< [-] >= 0: simulated seconds a second of film
};

/// What is written beside each frame; the words of `output.passes`, in this order.
enum class PicturePass { depth, normal, body, motion, alpha, rgba, depth16, rgb16 };
inline constexpr int pass_count = 8;

struct OutputDef {
    int width = 1280;                          ///< [px] 1..16384
    int height = 720;                          ///< [px] 1..16384
    bool smooth_edges = true;
    bool soft_shadows = true;
    bool ambient_occlusion = true;
    int shadow_size = 1024;                    ///< [px] side of the shadow map, 64..8192
    int crf = 18;                              ///< the encoder's rate factor, 0 (lossless) .. 51
    std::string effort = "veryfast";           ///< x264's preset: effort against size of the film
    std::string encoder = "auto";              ///< libavcodec's name of the film's encoder; auto: libx264
    int bits = 8;                              ///< of a colour in the film: 8 or 10
    std::string gl = "auto";                   ///< what draws: auto, osmesa, egl, or egl:0, egl:1, ...
    double shutter = 0.0;                      ///< [-] 0..1 of the time between two frames; 0: no motion blur
    int subframes = 8;                         ///< 1..256 pictures that a blurred frame is the mean of
    std::array<bool, pass_count> passes{};     ///< beside each frame
    Rational fps{60, 1};                       ///< [1/s] > 0
    Rational duration{6, 1};                   ///< [s] > 0, of the film
    double speed = 1.0;                        ///< [-] > 0: simulated seconds a second of film
    std::vector<SpeedKey> speed_keys;          ///< instead: straight from key to key, held before and after them
    int record_every = 0;                      ///< steps a trajectory record; 0: one record a frame
    std::string camera;                        ///< name; empty: the first

    bool has(PicturePass pass) const { return passes[static_cast<std::size_t>(pass)]; }
    bool has_passes() const { return passes != std::array<bool, pass_count>{}; }
};

/// The preset as such: other keys at their defaults.
inline OutputDef output_of(Preset preset) {
    OutputDef output;
    if (preset == Preset::draft) {
        output.smooth_edges = false;
        output.soft_shadows = false;
        output.ambient_occlusion = false;
        output.shadow_size = 512;
        output.crf = 23;
        output.effort = "ultrafast";
    } else if (preset == Preset::final) {
        output.width = 1920;
        output.height = 1080;
        output.shadow_size = 2048;
        output.crf = 16;
        output.effort = "medium";
    }
    return output;
}

struct SceneDef {
    std::string name;                          ///< file name without .toml
    std::string title;
    StepSettings step;
    std::vector<BodyDef> bodies;
    std::vector<JointDef> joints;
    std::vector<CameraDef> cameras;            ///< at least one after load
    LightDef light;
    OutputDef output;
    OverlayDef overlay;
    std::vector<PlotDef> plots;
    std::vector<CaptionDef> captions;
    std::string text;                          ///< the file as read
    std::vector<std::string> overrides;        ///< "dotted.key=value", in the order applied
};

/// What the pictures of a scene need of its contacts.
inline ContactDetail contacts_shown(const SceneDef& scene) {
    using enum Shown;
    const OverlayDef& overlay = scene.overlay;
    if (overlay.shows(points) || overlay.shows(normals) || overlay.shows(impulses) ||
        overlay.shows(contact_paths) || overlay.color_by == ColorBy::contacts ||
        overlay.color_by == ColorBy::impulse) {
        return ContactDetail::all;
    }
    bool is_counted = overlay.shows(contacts);
    for (const PlotDef& plot : scene.plots) {
        is_counted = is_counted || (overlay.shows(plots) && plot.quantity == PlotQuantity::contacts);
    }
    return is_counted ? ContactDetail::count : ContactDetail::none;
}

} // namespace sim
