#pragma once
/// The table of all laws: one row a case, quantity and step size.
#include <limits>
#include <string>

namespace laws {

inline constexpr double no_value = std::numeric_limits<double>::quiet_NaN();

struct Row {
    std::string law;
    std::string quantity;    ///< with its unit, or "relative"
    double step = no_value;  ///< h [s]
    double error = no_value; ///< or the measured value where there is no error
    double goal = no_value;  ///< bound on it; none: only stated
    double order = no_value; ///< observed, in the row of the smallest step
};

/// Adds a row. Not for several threads.
void record(const Row& row);

/// Writes all rows so far, in the order of their recording, as a Markdown table.
std::string table_text();

} // namespace laws
