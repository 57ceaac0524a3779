#include "render/cmd/simulation.h"

#include "sim/base/bytes.h"
#include "sim/model/film_clock.h"
#include "sim/model/interpolate.h"
#include "sim/scene/overlap.h"
#include "sim/scene/study.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <memory>
#include <utility>

namespace cmd {

namespace {

/// From checkpoint to checkpoint [s] of work: little is lost. And the most [-] of a run that they may take.
constexpr double usual_period = 30.0;
constexpr double most_share = 0.01;

/// Processor time of this thread [s].
double thread_time() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

} // namespace

std::int64_t frame_count_of(const sim::SceneDef& scene) {
    return sim::frame_count(scene.output.duration, scene.output.fps);
}

Simulation::Simulation(const sim::SceneDef& scene, sim::World world, render::Film* film)
    : scene_(scene), world_(std::move(world)), film_(film), frames_{0, frame_count_of(scene)},
      last_step_(sim::step_count_of(scene)), contacts_(sim::contacts_shown(scene)),
      has_law_(sim::study_of(scene).law != sim::Law::none) {
    if (contacts_ == sim::ContactDetail::all) {
        world_.record_impacts();
    }
}

void Simulation::restrict_to(const FrameRange& frames) {
    frames_ = frames;
    const sim::FrameInstant last = sim::frame_instant(scene_, frames.end - 1);
    last_step_ = last.step + (last.share > 0.0 ? 1 : 0);
}

void Simulation::keep_states(std::int64_t steps_between, int count) {
    steps_between_ = steps_between;
    kept_count_ = static_cast<std::size_t>(count);
}

void Simulation::keep_checkpoints(const std::filesystem::path& folder, std::optional<double> checkpoint_period) {
    folder_ = folder;
    checkpoint_period_ = checkpoint_period;
    next_checkpoint_ = processor_time_ + checkpoint_period.value_or(usual_period);
    checkpoints_.emplace(folder, scene_, from_ ? &*from_ : nullptr);
}

/// What a checkpoint holds beside the world: one list for both directions.
template <typename Archive, typename Self>
void Simulation::exchange(Archive& archive, Self& self) {
    archive(self.summary_.start);
    archive(self.summary_.totals);
    archive(self.processor_time_);
    for (auto* miss : {&self.overlap_, &self.unconverged_}) {
        archive(miss->amount);
        archive(miss->time);
        archive(miss->bodies);
    }
    archive(self.unsettled_);
    archive(self.is_out_of_work_);
}

void Simulation::go_on_from(Checkpoint checkpoint, int threads) {
    from_ = std::move(checkpoint);
    sim::ByteReader reader(std::string_view(from_->bytes).substr(from_->state));
    exchange(reader, *this);
    world_ = sim::World::restored(scene_, threads, reader);
    if (contacts_ == sim::ContactDetail::all) {
        world_.record_impacts();
    }
    from_->bytes.clear();
    steps_done_ = world_.step_index();
}

void Simulation::make_checkpoint() {
    const auto begin = std::chrono::steady_clock::now();
    checkpoints_->write([this](sim::ByteWriter& bytes) {
        exchange(bytes, std::as_const(*this));
        world_.save(bytes);
    });
    const double taken = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    next_checkpoint_ = processor_time_ + checkpoint_period_.value_or(std::max(usual_period, taken / most_share));
}

/// The first state, or all up to the checkpoint, go to trajectory and film. False once the film stops.
bool Simulation::begin(const render::ThreadGroup& threads) {
    if (!from_) {
        summary_.start = sim::mechanics(scene_, world_.take_snapshot());
        return record_state();
    }
    bool goes_on = true;
    read_states(folder_, *from_, [&](sim::Snapshot state) {
        goes_on = !threads.is_stopping() && hand_on(std::move(state));
        return goes_on;
    });
    return goes_on;
}

/// All steps; false if it was stopped before the last of them.
bool Simulation::make_steps(const render::ThreadGroup& threads) {
    while (world_.step_index() < last_step_) {
        if (threads.is_stopping()) {
            return false;
        }
        const double before = thread_time();
        const sim::StepReport report = world_.step();
        processor_time_ += thread_time() - before;
        judge(report);
        ++steps_done_;
        if (!record_state()) {
            return false;
        }
        if (checkpoints_ && processor_time_ >= next_checkpoint_) {
            make_checkpoint();
        }
    }
    return true;
}

void Simulation::advance(const render::ThreadGroup& threads) {
    if (!begin(threads)) {
        return;
    }
    if (!make_steps(threads)) {
        if (checkpoints_) {
            make_checkpoint();
        }
        return;
    }
    if (film_ != nullptr) {
        film_->close();
    }
    const sim::Snapshot last = world_.take_snapshot();
    summary_.end = sim::mechanics(scene_, last);
    summary_.state_hash = sim::state_hash(last);
    summary_.simulated_time = world_.time();
    if (steps_between_ == 0) {
        finish_record();
    }
}

void Simulation::finish_record() {
    if (trajectory_) {
        trajectory_->finish();
        trajectory_.reset();
    }
}

void Simulation::judge(const sim::StepReport& report) {
    summary_.totals.add(report, scene_.step.tolerance);
    if (report.max_penetration > std::max(scene_.step.tolerance, overlap_.amount)) {
        overlap_ = {report.max_penetration, world_.time(), world_.take_snapshot().bodies};
    }
    if (report.at_iteration_limit && report.unsettled.error >= unconverged_.amount) {
        unconverged_ = {report.unsettled.error, world_.time(), {}};
        unsettled_ = report.unsettled;
        is_out_of_work_ = report.is_out_of_work;
    }
}

std::string Simulation::names(int a, int b) const {
    return fmt::format("'{}' and '{}'", scene_.bodies[static_cast<std::size_t>(a)].name,
                       scene_.bodies[static_cast<std::size_t>(b)].name);
}

std::string Simulation::missed_promise() const {
    std::vector<std::string> missed;
    if (overlap_.amount > 0.0) {
        missed.push_back(missed_overlap());
    }
    if (summary_.totals.steps_at_iteration_limit > 0) {
        missed.push_back(missed_convergence());
    }
    if (summary_.totals.max_energy_gain > sim::energy_gain_allowed) {
        missed.push_back(fmt::format("energy grew by {:.3g} % of what the run turned over, expected at most {:g} %",
                                     100.0 * summary_.totals.max_energy_gain, 100.0 * sim::energy_gain_allowed));
    }
    return fmt::format("{}", fmt::join(missed, "; "));
}

std::string Simulation::missed_overlap() const {
    sim::SceneDef then = scene_;
    for (std::size_t i = 0; i < then.bodies.size(); ++i) {
        then.bodies[i].pose = {overlap_.bodies[i].position, overlap_.bodies[i].orientation};
    }
    const std::optional<sim::StartOverlap> found = sim::find_start_overlap(then);
    return fmt::format("at {:.6g} s {} overlap by {:.3g} m, expected at most the tolerance, {:g} m; {} of {} steps are above it",
                       overlap_.time, found ? names(found->body_a, found->body_b) : "two bodies", overlap_.amount,
                       scene_.step.tolerance, summary_.totals.steps_above_tolerance, summary_.totals.steps);
}

std::string Simulation::missed_convergence() const {
    const sim::Unsettled& what = unsettled_;
    std::string left;
    if (what.joint >= 0) {
        left = fmt::format("joint '{}' was left open by {:.3g} m", scene_.joints[static_cast<std::size_t>(what.joint)].name,
                           what.error);
    } else if (what.is_pressed) {
        left = fmt::format("{} are pressed {:.3g} m into each other: what closes in on them leaves no room", names(what.a, what.b),
                           what.error);
    } else {
        const std::string where =
            what.a < 0 ? "in the joints"
                       : fmt::format("between {}, in an island of {}, that still change by {:.3g} m/s", names(what.a, what.b),
                                     what.island, what.change);
        left = fmt::format("{} {}, {}",
                           what.error > 0.0 ? fmt::format("a gap error of {:.3g} m was left", what.error) : "impacts did not settle",
                           where,
                           is_out_of_work_ ? "when the step's work was done"
                                           : fmt::format("after {} sweeps of its shortest part", scene_.step.iteration_limit));
    }
    return fmt::format("at {:.6g} s {}; {} of {} steps did not converge", unconverged_.time, left,
                       summary_.totals.steps_at_iteration_limit, summary_.totals.steps);
}

bool Simulation::is_shown_at(std::int64_t frame, std::int64_t step) const {
    const sim::FrameInstant instant = sim::frame_instant(scene_, frame);
    return instant.step + (instant.share > 0.0 ? 1 : 0) == step;
}

Simulation::Use Simulation::use_of(std::int64_t step) const {
    std::int64_t next = next_frame_;
    while (next < frames_.end && is_shown_at(next, step)) {
        ++next;
    }
    Use use;
    use.is_shown = next > next_frame_;
    use.is_before = next < frames_.end && sim::frame_instant(scene_, next).step == step;
    const int every = scene_.output.record_every;
    use.is_record = every > 0 ? step % every == 0 : use.is_shown || use.is_before;
    return use;
}

bool Simulation::record_state() {
    const std::int64_t step = world_.step_index();
    if (steps_between_ > 0 && step % steps_between_ == 0 && kept_states_.size() < kept_count_) {
        kept_states_.push_back(world_.take_snapshot());
    }
    if (!use_of(step).is_any()) {
        return true;
    }
    sim::Snapshot state = world_.take_snapshot(contacts_);
    state.impacts = world_.take_impacts();
    if (checkpoints_) {
        checkpoints_->add(state);
    }
    return hand_on(std::move(state));
}

bool Simulation::hand_on(sim::Snapshot state) {
    const auto snapshot = std::make_shared<const sim::Snapshot>(std::move(state));
    const Use use = use_of(snapshot->step);
    if (has_law_ && use.is_shown) {
        law_states_.push_back(*snapshot);
    }
    if (use.is_record && trajectory_) {
        trajectory_->append(*snapshot);
    }
    if (use.is_record && film_ != nullptr) {
        film_->observe(*snapshot);
    }
    if (!show(snapshot)) {
        return false;
    }
    before_ = use.is_before ? snapshot : nullptr;
    return true;
}

bool Simulation::show(const std::shared_ptr<const sim::Snapshot>& snapshot) {
    // A step longer than a frame is shown by several.
    for (; next_frame_ < frames_.end && is_shown_at(next_frame_, snapshot->step); ++next_frame_) {
        const double share = sim::frame_instant(scene_, next_frame_).share;
        const auto shown = share > 0.0
                               ? std::make_shared<const sim::Snapshot>(sim::interpolated(scene_, *before_, *snapshot, share))
                               : snapshot;
        if (film_ != nullptr && !film_->add(next_frame_, shown)) {
            return false;
        }
    }
    return true;
}

} // namespace cmd
