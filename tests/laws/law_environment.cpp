/// Writes the table of all laws at the end of the program, if TUMBLE_LAW_TABLE names a file for it.
#include "tests/laws/law_table.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

namespace {

class TableAtEnd : public ::testing::Environment {
public:
    void TearDown() override {
        const char* path = std::getenv("TUMBLE_LAW_TABLE");
        if (path) {
            std::ofstream file(path);
            file << laws::table_text() << std::flush;
            EXPECT_TRUE(file.good()) << "cannot write " << path;
        }
    }
};

[[maybe_unused]] const ::testing::Environment* const table_at_end =
    ::testing::AddGlobalTestEnvironment(new TableAtEnd);

} // namespace
