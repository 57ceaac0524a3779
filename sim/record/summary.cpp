#include "sim/record/summary.h"
#include "sim/scene/model.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace sim {

namespace {

// Keys stay in the order written: the file is read by people too.
using Json = nlohmann::ordered_json;

Json to_json(const Vec3& v) {
    return {v.x(), v.y(), v.z()};
}

std::string to_text(const Rational& r) {
    return r.den == 1 ? fmt::format("{}", r.num) : fmt::format("{}/{}", r.num, r.den);
}

Json settings_json(const SceneDef& scene, int threads) {
    const StepSettings& step = scene.step;
    const OutputDef& output = scene.output;
    return {{"time_step_s", step.time_step.value()},
            {"time_step", to_text(step.time_step)},
            {"gravity_m_s2", to_json(step.gravity)},
            {"tolerance_m", step.tolerance},
            {"joint_tolerance_m", step.joint_tolerance},
            {"velocity_tolerance_m_s", step.velocity_tolerance},
            {"resting_distance_m", step.resting_distance},
            {"resting_speed_floor_m_s", step.resting_speed_floor},
            {"iteration_limit", step.iteration_limit},
            {"impacts", impact_handling(scene) == ImpactHandling::stop ? "stop" : "ahead"},
            {"warm_start", step.warm_start},
            {"threads", threads},
            {"width_px", output.width},
            {"height_px", output.height},
            {"smooth_edges", output.smooth_edges},
            {"soft_shadows", output.soft_shadows},
            {"ambient_occlusion", output.ambient_occlusion},
            {"shadow_size_px", output.shadow_size},
            {"crf", output.crf},
            {"effort", output.effort},
            {"encoder", output.encoder},
            {"bits", output.bits},
            {"gl", output.gl},
            {"shutter", output.shutter},
            {"subframes", output.subframes},
            {"fps", to_text(output.fps)},
            {"duration_s", output.duration.value()},
            {"record_every", output.record_every},
            {"camera", output.camera},
            {"overrides", scene.overrides}};
}

Json mechanics_json(const Mechanics& m) {
    return {{"kinetic_energy_J", m.kinetic_energy},
            {"potential_energy_J", m.potential_energy},
            {"energy_J", m.kinetic_energy + m.potential_energy},
            {"momentum_N_s", to_json(m.momentum)},
            {"angular_momentum_N_m_s", to_json(m.angular_momentum)}};
}

Json preset_json(const PresetResult& result) {
    Json promised, reached;
    for (const Promise& promise : result.promises) {
        promised[promise.key] = promise.promised;
        reached[promise.key] = promise.reached;
    }
    return {{"name", result.preset}, {"promised", promised}, {"reached", reached}};
}

Json accuracy_json(const AccuracyResult& result) {
    Json runs = Json::array();
    for (const AccuracyResult::Run& run : result.runs) {
        runs.push_back({{"time_step", to_text(run.time_step)},
                        {"tolerance_m", run.tolerance},
                        {"difference_m", run.difference},
                        {"determined_until_s", run.determined_until},
                        {"mean_difference_m", run.mean_difference},
                        {"stopped", run.stopped}});
    }
    return {{"asked_m", result.asked},     {"outcome", result.outcome},
            {"estimate_m", result.estimate}, {"order", result.order},
            {"processor_time_s", result.processor_time}, {"runs", runs}};
}

Json files_json(const std::vector<WrittenFile>& files) {
    Json json = Json::array();
    for (const WrittenFile& file : files) {
        json.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
    }
    return json;
}

/// Bytes that are no UTF-8 (a file name) are replaced: dump() would throw.
std::string text_of(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// What a summary says of the pictures.
void set_pictures(Json& json, const Summary& summary) {
    Json stages = Json::object();
    for (const auto& [stage, ms] : summary.picture_ms) {
        stages[stage] = ms;
    }
    json["shaders_hash"] = summary.shaders_hash;
    json["renderer"] = summary.renderer;
    json["processor"] = summary.processor;
    json["picture_ms_per_frame"] = stages;
    json["files"] = files_json(summary.files);
}

} // namespace

void StepTotals::add(const StepReport& report, double tolerance) {
    ++steps;
    pairs += report.pairs;
    collisions += report.collisions;
    contacts += report.contacts;
    collision_iterations += report.collision_iterations;
    contact_iterations += report.contact_iterations;
    impacts_stopped_at += report.impacts_stopped_at;
    divisions += report.divisions;
    square_intervals += report.interval * report.interval;
    steps_at_iteration_limit += report.at_iteration_limit ? 1 : 0;
    steps_above_tolerance += report.max_penetration > tolerance ? 1 : 0;
    max_contacts = std::max<std::int64_t>(max_contacts, report.contacts);
    max_energy_gain = std::max(max_energy_gain, report.energy_gain);
    max_residual = std::max(max_residual, report.residual);
    max_joint_gap = std::max(max_joint_gap, report.joint_gap);
    max_penetration = std::max(max_penetration, report.max_penetration);
    for (int i = 0; i < stage_count; ++i) {
        stage_ms[i] += report.stage_ms[i];
    }
}

std::string summary_to_json(const SceneDef& scene, const Summary& summary) {
    const StepTotals& totals = summary.totals;
    const auto per_step = [&totals](double sum) { return sum / std::max<double>(1.0, double(totals.steps)); };
    Json stages = Json::object();
    for (int i = 0; i < stage_count; ++i) {
        stages[stage_names[i]] = per_step(totals.stage_ms[i]);
    }
    Json json = {{"program", "tumble " TUMBLE_VERSION},
                 {"scene", scene.name},
                 {"title", scene.title},
                 {"bodies", scene.bodies.size()},
                 {"joints", scene.joints.size()},
                 {"settings", settings_json(scene, summary.threads)},
                 {"steps", totals.steps},
                 {"simulated_time_s", summary.simulated_time},
                 {"wall_time_s", summary.wall_time},
                 {"stage_ms_per_step", stages},
                 {"pairs_per_step", per_step(double(totals.pairs))},
                 {"collisions_per_step", per_step(double(totals.collisions))},
                 {"contacts_per_step", per_step(double(totals.contacts))},
                 {"max_contacts", totals.max_contacts},
                 {"iterations_per_step", per_step(double(totals.contact_iterations))},
                 {"collision_iterations_per_step", per_step(double(totals.collision_iterations))},
                 {"steps_at_iteration_limit", totals.steps_at_iteration_limit},
                 {"steps_above_tolerance", totals.steps_above_tolerance},
                 {"impacts_stopped_at", totals.impacts_stopped_at},
                 {"divisions", totals.divisions},
                 {"max_energy_gain", totals.max_energy_gain},
                 {"max_residual_m", totals.max_residual},
                 {"max_joint_gap_m", totals.max_joint_gap},
                 {"max_penetration_m", totals.max_penetration},
                 {"start", mechanics_json(summary.start)},
                 {"end", mechanics_json(summary.end)},
                 {"state_hash", fmt::format("{:016x}", summary.state_hash)}};
    set_pictures(json, summary);
    if (!summary.preset.preset.empty()) {
        json["preset"] = preset_json(summary.preset);
    }
    if (summary.accuracy.asked > 0.0) {
        json["accuracy"] = accuracy_json(summary.accuracy);
    }
    if (const BudgetResult& budget = summary.budget; budget.asked > 0.0) {
        json["budget"] = {{"asked_s", budget.asked},
                          {"expected_s", budget.expected},
                          {"measuring_s", budget.measuring},
                          {"pictures", budget.pictures}};
    }
    return text_of(json);
}

std::optional<std::vector<WrittenFile>> files_of_summary(const std::string& text) {
    const Json json = Json::parse(text, nullptr, false);
    try {
        std::vector<WrittenFile> files;
        for (const Json& file : json.at("files")) {
            files.push_back({file.at("name"), file.at("bytes"), file.at("sha256")});
        }
        json.at("settings").at("threads").get<int>();
        return files;
    } catch (const Json::exception&) {
        return std::nullopt;
    }
}

std::string summary_with_files(const std::string& text, const std::vector<WrittenFile>& files) {
    Json json = Json::parse(text);
    json["files"] = files_json(files);
    return text_of(json);
}

std::string summary_with_pictures(const std::string& text, const SceneDef& scene, const Summary& drawn) {
    Json json = Json::parse(text);
    json["settings"] = settings_json(scene, json.at("settings").at("threads"));
    set_pictures(json, drawn);
    return text_of(json);
}

} // namespace sim
