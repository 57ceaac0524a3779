#pragma once
/// What a run reports: settings as used, counts, residuals, times, energies, hash and files, as JSON.
#include "sim/base/file_io.h"
#include "sim/base/step_report.h"
#include "sim/model/scene_def.h"
#include "sim/model/snapshot.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace sim {

/// Sums over the steps of one run. Its size does not depend on their number.
struct StepTotals {
    std::int64_t steps = 0;
    std::int64_t pairs = 0;
    std::int64_t collisions = 0;
    std::int64_t contacts = 0;
    std::int64_t collision_iterations = 0;
    std::int64_t contact_iterations = 0;
    std::int64_t impacts_stopped_at = 0;
    std::int64_t divisions = 0;
    std::int64_t steps_at_iteration_limit = 0;
    std::int64_t steps_above_tolerance = 0;     ///< that end with a larger overlap than the scene's tolerance
    std::int64_t max_contacts = 0;              ///< of one step
    double square_intervals = 0.0;              ///< [s^2] sum, see interval()
    double max_energy_gain = 0.0;               ///< [-] see EnergyWatch::gain()
    double max_residual = 0.0;                  ///< [m] of contacts
    double max_joint_gap = 0.0;                 ///< [m]
    double max_penetration = 0.0;               ///< [m], geometry of the poses after each step
    std::array<double, stage_count> stage_ms{}; ///< [ms]

    /// tolerance: of the scene [m].
    void add(const StepReport& report, double tolerance);
    /// [s] Into which the steps were divided, root mean square over time; there is one step at least.
    double interval() const { return std::sqrt(square_intervals / static_cast<double>(steps)); }
};

/// One thing that a preset promises of a scene, and what was reached; NaN: not known.
struct Promise {
    const char* key;  ///< in summary.json: overlap_m
    const char* what; ///< to a reader: overlap
    const char* unit; ///< m
    double promised;  ///< at most
    double reached;
};

struct PresetResult {
    std::string preset; ///< empty: the run was asked for none
    std::vector<Promise> promises{};
};

/// What a run that was asked for an accuracy found.
struct AccuracyResult {
    struct Run {
        Rational time_step{};          ///< [s]
        double tolerance = 0.0;        ///< [m]
        double difference = 0.0;       ///< [m] from the run before, root mean square over bodies and instants
        double determined_until = 0.0; ///< [s] no body differs by more than asked up to then
        double mean_difference = 0.0;  ///< [m] largest of the common centre of mass
        std::string stopped{};         ///< why it has no motion; empty: it has
    };
    double asked = 0.0;          ///< [m]; 0: none was
    std::string outcome{};       ///< reached, chaotic, missed
    double estimate = 0.0;       ///< [m] of what is left
    double order = 0.0;          ///< of convergence [-]
    double processor_time = 0.0; ///< [s] of all runs
    std::vector<Run> runs{};
};

/// What a run that was given a time found.
struct BudgetResult {
    double asked = 0.0;     ///< [s] wall time of it all; 0: none was
    double expected = 0.0;  ///< [s] of the run
    double measuring = 0.0; ///< [s] that it took to find out, before the run
    std::string pictures{}; ///< preset chosen; empty: none was to be
};

/// Everything a run reports.
struct Summary {
    StepTotals totals;
    int threads = 1;
    double wall_time = 0.0;      ///< [s], from start to the last file but this one
    double simulated_time = 0.0; ///< [s]
    Mechanics start;
    Mechanics end;
    std::uint64_t state_hash = 0; ///< of the last state
    std::string shaders_hash;     ///< of the pictures; empty if there are none
    std::string renderer;         ///< OpenGL library; empty without pictures
    std::string processor;        ///< what the bytes of pictures depend on
    std::vector<std::pair<std::string, double>> picture_ms; ///< processor time of a frame [ms] by stage
    PresetResult preset;
    AccuracyResult accuracy;
    BudgetResult budget;
    std::vector<WrittenFile> files;
};

/// summary.json. A number that is not finite is written as null.
std::string summary_to_json(const SceneDef& scene, const Summary& summary);

/// The files that a summary lists; nothing if the text is no summary.
std::optional<std::vector<WrittenFile>> files_of_summary(const std::string& text);

/// A summary (see files_of_summary) with other files listed.
std::string summary_with_files(const std::string& text, const std::vector<WrittenFile>& files);

/// A summary whose scene has been drawn with other settings of the pictures: of `drawn`, what concerns them and the
/// files.
std::string summary_with_pictures(const std::string& text, const SceneDef& scene, const Summary& drawn);

} // namespace sim
