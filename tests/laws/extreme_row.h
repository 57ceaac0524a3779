#pragma once
/// Rows of the matrix of extremes: a scene, what is promised of it, and how it is judged.
#include "tests/laws/law_scene.h"

#include <functional>
#include <ostream>
#include <string>
#include <vector>

namespace laws {

/// A quantity and the bound it must keep.
struct Finding {
    std::string quantity; ///< with its unit
    double value = 0.0;
    double bound = 0.0;
    bool is_good() const { return value <= bound; } ///< NaN is not
};

/// Adds what the row alone promises, from the first state and the last.
using Law = std::function<std::vector<Finding>(const sim::Snapshot& first, const sim::Snapshot& last)>;

/// A scene to run, and what is asked of it beside what is asked of all: numbers, overlaps within the
/// tolerance, joints closed, energy that does not grow.
struct ExtremeCase {
    sim::SceneDef scene;
    long long steps = 1000;
    long long check_every = 10; ///< steps between two looks
    double energy_gain = 1e-6;  ///< [-] bound on it beside a lift by the tolerance, relative to the
                                ///< largest kinetic energy or a fall by a tenth of all sizes
    Law law = {};               ///< may be empty
};

enum class Promise {
    kept,            ///< runs, and is right
    kept_or_refused, ///< may be refused before the first step, or stopped, with the reason named
};

struct ExtremeRow {
    std::string name; ///< a test's name: letters, digits, _
    Promise promise = Promise::kept;
    bool is_quick = false; ///< runs in `./run test` too: cheap, and keeps its promise
    int seconds = 20;      ///< of processor time, after which the row has hung
    std::function<ExtremeCase()> make_case;
};

/// How GoogleTest names it.
inline void PrintTo(const ExtremeRow& row, std::ostream* out) {
    *out << row.name;
}

/// Settings as a scene has them that says nothing of them.
sim::SceneDef usual_scene(Rational h = microseconds(1000));
/// How far any body is from where it began [m].
double drift(const sim::Snapshot& first, const sim::Snapshot& last);
/// Bodies begin at rest and stay where they are, to `bound` [m].
Law stays(double bound);
/// 1e-4 -> "1em04".
std::string power(double value);

/// All rows, in the order of the table.
std::vector<ExtremeRow> extreme_rows();

/// The parts of the table. Each appends its rows.
void add_settings_rows(std::vector<ExtremeRow>& rows);  ///< masses, steps, surfaces, gravity, sizes, places
void add_motion_rows(std::vector<ExtremeRow>& rows);    ///< spins and speeds
void add_structure_rows(std::vector<ExtremeRow>& rows); ///< many bodies, joints, alignment, many steps
void add_number_rows(std::vector<ExtremeRow>& rows);    ///< quantities near the ends of the range of numbers

enum class Outcome { kept, refused, stopped, fell_short };

struct Verdict {
    Outcome outcome = Outcome::fell_short;
    std::string measured; ///< one line
    double seconds = 0.0; ///< of processor time
};

/// Runs a row in a process of its own, so that neither a crash nor a hang harms the others.
Verdict judge(const ExtremeRow& row);

} // namespace laws
