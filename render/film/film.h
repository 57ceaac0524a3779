#pragma once
/// States of a scene -> pictures -> PNG files and an MP4, each stage in a thread of its own.
///
///   add() -> [states] -> list -> [shots] -> OpenGL -> [shots] -> edges -> [pictures] -> encode and write PNG
///                                                                     -> [pictures] -> encode video
///
/// The queues between them are short: memory does not grow with the length of the film.
#include "render/film/bounded_queue.h"
#include "render/film/raw_writer.h"
#include "render/film/thread_group.h"
#include "render/film/video_writer.h"
#include "render/overlay/notes.h"
#include "render/overlay/overlay.h"
#include "render/picture/image.h"
#include "render/picture/plan.h"
#include "sim/base/file_io.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace render {

/// Encoder settings of a scene's film: frame rate, title, and how it was made as a comment.
VideoSettings video_settings(const sim::SceneDef& scene);

/// "funnel.mp4", relative to the folder of the run; its end is that of the encoder's container.
std::string film_file_name(const sim::SceneDef& scene);

/// "frames/frame_000000.png", relative to the folder of the run.
std::string frame_file_name(std::int64_t frame);

/// The same of its passes: "frames/frame_000000.exr", "frames/frame_000000.rgba.png", ...
std::vector<std::string> pass_file_names(const sim::OutputDef& output, std::int64_t frame);

struct FilmSettings {
    std::filesystem::path folder; ///< where frames/ and the film go; exists
    bool write_png = true;
    bool write_video = true;  ///< folder / film_file_name()
    bool keep_frames = false; ///< a frame whose file is there is read, not drawn again
    std::int64_t first_frame = 0; ///< frames before it are seen, for what later ones show of them, but not drawn
    std::vector<std::int64_t> frames{}; ///< ascending; only these are drawn; empty: all
    std::optional<RawFormat> raw{}; ///< frames to standard output
    bool write_bodies = false; ///< beside each frame that is drawn: which body each pixel shows
};

/// Where the time of a film went: processor time of its threads [ms], all frames together.
struct FilmTimes {
    double list = 0.0;  ///< from states to what is drawn; occlusion
    double draw = 0.0;  ///< OpenGL; what it does in threads of its own is not counted
    double edges = 0.0; ///< smooth edges, motion blur, what lies over the picture
    double png = 0.0;   ///< compressing and writing
    double video = 0.0; ///< converting and encoding
};

class Film {
public:
    /// `scene` must outlive the film.
    Film(const sim::SceneDef& scene, const FilmSettings& settings);

    /// Starts its threads; they end when close() has been called and everything is written, or when the group
    /// stops. The film must outlive them: declare the group after it. Errors (io) arrive through the group.
    void start(ThreadGroup& threads);

    /// The state shown by the next frame: `frame` ascends by 1 from call to call. Waits while the drawing is
    /// behind. False once the group stops.
    bool add(std::int64_t frame, std::shared_ptr<const sim::Snapshot> snapshot);
    /// A state between frames, for curves and paths.
    void observe(const sim::Snapshot& snapshot);
    /// True if frames show something of the states before them, which then must be observed.
    bool shows_past() const { return note_taker_.is_needed(); }

    /// No more frames come.
    void close() { states_.close(); }

    /// Frames that are written whole.
    std::int64_t frames_done() const;

    /// What has been written, in order; once the threads have ended.
    std::vector<sim::WrittenFile> files() const;

    /// Once the threads have ended.
    const FilmTimes& times() const { return times_; }
    /// OpenGL's name and version, once the threads have ended.
    const std::string& renderer_string() const { return renderer_string_; }

private:
    struct State {
        std::int64_t frame = 0;
        std::shared_ptr<const sim::Snapshot> snapshot;
        std::shared_ptr<const Notes> notes;
    };
    /// One of the pictures that a frame is the mean of, or the kept picture of a frame.
    struct Shot {
        State state;
        std::shared_ptr<const Image> kept{};
        bool is_first = true; ///< of the frame: a whole picture
        int left = 0;         ///< shots of the frame that follow
        DrawList list{};
        RawPicture raw{};
        DepthPicture depth{}; ///< of the middle shot, where something lies over the picture
    };
    struct Picture {
        std::int64_t frame = 0;
        std::shared_ptr<const Image> image;
        bool is_kept = false; ///< its file is there
    };

    std::shared_ptr<const Image> kept_picture(std::int64_t frame) const;
    void list_shots();
    void draw_shots();
    void finish_pictures();
    void write_numbers(const Shot& shot, const DepthPicture& depth);
    double frame_time(std::int64_t frame) const; // [s] simulated, to the next one
    void hand_on(const Picture& picture);
    void write_frames();
    void encode_video(const ThreadGroup& threads);
    void write_raw();

    const sim::SceneDef& scene_;
    FilmSettings settings_;
    NoteTaker note_taker_; // of the thread that adds
    Overlay overlay_;      // colours: of the thread that lists; the rest: of the one that finishes
    std::shared_ptr<const PicturePlan> plan_;
    BoundedQueue<State> states_;
    BoundedQueue<Shot> listed_;
    BoundedQueue<Shot> drawn_;
    BoundedQueue<RawPicture> blanks_; ///< raw pictures to be drawn into again
    BoundedQueue<Picture> for_png_;
    BoundedQueue<Picture> for_video_;
    std::atomic<std::int64_t> pngs_done_ = 0;
    std::atomic<std::int64_t> video_frames_done_ = 0;
    std::string renderer_string_;               // of the thread that draws
    std::vector<sim::WrittenFile> number_files_; // of the thread that finishes
    std::vector<sim::WrittenFile> png_files_;   // of the thread that writes them
    std::vector<sim::WrittenFile> video_files_; // of the thread that encodes
    FilmTimes times_;                           // each of the thread that does it
};

} // namespace render
