#pragma once
/// One scene on its way from state 0 to the end of the film, or to the last frame of a slice.
#include "render/cmd/checkpoint.h"
#include "render/cmd/options.h"
#include "render/film/film.h"
#include "render/film/thread_group.h"
#include "sim/model/scene_def.h"
#include "sim/record/summary.h"
#include "sim/record/trajectory.h"
#include "sim/world/world.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace cmd {

/// Frames of a scene's whole film.
std::int64_t frame_count_of(const sim::SceneDef& scene);

class Simulation {
public:
    /// film: may be null; scene and film must outlive this.
    Simulation(const sim::SceneDef& scene, sim::World world, render::Film* film);

    /// All states are recorded in `path` too. Throws Error (io).
    void record_to(const std::filesystem::path& path) { trajectory_.emplace(path, scene_, contacts_); }
    /// The states of every so many steps are kept, `count` of them, the start being the first; the record gets its name by
    /// finish_record() then.
    void keep_states(std::int64_t steps_between, int count);
    /// Before record_to() and keep_checkpoints(): advance() goes on from a checkpoint. threads: of the simulation. Throws
    /// Error (io).
    void go_on_from(Checkpoint checkpoint, int threads);
    /// A checkpoint is kept in the folder every so many seconds of work [s]; none given: such that checkpoints take less
    /// than a hundredth of the time. Throws Error (io).
    void keep_checkpoints(const std::filesystem::path& folder, std::optional<double> checkpoint_period);
    /// The film begins with the first of these frames, and the simulation ends with the last of them.
    void restrict_to(const FrameRange& frames);

    /// The thread's work: all steps, or as many as are made until the group stops. Throws Error.
    void advance(const render::ThreadGroup& threads);

    /// Gives the record its name, once advance() has returned. Throws Error (io).
    void finish_record();

    std::int64_t steps_done() const { return steps_done_; }
    std::int64_t last_step() const { return last_step_; }
    /// Once advance() has returned.
    const sim::Summary& summary() const { return summary_; }
    /// Promises that were missed, each by its time, bodies and amount, in one sentence; empty if all steps converged
    /// and ended within the tolerance, and energy did not grow.
    std::string missed_promise() const;
    /// [s] Processor time of the thread that advances.
    double processor_time() const { return processor_time_; }
    /// The states that the frames show, of a scene that names a law: at its instants error is measured.
    const std::vector<sim::Snapshot>& law_states() const { return law_states_; }
    std::vector<sim::Snapshot> take_kept_states() { return std::move(kept_states_); }

private:
    /// A step that missed what the scene asks for.
    struct Miss {
        double amount = 0.0; ///< [m]; 0: there was none
        double time = 0.0;   ///< [s] at its end
        std::vector<sim::BodySnapshot> bodies; ///< then
    };
    template <typename Archive, typename Self>
    static void exchange(Archive& archive, Self& self);
    bool begin(const render::ThreadGroup& threads);
    bool make_steps(const render::ThreadGroup& threads);
    void make_checkpoint();
    /// Keeps the step in mind if it is the worst so far.
    void judge(const sim::StepReport& report);
    std::string names(int a, int b) const; ///< of two bodies
    std::string missed_overlap() const;
    std::string missed_convergence() const;
    /// Hands the present state to trajectory and film, where it is one of theirs. False once the film stops.
    bool record_state();
    /// What the state at a step serves.
    struct Use {
        bool is_shown = false;  ///< by the next frame, itself or as the later of two states
        bool is_before = false; ///< as the earlier of two states that a frame lies between
        bool is_record = false; ///< of the trajectory
        bool is_any() const { return is_shown || is_before || is_record; }
    };
    Use use_of(std::int64_t step) const;
    /// A state of trajectory or film. False once the film stops.
    bool hand_on(sim::Snapshot state);
    /// True if frame `frame` shows the state at `step`, or one between it and the state before.
    bool is_shown_at(std::int64_t frame, std::int64_t step) const;
    /// Hands on the frames that are shown now. False once the film stops.
    bool show(const std::shared_ptr<const sim::Snapshot>& snapshot);

    const sim::SceneDef& scene_;
    sim::World world_;
    render::Film* film_;
    std::optional<sim::TrajectoryWriter> trajectory_;
    std::filesystem::path folder_;         ///< of trajectory and checkpoints
    std::optional<Checkpoint> from_;       ///< that advance() goes on from
    std::optional<CheckpointWriter> checkpoints_;
    std::optional<double> checkpoint_period_; ///< [s]
    double next_checkpoint_ = 0.0;         ///< processor_time_ at which it is made [s]
    FrameRange frames_;
    std::int64_t last_step_;
    sim::ContactDetail contacts_; ///< that the pictures show
    bool has_law_ = false;
    std::int64_t next_frame_ = 0;
    std::shared_ptr<const sim::Snapshot> before_; ///< the state before, if a frame shows one between it and the next
    sim::Summary summary_;
    Miss overlap_;     ///< above the tolerance
    Miss unconverged_; ///< a gap error of contacts or of a joint
    sim::Unsettled unsettled_; ///< then
    bool is_out_of_work_ = false;
    std::vector<sim::Snapshot> law_states_;
    std::int64_t steps_between_ = 0; ///< of kept states; 0: none are kept
    std::size_t kept_count_ = 0;
    std::vector<sim::Snapshot> kept_states_;
    double processor_time_ = 0.0;
    std::atomic<std::int64_t> steps_done_ = 0;
};

} // namespace cmd
