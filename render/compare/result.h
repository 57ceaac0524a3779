#pragma once
/// What a comparison has found, as plain data: cases, their frames, gates, clusters of differing pixels,
/// bodies. The verdict is in the tiers and statuses; everything else explains it. README.md in this folder has
/// the same as JSON. (The namespace is no `compare`: that name is a function in headers of libraries.)
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace diff {

/// How far two pictures are apart; the larger, the worse.
enum class Tier {
    identical, ///< the same pixels
    noise,     ///< differences of edges and rounding: every gate holds
    changed,   ///< a gate is exceeded
};

/// Whether there was something to compare. All but `compared` fail, whatever --fail-on says.
enum class Status {
    compared,
    size_differs,
    reference_missing,
    candidate_missing,
    unreadable, ///< one of the files is no picture, is damaged or is too large
};

/// Why runs differ, where the files beside their pictures tell.
enum class Cause {
    unknown,    ///< no files beside the pictures, or the files are equal and the pictures are not
    scene,      ///< other settings: another scene text, size, rate or --set
    simulation, ///< same scene, other states: the solver or the machine's arithmetic
    drawing,    ///< same states, other shaders or another version of the program
    machine,    ///< same states and shaders, another renderer string
};

/// One condition of tier `noise`: holds while value <= limit.
struct Gate {
    std::string name;   ///< "edge shift", "displacement", "drift", "block drift", ...
    double value = 0.0;
    double limit = 0.0;
    std::string unit;   ///< "px", "levels" (of 255), ...
    std::string reason; ///< one sentence: what was measured, where the worst place is
    std::string source; ///< where the limit is from: "default", or the file of --calibrate
    bool is_exceeded = false;
};

/// A rectangle of pixels; (0, 0) is the upper left pixel of the picture.
struct Box {
    int x = 0;      ///< [px]
    int y = 0;      ///< [px]
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
};

/// The shift that explains the differences of a cluster best.
struct Displacement {
    double x = 0.0;         ///< [px] to the right, from reference to candidate
    double y = 0.0;         ///< [px] down
    double explained = 0.0; ///< [-] 0..1 share of the squared differences that the shift removes
};

/// What a cluster of differing pixels is.
enum class ClusterKind {
    noise,
    moved,      ///< the shift explains it
    recoloured, ///< the same edges with other colours
    replaced,   ///< something appeared, vanished or is another thing
};

/// Neighbouring pixels that differ.
struct Cluster {
    Box box;
    std::int64_t pixels = 0;
    int largest_difference = 0; ///< [levels] 0..255, of one channel
    ClusterKind kind = ClusterKind::noise;
    Displacement displacement;
    std::vector<std::string> bodies; ///< that cover most of it, largest first; empty without body images
};

/// What happened to one body, from the body images of both sides.
struct BodyChange {
    enum class Kind { moved, turned, missing, appeared, recoloured };
    std::string name;
    Kind kind = Kind::moved;
    Displacement displacement;      ///< of its image; 0 where hidden parts keep it from being told
    std::optional<double> distance; ///< [m] that its centre has moved, where both states are known
    std::optional<double> angle;    ///< [degrees] by which it has turned, where both states are known
    std::int64_t pixels = 0;        ///< that it covers in the reference (in the candidate if it appeared)
    Box box;                        ///< of its image in the reference (in the candidate if it appeared)
};

/// One pair of pictures.
struct Frame {
    std::string name;          ///< of the file without folder, "frame_000012.png"; of a film "frame 12"
    std::int64_t index = 0;    ///< its number, as the file's name has it; 0-based place in a sequence without numbers
    Status status = Status::compared;
    Tier tier = Tier::identical; ///< where status is compared; otherwise changed
    std::string message;       ///< one sentence that explains status and tier
    int width = 0;             ///< [px] of the reference; 0 if there is none
    int height = 0;            ///< [px]
    int candidate_width = 0;   ///< [px]; 0 if there is none
    int candidate_height = 0;  ///< [px]
    std::int64_t differing_pixels = 0;
    int largest_difference = 0;       ///< [levels] 0..255, of one channel
    double mean_difference = 0.0;     ///< [levels] mean of the absolute differences of all channels
    double curve = 0.0;               ///< largest value / limit of all gates: above 1 is changed
    std::vector<Gate> gates;          ///< empty if identical or not compared
    std::vector<Cluster> clusters;    ///< the largest 16 at most, largest first
    std::vector<BodyChange> bodies;   ///< the largest 16 at most
    std::string scene_change;         ///< what all bodies that stand still show: another camera, another light; or empty
    /// Pictures for review, relative to the folder of the report; empty if there is none. An identical frame
    /// and the frames of a long sequence beyond the worst ones have none.
    std::string reference_picture;
    std::string candidate_picture;
    std::string difference_picture;
};

/// Frames begin .. end - 1.
struct FrameRun {
    std::int64_t begin = 0;
    std::int64_t end = 0;
};

/// What made one side, where its run.json, summary.json or manifest tells; empty texts where they do not.
struct Origin {
    std::string program;       ///< "tumble 0.1.0"
    std::string scene;         ///< name
    std::string state_hash;    ///< of the last state, 16 hexadecimal digits
    std::string shaders_hash;  ///< 16 hexadecimal digits
    std::string renderer;      ///< OpenGL's renderer and version
    std::string processor;     ///< what else the pictures' bytes depend on
    std::map<std::string, std::string> shaders; ///< hash of each file
};

/// What an earlier run of the same comparison found, see history.h.
struct PastRun {
    std::string time;       ///< "2026-01-31T12:00:00Z"
    bool is_failed = false;
    double curve = 0.0;     ///< largest of its frames
};

/// One thing under comparison: a pair of pictures (one frame), or two sequences of them.
struct Case {
    std::string name;
    std::string reference; ///< as the user gave it
    std::string candidate;
    bool is_sequence = false;
    Status status = Status::compared; ///< the first that is not `compared` among its frames
    Tier tier = Tier::identical;      ///< the worst of its frames
    bool is_failed = false;           ///< above --fail-on, or not compared
    int error_code = 0;               ///< exit code of what kept it from being compared; 0: nothing did
    std::string message;              ///< one sentence
    Cause cause = Cause::unknown;
    std::string cause_text;           ///< one sentence; empty if the cause is unknown
    Origin reference_origin;
    Origin candidate_origin;
    std::vector<Frame> frames;        ///< in order; Frame::curve over index is the curve of a sequence
    // Of sequences:
    std::optional<std::int64_t> first_bad_frame; ///< first whose tier is above --fail-on, or not compared
    std::optional<std::int64_t> worst_frame;     ///< largest curve
    std::vector<FrameRun> bad_runs;
    std::vector<std::int64_t> missing_frames;    ///< of the reference, that the candidate has not
    std::vector<std::int64_t> extra_frames;      ///< of the candidate, that the reference has not
    std::optional<std::int64_t> shift; ///< candidate frame i + shift is reference frame i, for all they share
    std::string film; ///< reference | candidate | difference, relative to the folder of the report; or empty
    double fps = 0.0; ///< [1/s] of the film
    std::vector<PastRun> history; ///< the last runs, this one among them, oldest first; empty if none is kept
    double seconds = 0.0;         ///< [s] that it took; told in JUnit only, since no two runs have the same
};

/// Everything one call of `tumble compare` or `tumble baseline check` has found.
struct Comparison {
    std::string program;              ///< "tumble 0.1.0"
    std::string command;              ///< arguments as given
    std::string accept;               ///< command that makes the candidates the baselines; empty if there is none
    Tier fail_on = Tier::changed;     ///< tiers from this one on fail
    std::vector<Case> cases;
    std::array<std::int64_t, 3> cases_of_tier{}; ///< compared cases by Tier
    std::int64_t failed_cases = 0;
    int exit_code = 0;                ///< 0 good; 1 changed; 3 unreadable; 4 size differs or missing
};

/// The names used in JSON and on pages: "identical", "size_differs", "moved", ...
const char* name_of(Tier tier);
const char* name_of(Status status);
const char* name_of(Cause cause);
const char* name_of(ClusterKind kind);
const char* name_of(BodyChange::Kind kind);

} // namespace diff
