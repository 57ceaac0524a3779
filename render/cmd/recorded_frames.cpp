#include "render/cmd/recorded_frames.h"

#include "render/scene/camera.h"
#include "sim/base/error.h"
#include "sim/model/film_clock.h"
#include "sim/model/interpolate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cmd {

using sim::Error;
using sim::ExitCode;

namespace {

/// Records kept: two that a frame lies between, and their neighbours.
constexpr std::size_t most_kept = 4;

/// [px] Largest error of a frame between two records.
constexpr double most_pixels = 1.0;

double radius_of(const sim::BodyDef& body) {
    const sim::Bounds box = sim::bounds(body.shape, sim::Pose{});
    return body.is_fixed() || !box.lower.allFinite()
               ? 0.0
               : box.lower.cwiseAbs().cwiseMax(box.upper.cwiseAbs()).norm();
}

} // namespace

RecordedFrames::RecordedFrames(const sim::TrajectoryReader& trajectory, const std::string& path,
                               const sim::SceneDef& scene)
    : trajectory_(trajectory), path_(path), scene_(scene) {
    for (const sim::BodyDef& body : scene.bodies) {
        radii_.push_back(radius_of(body));
    }
    const std::vector<std::int64_t>& steps = trajectory.steps();
    const std::int64_t count = sim::frame_count(scene.output.duration, scene.output.fps);
    for (std::int64_t frame = 0; frame < count; ++frame) {
        const sim::FrameInstant instant = sim::frame_instant(scene, frame);
        const double wanted = static_cast<double>(instant.step) + instant.share;
        const auto after =
            std::lower_bound(steps.begin(), steps.end(), wanted,
                             [](std::int64_t step, double x) { return static_cast<double>(step) < x; });
        if (after == steps.end()) {
            throw Error(ExitCode::usage,
                        fmt::format("{} ends at step {}, frame {} of {} shows step {}; choose a "
                                    "shorter --duration, or simulate again",
                                    path, steps.back(), frame, count, wanted));
        }
        const auto index = static_cast<std::size_t>(after - steps.begin());
        if (static_cast<double>(*after) == wanted) {
            places_.push_back({index, 0.0});
            continue;
        }
        if (index == 0) {
            throw Error(ExitCode::usage,
                        fmt::format("{} begins at step {}, frame {} shows step {}; simulate again", path,
                                    steps.front(), frame, wanted));
        }
        const auto from = static_cast<double>(steps[index - 1]);
        places_.push_back({index - 1, (wanted - from) / (static_cast<double>(*after) - from)});
        if (*after - steps[index - 1] > 1) {
            check_between(frame);
        }
    }
}

void RecordedFrames::check_between(std::int64_t frame) const {
    const std::size_t a = place(frame).before;
    const std::vector<std::int64_t>& steps = trajectory_.steps();
    const auto before = a > 0 ? record(a - 1) : nullptr;
    const auto after = a + 2 < steps.size() ? record(a + 2) : nullptr;
    const auto from = record(a), to = record(a + 1);
    const std::vector<double> errors =
        sim::interpolation_errors({before.get(), from.get(), to.get(), after.get()}, radii_);
    const sim::OutputDef& output = scene_.output;
    const render::View view = render::camera_view(render::find_camera(scene_, output.camera), *from,
                                                  static_cast<double>(output.width) / output.height);
    const sim::Vec3 forward = (view.target - view.eye).normalized();
    const double pixels_at_1_m =
        output.height / (2.0 * std::tan(view.fov_degrees * std::numbers::pi / 360.0));
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const double depth = (from->bodies[i].position - view.eye).dot(forward);
        if (errors[i] == 0.0 || !scene_.bodies[i].look.visible || depth + radii_[i] <= 0.0) {
            continue;
        }
        const double pixels = errors[i] * pixels_at_1_m / std::max(depth, radii_[i]);
        if (!(pixels <= most_pixels)) {
            throw Error(
                ExitCode::usage,
                fmt::format(
                    "{}: frame {} lies between the records of steps {} and {}, and would show '{}' wrong "
                    "by up to {:.2g} px, more than 1; choose another --fps, or simulate again with "
                    "a smaller --record-every",
                    path_, frame, steps[a], steps[a + 1], scene_.bodies[i].name, pixels));
        }
    }
}

std::shared_ptr<const sim::Snapshot> RecordedFrames::record(std::size_t index) const {
    const auto known = std::ranges::find(read_, index, [](const auto& entry) { return entry.first; });
    if (known != read_.end()) {
        return known->second;
    }
    auto snapshot = std::make_shared<const sim::Snapshot>(trajectory_.read(index));
    read_.insert(read_.begin(), {index, snapshot});
    if (read_.size() > most_kept) {
        read_.pop_back();
    }
    return snapshot;
}

std::shared_ptr<const sim::Snapshot> RecordedFrames::state(std::int64_t frame) const {
    const Place& shown = place(frame);
    const auto from = record(shown.before);
    if (shown.share == 0.0) {
        return from;
    }
    return std::make_shared<const sim::Snapshot>(
        sim::interpolated(scene_, *from, *record(shown.before + 1), shown.share));
}

} // namespace cmd
