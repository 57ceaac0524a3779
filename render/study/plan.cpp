#include "render/study/plan.h"

#include "sim/base/error.h"
#include "sim/scene/file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <numeric>

namespace study {

namespace {

using sim::Error;
using sim::ExitCode;
using sim::Rational;

constexpr double wanted_instants = 100.0; // enough to see every swing of the scenes studied

/// Letters and digits of a text, _ for the rest.
std::string file_word(const std::string& text) {
    std::string word;
    for (const char c : text) {
        word += std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-' ? c : '_';
    }
    return word;
}

std::vector<std::string> seed_override(const sim::StudyDef& def, int seed) {
    return def.seed_key.empty()
               ? std::vector<std::string>{}
               : std::vector<std::string>{fmt::format("{}={}", def.seed_key, seed + 1)};
}

/// Fills in what follows from the settings; a scene that is refused keeps the reason.
void resolve(const Plan& plan, const Request& request, Task& task) {
    task.overrides = request.overrides;
    for (const std::vector<std::string>& more : {seed_override(plan.def, task.seed), task.setting.overrides}) {
        task.overrides.insert(task.overrides.end(), more.begin(), more.end());
    }
    try {
        task.time_step = scene_of(plan, task).step.time_step;
    } catch (const Error& error) {
        task.refusal = error.what();
    }
}

/// The finest settings that the scene allows: a quarter of the finest time step, a hundredth of the tolerances. Where errors are
/// statistical, half the scene's time step and a tenth of its tolerances: means over seeds do not tell finer ones.
Setting reference_setting(const Plan& plan, const Request& request, const Rational& finest) {
    const sim::StepSettings& step = plan.scene.step;
    const std::string h = plan.is_statistical()
                              ? fraction_text(sim::make_rational(step.time_step.num, 2 * step.time_step.den))
                              : fraction_text(sim::make_rational(finest.num, 4 * finest.den));
    for (const double factor : plan.is_statistical() ? std::vector{0.1, 1.0} : std::vector{0.01, 0.1, 1.0}) {
        Setting setting{fmt::format("{} s, tolerance {:.2g} m", h, factor * step.tolerance),
                        {fmt::format("simulation.time_step=\"{}\"", h),
                         fmt::format("simulation.tolerance={}", factor * step.tolerance),
                         fmt::format("simulation.velocity_tolerance={}", factor * step.velocity_tolerance),
                         fmt::format("simulation.iteration_limit={}",
                                     std::max<std::int64_t>(10000, step.iteration_limit))},
                        ""};
        if (!plan.is_statistical()) {
            setting.overrides.emplace_back("simulation.impacts=\"stop\"");
        }
        Task task{.setting = setting};
        resolve(plan, request, task);
        if (task.refusal.empty() || factor == 1.0) {
            return setting;
        }
    }
    return {};
}

Rational common_multiple(const Rational& a, const Rational& b) {
    return sim::make_rational(std::lcm(a.num, b.num), std::gcd(a.den, b.den));
}

void choose_instants(Plan& plan) {
    Rational common;
    for (const std::vector<Task>* tasks : {&plan.tasks, &plan.references}) {
        for (const Task& task : *tasks) {
            if (task.refusal.empty()) {
                common = common.num == 0 ? task.time_step : common_multiple(common, task.time_step);
            }
        }
    }
    const double duration = plan.scene.output.duration.value();
    if (common.num <= 0 || common.value() > duration / 4) {
        throw Error(ExitCode::usage,
                    fmt::format("{}: the duration of {} s is too short for the time steps studied: their "
                                "common multiple is {} s, expected at most a quarter of it",
                                plan.scene.name, duration, common.value()));
    }
    const auto times = std::max<std::int64_t>(
        1, static_cast<std::int64_t>(duration / wanted_instants / common.value()));
    plan.spacing = sim::make_rational(common.num * times, common.den);
    plan.count = 1 + static_cast<int>(duration / plan.spacing.value() * (1 + 1e-12));
    for (std::vector<Task>* tasks : {&plan.tasks, &plan.references}) {
        for (Task& task : *tasks) {
            if (task.refusal.empty()) {
                const auto steps = sim::step_count(plan.spacing, task.time_step);
                task.steps = steps * (plan.count - 1);
            }
        }
    }
}

void check_knobs(const Request& request, const std::vector<std::string>& names) {
    for (const std::string& knob : request.knobs) {
        if (std::find(names.begin(), names.end(), knob) == names.end()) {
            throw Error(ExitCode::usage,
                        fmt::format("there is no knob '{}', expected {}", knob, fmt::join(names, ", ")));
        }
    }
}

void add_tasks(const Request& request, std::span<const EngineKind> engines, Plan& plan) {
    std::vector<std::string> names;
    const auto add = [&](int engine, const Knob& knob, const Setting& setting) {
        for (int seed = 0; seed < plan.seeds; ++seed) {
            Task task{.engine = engine, .knob = knob.name, .setting = setting};
            task.starts_at_base = knob.starts_at_base;
            task.seed = seed;
            task.name = file_word(fmt::format("{}-{}-{}-{}", engines[static_cast<std::size_t>(engine)].name,
                                              knob.name.empty() ? "base" : knob.name, setting.value, seed + 1));
            resolve(plan, request, task);
            plan.tasks.push_back(std::move(task));
        }
    };
    for (std::size_t e = 0; e < engines.size(); ++e) {
        const EngineKind& kind = engines[e];
        add(static_cast<int>(e), {}, kind.base);
        for (const Knob& knob : kind.knobs(plan.scene)) {
            names.push_back(knob.name);
            if (request.knobs.empty() ||
                std::find(request.knobs.begin(), request.knobs.end(), knob.name) != request.knobs.end()) {
                for (const Setting& setting : knob.settings) {
                    add(static_cast<int>(e), knob, setting);
                }
            }
        }
    }
    check_knobs(request, names);
}

void add_references(const Request& request, Plan& plan) {
    Rational finest = plan.scene.step.time_step;
    for (const Task& task : plan.tasks) {
        if (task.refusal.empty() && task.time_step.value() < finest.value()) {
            finest = task.time_step;
        }
    }
    const Setting setting = reference_setting(plan, request, finest);
    for (int seed = 0; seed < plan.seeds; ++seed) {
        Task task{.name = fmt::format("reference-{}", seed + 1), .knob = "reference", .setting = setting};
        task.seed = seed;
        resolve(plan, request, task);
        if (!task.refusal.empty()) {
            throw Error(ExitCode::usage, task.refusal);
        }
        plan.references.push_back(std::move(task));
    }
}

} // namespace

std::vector<double> Plan::times() const {
    std::vector<double> all;
    for (int k = 0; k < count; ++k) {
        all.push_back(k * spacing.value());
    }
    return all;
}

sim::SceneDef scene_of(const Plan& plan, const Task& task) {
    return sim::load_scene(plan.scene_file, task.overrides);
}

Plan make_plan(const Request& request, std::span<const EngineKind> engines) {
    Plan plan;
    plan.scene_file = request.scene;
    plan.scene = sim::load_scene(request.scene, request.overrides);
    plan.def = sim::study_of(plan.scene);
    plan.seeds = plan.is_statistical() ? request.seeds : 1;
    add_tasks(request, engines, plan);
    if (plan.def.law == sim::Law::none) {
        add_references(request, plan);
    }
    choose_instants(plan);
    return plan;
}

} // namespace study
