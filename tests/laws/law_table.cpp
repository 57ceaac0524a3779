#include "tests/laws/law_table.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace laws {
namespace {

std::vector<Row>& rows() {
    static std::vector<Row> all;
    return all;
}

std::string number(double value, const char* format) {
    return std::isnan(value) ? std::string() : fmt::format(fmt::runtime(format), value);
}

} // namespace

void record(const Row& row) {
    rows().push_back(row);
}

std::string table_text() {
    std::string text =
        "| law | quantity | h [s] | error | goal | order |\n| --- | --- | --- | --- | --- | --- |\n";
    for (const Row& row : rows()) {
        text +=
            fmt::format("| {} | {} | {} | {} | {} | {} |\n", row.law, row.quantity, number(row.step, "{:g}"),
                        number(row.error, "{:.2e}"), number(row.goal, "{:.1e}"), number(row.order, "{:.2f}"));
    }
    return text;
}

} // namespace laws
