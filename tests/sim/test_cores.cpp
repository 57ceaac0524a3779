#include "sim/base/cores.h"

#include "sim/base/file_io.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

using namespace sim;
namespace fs = std::filesystem;

/// A tree of control groups as Linux shows it: those of a container may have no file for what lies outside of it.
TEST(cores, a_quota_of_a_control_group_or_of_one_that_holds_it_limits_them) {
    const fs::path root = test::fresh_folder("cores");
    const fs::path own = root / "self";
    const auto put = [&](const std::string& group, const std::string& text) {
        fs::create_directories(root / group);
        write_file(root / group / "cpu.max", text);
    };
    constexpr double none = std::numeric_limits<double>::infinity();
    EXPECT_EQ(cpu_quota(own, root), none);
    write_file(own, std::string("4:memory:/outer\n0::/outer/inner\n"));
    EXPECT_EQ(cpu_quota(own, root), none);
    put("outer", "250000 100000\n");
    EXPECT_EQ(cpu_quota(own, root), 2.5);
    put("outer/inner", "max 100000\n");
    EXPECT_EQ(cpu_quota(own, root), 2.5);
    put("outer/inner", "50000 100000\n");
    EXPECT_EQ(cpu_quota(own, root), 0.5);
    put("", "10000 100000\n");
    EXPECT_EQ(cpu_quota(own, root), 0.1);
    write_file(own, std::string("0::/\n"));
    EXPECT_EQ(cpu_quota(own, root), 0.1);
    write_file(own, std::string("0::/../elsewhere\n"));
    EXPECT_EQ(cpu_quota(own, root), 0.1);
}

TEST(cores, there_is_one) {
    EXPECT_GE(core_count(), 1);
}
