#include "render/study/promise.h"

#include "sim/scene/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace study {

namespace {

/// [-] of the height of the first fall, by preset: three times what a study finds, and rounding.
constexpr std::array<double, sim::preset_count> bounce_heights{1e-3, 5e-4, 1e-9};

std::string figure(double value, const char* unit) {
    return std::isfinite(value) ? fmt::format("{:.2g}{}{}", value, *unit != '\0' ? " " : "", unit) : "-";
}

} // namespace

std::vector<sim::Promise> promises_of(const sim::SceneDef& scene, Preset preset, const Reached& reached) {
    const auto index = static_cast<std::size_t>(preset);
    const sim::StudyDef def = sim::study_of(scene);
    const bool is_known = !def.promises.empty();
    const double tolerance = scene.step.tolerance;
    std::vector<sim::Promise> all{
        {"error", "error", def.seed_key.empty() ? "m" : "", is_known ? def.promises[index].x() : Reached::unknown,
         reached.error.rms},
        {"cost_s_per_s", "cost", "s/s", is_known ? def.promises[index].y() : Reached::unknown, reached.cost},
        {"overlap_m", "overlap", "m", tolerance, reached.overlap}};
    if (def.law == sim::Law::tower) {
        all.push_back({"moved_m", "moved while at rest", "m", tolerance, reached.error.largest});
    }
    if (def.law == sim::Law::bouncing_ball) {
        all.push_back({"bounce_heights", "bounce heights", "", bounce_heights[index], reached.error.heights});
    }
    return all;
}

std::string promises_text(const std::vector<sim::Promise>& promises) {
    std::string text;
    for (const sim::Promise& promise : promises) {
        const bool is_first = text.empty();
        text += fmt::format("{}{} {} ({}{})", is_first ? "" : ", ", promise.what, figure(promise.reached, promise.unit),
                            is_first ? "promised " : "", figure(promise.promised, promise.unit));
    }
    return text;
}

bool is_kept(const sim::Promise& promise) {
    const bool depends = std::string_view(promise.key) == "cost_s_per_s";
    return depends || !(promise.reached > promise.promised); // what is not known is not missed
}

std::vector<std::pair<Preset, std::vector<sim::Promise>>> preset_promises(const Plan& plan, const Table& table) {
    std::vector<std::pair<Preset, std::vector<sim::Promise>>> all;
    for (const Row& row : table.rows) {
        const auto preset = row.knob == "preset" ? find_preset(row.value) : std::optional(Preset::standard);
        const bool is_preset = row.knob.empty() || row.knob == "preset";
        if (!is_preset || row.engine != table.rows.front().engine || row.status != Status::done) {
            continue;
        }
        Reached reached;
        reached.error.rms = row.error;
        reached.error.largest = row.largest;
        reached.error.heights = row.heights;
        reached.cost = row.cost;
        reached.overlap = row.overlap;
        const sim::SceneDef scene = scene_of(plan, plan.tasks[static_cast<std::size_t>(row.task)]);
        all.emplace_back(*preset, promises_of(scene, *preset, reached));
    }
    std::ranges::sort(all, {}, [](const auto& one) { return one.first; });
    return all;
}

std::string promises_csv(const Plan& plan, const Table& table) {
    std::string csv = "preset,promise,unit,promised,reached,kept\n";
    for (const auto& [preset, promises] : preset_promises(plan, table)) {
        for (const sim::Promise& promise : promises) {
            csv += fmt::format("{},{},{}", preset_names[static_cast<std::size_t>(preset)], promise.what, promise.unit);
            for (const double value : {promise.promised, promise.reached}) {
                csv += std::isfinite(value) ? fmt::format(",{:.6g}", value) : ",";
            }
            csv += is_kept(promise) ? ",1\n" : ",0\n";
        }
    }
    return csv;
}

} // namespace study
