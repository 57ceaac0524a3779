#pragma once
/// Where tests write: a folder of this run's own, so that several runs in one checkout do not touch each other's files.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <system_error>
#include <unistd.h>

namespace test {

/// out/test/PID, with `name` in it. It goes at the end of the process if all tests have passed; TUMBLE_KEEP=1 keeps it.
inline std::filesystem::path out_folder(const std::string& name) {
    struct Folder {
        pid_t owner = ::getpid(); // a child of this process removes nothing
        std::filesystem::path path = std::filesystem::path(TUMBLE_OUT_DIR) / "test" / std::to_string(owner);

        Folder() { testing::UnitTest::GetInstance(); } // made first, gone last
        ~Folder() {
            if (owner == ::getpid() && testing::UnitTest::GetInstance()->Passed() &&
                std::getenv("TUMBLE_KEEP") == nullptr) {
                std::error_code ignored; // what stays is in out/
                std::filesystem::remove_all(path, ignored);
            }
        }
    };
    static const Folder folder;
    return folder.path / name;
}

/// An empty folder of this test's own, in out_folder(name).
inline std::filesystem::path fresh_folder(const std::string& name) {
    const std::filesystem::path folder = out_folder(name) / testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return folder;
}

} // namespace test
