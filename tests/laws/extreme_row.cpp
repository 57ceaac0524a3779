#include "tests/laws/extreme_row.h"

#include "sim/base/error.h"
#include "sim/scene/bounds.h"
#include "sim/scene/overlap.h"

#include <fmt/format.h>

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>

namespace laws {
namespace {

/// Kinetic energy, and potential energy above the start [J]: no digits are lost far from the origin.
struct Energies {
    double kinetic = 0.0;
    double potential = 0.0;
};

Energies energies(const sim::SceneDef& scene, const sim::Snapshot& now) {
    Energies sum;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const sim::BodyDef& def = scene.bodies[i];
        const sim::BodySnapshot& body = now.bodies[i];
        if (!def.is_static()) {
            const Vec3 w = body.orientation.conjugate() * body.angular_velocity;
            sum.kinetic +=
                0.5 * def.mass.mass * body.velocity.squaredNorm() + 0.5 * w.dot(def.mass.inertia * w);
            sum.potential -= def.mass.mass * scene.step.gravity.dot(body.position - def.pose.position);
        }
    }
    return sum;
}

/// Energy of lifting every body by a share of its size and by a length [m] more [J].
double lift_energy(const sim::SceneDef& scene, double share, double length) {
    double sum = 0.0;
    for (const sim::BodyDef& def : scene.bodies) {
        if (!def.is_static()) {
            const sim::Bounds box = sim::bounds(def.shape, def.pose);
            sum +=
                def.mass.mass * scene.step.gravity.norm() * (share * (box.upper - box.lower).norm() + length);
        }
    }
    return sum;
}

bool is_finite(const sim::Snapshot& now) {
    return std::ranges::all_of(now.bodies, [](const sim::BodySnapshot& body) {
        return body.position.allFinite() && body.orientation.coeffs().allFinite() &&
               body.velocity.allFinite() && body.angular_velocity.allFinite();
    });
}

/// What is asked of every scene, over its run.
struct Watch {
    double overlap = 0.0; ///< [m]
    double gap = 0.0;     ///< [m] of the joints
    double gain = 0.0;    ///< [J] of energy
    double scale = 0.0;   ///< [J]
    long long unconverged = 0;
    bool finite = true;

    void look(const sim::SceneDef& scene, const sim::Snapshot& now, double at_start) {
        const Energies energy = energies(scene, now);
        finite = finite && is_finite(now);
        scale = std::max(scale, energy.kinetic);
        gain = std::max(gain, energy.kinetic + energy.potential - at_start);
        overlap = std::max(overlap, largest_overlap(scene, now));
        gap = std::max(gap, scene.joints.empty() ? 0.0 : largest_joint_gap(scene, now));
    }
};

std::vector<Finding> run_case(const ExtremeCase& extreme) {
    const sim::SceneDef& scene = extreme.scene;
    sim::World world(scene);
    const sim::Snapshot first = world.take_snapshot();
    const double at_start = energies(scene, first).kinetic;
    Watch watch;
    watch.scale = std::max(lift_energy(scene, 0.1, 0.0), at_start);
    for (long long step = 1; step <= extreme.steps; ++step) {
        watch.unconverged += world.step().at_iteration_limit ? 1 : 0;
        if (step % extreme.check_every == 0 || step == extreme.steps) {
            watch.look(scene, world.take_snapshot(), at_start);
        }
    }
    const double allowed = lift_energy(scene, 0.0, scene.step.tolerance); // gaps are as wide as the tolerance
    std::vector<Finding> all{{"overlap [m]", watch.overlap, scene.step.tolerance},
                             {"gain of energy [-]", watch.scale > 0.0 ? watch.gain / watch.scale : 0.0,
                              extreme.energy_gain + (watch.scale > 0.0 ? allowed / watch.scale : 0.0)},
                             {"steps not converged", static_cast<double>(watch.unconverged), 0.0}};
    if (!watch.finite) {
        all.push_back({"states that are no numbers", 1.0, 0.0});
    }
    if (!scene.joints.empty()) {
        all.push_back({"gap of a joint [m]", watch.gap, scene.step.joint_tolerance});
    }
    if (extreme.law) {
        for (const Finding& finding : extreme.law(first, world.take_snapshot())) {
            all.push_back(finding);
        }
    }
    return all;
}

/// In the child: the outcome's digit, then what was measured.
std::string measure(const ExtremeRow& row) {
    const auto line = [](Outcome outcome, const std::string& text) {
        return std::to_string(static_cast<int>(outcome)) + text;
    };
    try {
        const ExtremeCase extreme = row.make_case();
        if (const auto excess = sim::find_excess(extreme.scene)) {
            return line(Outcome::refused, excess->message);
        }
        if (const auto overlap = sim::find_start_overlap(extreme.scene)) {
            return line(Outcome::refused,
                        fmt::format("bodies overlap by {:.3g} m at the start, expected at most "
                                    "the tolerance, {:g} m",
                                    overlap->penetration, extreme.scene.step.tolerance));
        }
        std::string text;
        bool good = true;
        for (const Finding& finding : run_case(extreme)) {
            good = good && finding.is_good();
            text += fmt::format("{}{}{} {:.3g}{}", text.empty() ? "" : ", ", finding.is_good() ? "" : "**",
                                finding.quantity, finding.value,
                                finding.is_good() ? "" : fmt::format(" > {:.3g}**", finding.bound));
        }
        return line(good ? Outcome::kept : Outcome::fell_short, text);
    } catch (const sim::Error& error) {
        return line(error.code() == sim::ExitCode::stopped ? Outcome::stopped : Outcome::fell_short,
                    error.what());
    }
}

/// Sets limits of processor time and memory, measures, writes to `pipe` and ends.
[[noreturn]] void be_child(const ExtremeRow& row, int pipe) {
    const rlimit time{static_cast<rlim_t>(row.seconds), static_cast<rlim_t>(row.seconds) + 1};
    const rlimit memory{rlim_t{4} << 30, rlim_t{4} << 30};
    setrlimit(RLIMIT_CPU, &time);
    setrlimit(RLIMIT_AS, &memory);
    std::string text;
    try {
        text = measure(row);
    } catch (const std::exception& error) {
        text = std::to_string(static_cast<int>(Outcome::fell_short)) + error.what();
    }
    const bool is_written = write(pipe, text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(is_written ? 0 : 1);
}

} // namespace

sim::SceneDef usual_scene(Rational h) {
    sim::SceneDef scene;
    scene.name = "extreme";
    scene.step.time_step = h;
    return scene;
}

double drift(const sim::Snapshot& first, const sim::Snapshot& last) {
    double largest = 0.0;
    for (std::size_t i = 0; i < first.bodies.size(); ++i) {
        largest = std::max(largest, (last.bodies[i].position - first.bodies[i].position).norm());
    }
    return largest;
}

Law stays(double bound) {
    return [bound](const sim::Snapshot& first, const sim::Snapshot& last) {
        return std::vector<Finding>{{"drift [m]", drift(first, last), bound}};
    };
}

std::string power(double value) {
    std::string text = fmt::format("{:.0e}", value); // 1e-04
    std::erase(text, '+');
    std::ranges::replace(text, '-', 'm');
    return text;
}

Verdict judge(const ExtremeRow& row) {
    std::array<int, 2> pipes{};
    if (pipe(pipes.data()) != 0) {
        return {Outcome::fell_short, "no pipe", 0.0};
    }
    const pid_t child = fork();
    if (child == 0) {
        close(pipes[0]);
        be_child(row, pipes[1]);
    }
    close(pipes[1]);
    std::string text;
    std::array<char, 4096> buffer{};
    for (ssize_t count; (count = read(pipes[0], buffer.data(), buffer.size())) > 0;) {
        text.append(buffer.data(), static_cast<std::size_t>(count));
    }
    close(pipes[0]);
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    const double seconds =
        static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
    if (WIFSIGNALED(status)) {
        const bool hung = WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL;
        return {Outcome::fell_short,
                hung ? fmt::format("**not done after {} s of processor time**", row.seconds)
                     : fmt::format("**ended by signal {}**", WTERMSIG(status)),
                seconds};
    }
    if (text.empty()) {
        return {Outcome::fell_short, "**ended without a word**", seconds};
    }
    return {static_cast<Outcome>(text[0] - '0'), text.substr(1), seconds};
}

} // namespace laws
