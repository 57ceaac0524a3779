/// The matrix of extremes, one test a row. With TUMBLE_EXTREMES_TABLE all rows run and the table is written
/// there after each; without it the quick ones alone.
#include "tests/laws/extreme_row.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace {

using namespace laws;

const char* table_path() {
    return std::getenv("TUMBLE_EXTREMES_TABLE");
}

std::vector<ExtremeRow> chosen_rows() {
    std::vector<ExtremeRow> rows = extreme_rows();
    if (table_path() == nullptr) {
        std::erase_if(rows, [](const ExtremeRow& row) { return !row.is_quick; });
    }
    return rows;
}

/// Appends the row; the first one begins the table anew.
void write_row(const ExtremeRow& row, const Verdict& verdict) {
    static bool is_begun = false;
    std::ofstream file(table_path(), is_begun ? std::ios::app : std::ios::trunc);
    if (!is_begun) {
        file << "| extreme | promised | found | measured | CPU [s] |\n| --- | --- | --- | --- | --- |\n";
    }
    is_begun = true;
    constexpr const char* outcomes[] = {"kept", "refused", "stopped", "**fell short**"};
    file << fmt::format("| {} | {} | {} | {} | {:.1f} |\n", row.name,
                        row.promise == Promise::kept ? "kept" : "kept, refused or stopped",
                        outcomes[static_cast<int>(verdict.outcome)], verdict.measured, verdict.seconds);
    EXPECT_TRUE(file.flush().good()) << "cannot write " << table_path();
}

class extreme : public ::testing::TestWithParam<ExtremeRow> {};

TEST_P(extreme, row_keeps_its_promise) {
    const Verdict verdict = judge(GetParam());
    if (table_path() != nullptr) {
        write_row(GetParam(), verdict);
    }
    EXPECT_NE(verdict.outcome, Outcome::fell_short) << verdict.measured;
    if (GetParam().promise == Promise::kept) {
        EXPECT_EQ(verdict.outcome, Outcome::kept) << verdict.measured;
    }
}

INSTANTIATE_TEST_SUITE_P(law, extreme, ::testing::ValuesIn(chosen_rows()),
                         [](const auto& row) { return row.param.name; });

} // namespace
