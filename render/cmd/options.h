#pragma once
/// What the user asks for on the command line.
#include "render/cmd/slurm.h"
#include "render/film/film.h"
#include "render/film/stills.h"
#include "sim/model/scene_def.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cmd {

struct Options {
    std::vector<std::string> inputs;      ///< scene files, or one trajectory
    std::string out;                      ///< folder; empty: the verb's own default
    std::string size;                     ///< "WxH" [px]
    std::vector<std::string> presets;     ///< words: preview, standard, accurate; draft, standard, final
    std::string fps;                      ///< [1/s] number or fraction
    std::string duration;                 ///< [s]
    std::string time_step;                ///< [s]
    std::string tolerance;                ///< [m]
    double accuracy = 0.0;                ///< [m] that settings are to be found for; 0: the scene's hold
    double budget = 0.0;                  ///< [s] wall time that settings are to be found for; 0: the scene's hold
    std::string record_every;             ///< [steps]
    std::string crf;                      ///< of the film
    std::string camera;                   ///< name
    std::string show;                     ///< "time,points": words of overlay.show; "none"
    std::string color_by;                 ///< word of overlay.color_by
    std::string passes;                   ///< "depth,normal": words of output.passes; "none"
    std::vector<std::string> assignments; ///< "dotted.key=value"
    int threads = 0;                      ///< of the simulation; 0: one a core
    std::string format;                   ///< of a film to standard output: "y4m", "rgb24"
    bool no_video = false;
    bool no_png = false;
    std::string frames;        ///< "A:B": frames A .. B - 1 only
    double poster_time = -1.0; ///< [s]; negative: no poster
    int sheet_count = 0;       ///< frames on a sheet; 0: no sheet
    bool has_webp = false;
    bool has_gif = false;
    int animation_width = 0;   ///< [px]; 0: as usual
    double animation_rate = 0; ///< [1/s]; 0: as usual
    bool is_resumed = false;   ///< whole frames of an earlier run stay, and its simulation goes on
    std::optional<double> checkpoint_period; ///< [s] of work; see Simulation::record_to()
    bool has_body_ids = false; ///< which body each pixel shows, beside the frames
    std::string gl;            ///< what draws; empty: what the scene says
    bool is_portable = false;  ///< pictures as processors without fused multiply-add draw them
    bool is_estimated = false; ///< what a run will cost is told
    bool is_strict = false;    ///< a promise that was missed is no success
    Placement placement; ///< of the work
    bool is_quiet = false;
    std::string progress = "text"; ///< "json": for machines
};

/// True where the film goes to standard output, `--out -`. Throws Error (usage) if other options do not go with that.
bool is_piped(const Options& options);
/// Of that film, from this frame on.
render::FilmSettings piped_film(const Options& options, std::int64_t first_frame);

/// How progress is told.
ProgressStyle progress_style(const Options& options);

/// What a verb can change of a scene.
enum class Changes {
    everything,  ///< before the simulation
    only_output, ///< size, frame rate and look of an earlier simulation
};

/// Frames begin .. end - 1.
struct FrameRange {
    std::int64_t begin = 0;
    std::int64_t end = 0;
};

/// The frames asked for of a film of `frame_count`. Throws Error (usage).
FrameRange frame_range(const Options& options, std::int64_t frame_count);

/// Adds the options of one verb. `options` must outlive the parsing.
void add_options(CLI::App& verb, Options& options, Changes changes);
/// --progress and --quiet.
void add_progress_options(CLI::App& verb, Options& options);
/// --resume of a simulation, and how often it keeps a checkpoint.
void add_checkpoint_options(CLI::App& verb, Options& options);
/// --frames, --gl, --portable and where the work is done.
void add_frame_options(CLI::App& verb, Options& options);
/// --gl alone.
void add_gl_option(CLI::App& verb, std::string& gl);
/// --strict, the default where the environment says CI=true, and --no-strict.
void add_strict_option(CLI::App& verb, Options& options);
/// --accuracy and --budget.
void add_search_options(CLI::App& verb, Options& options);
/// --poster, --sheet, --webp and --gif.
void add_still_options(CLI::App& verb, Options& options);

/// What they ask for. Throws Error (usage) if it cannot be made of what is written.
render::StillsSettings stills_of(const Options& options);

/// The changes as assignments to scene keys, in the order --set, then the others. Throws Error (usage).
std::vector<std::string> overrides_of(const Options& options);

/// The preset of the pictures that was asked for by name; empty if none was. Throws Error (usage).
std::string picture_preset(const Options& options);

/// The preset of the simulation that was asked for by name; empty if none was. Throws Error (usage).
std::string simulation_preset(const Options& options);

/// A scene file, the name of a scene of scene_folder(), or "-": standard input; with all changes, and with the
/// simulation's preset below them. Throws Error: what is wrong with an option is told by its own name.
/// found: settings that the program has chosen itself, which hold against those of --set.
sim::SceneDef load_scene(const std::string& path, const Options& options, const std::vector<std::string>& found = {});

/// Throws Error before anything is made: stopped if memory cannot hold the scene's pictures, usage if the film's encoder
/// is not there or refuses them. has_video: pictures become a film.
void require_film(const sim::SceneDef& scene, bool has_video = true);

/// Threads to simulate with, >= 1: those asked for, else one a core. Those that draw at the same time share the cores.
int thread_count(const Options& options);

/// The verbs; each throws Error.
/// tumble run: simulates, draws and encodes.
void run_scenes(const Options& options);
/// tumble simulate: trajectory and summary only.
void simulate_scenes(const Options& options);
/// tumble render: draws and encodes an earlier simulation.
void render_trajectory(const Options& options);
/// tumble join: the film from the frames of one or more folders.
void join_frames(const Options& options);
/// tumble check: reads and validates, prints what the scenes contain.
void check_scenes(const Options& options);
/// tumble scenes: a line for each scene of a folder.
void list_scenes(const Options& options);
/// tumble new: writes a commented scene to start from.
void new_scene(const Options& options);
/// tumble devices: a line for each thing that can draw.
void list_devices(const Options& options);
/// tumble gallery: a page of all results in a folder.
void write_gallery(const Options& options);

} // namespace cmd
