#pragma once
/// Runs the built program in a folder of the test's own, on a scene of eight small frames.
#include "render/film/film.h"
#include "sim/base/file_io.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <string>
#include <sys/wait.h>

namespace test {

namespace fs = std::filesystem;

/// A block falls on the floor: 8 frames, of which the first is the start.
inline constexpr const char* scene_text = R"(title = "A block falls"
[output]
width = 320
height = 180
duration = 0.4
fps = 20
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[body]]
name = "block"
shape = { kind = "box", half_extents = [0.5, 0.5, 0.5] }
density = 1000
position = [0, 0, 0.9]
angular_velocity = [1, 2, 3]
)";
inline constexpr int frame_count = 8;

/// Is the program built with sanitizers? It is slow then, and their own memory is beyond any limit.
inline constexpr bool has_sanitizer = TUMBLE_SANITIZED;

struct Outcome {
    int code = -1;
    std::string out;
    std::string err;
};

class Program : public testing::Test {
protected:
    fs::path folder;

    void SetUp() override {
        folder = out_folder("program") /
                 testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        fs::create_directories(folder);
        sim::write_file(folder / "block.toml", std::string(scene_text));
    }

    /// Runs shell commands in the test's folder; "$TUMBLE" is the program.
    Outcome shell(const std::string& commands) const {
        sim::write_file(folder / "commands.sh",
                        "cd '" + folder.string() + "'\nTUMBLE='" TUMBLE_PROGRAM "'\nunset CI\n" + commands);
        const std::string file = (folder / "commands.sh").string();
        const std::string out = (folder / "stdout.txt").string();
        const std::string err = (folder / "stderr.txt").string();
        const int status = std::system(("bash '" + file + "' >'" + out + "' 2>'" + err + "'").c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, sim::read_text_file(out),
                sim::read_text_file(err)};
    }

    Outcome tumble(const std::string& arguments) const { return shell("\"$TUMBLE\" " + arguments); }

    std::string bytes(const fs::path& name) const { return sim::read_text_file(folder / name); }

    /// Paths of all files in a folder, relative to it.
    std::set<std::string> files_in(const fs::path& name) const {
        std::set<std::string> names;
        if (fs::exists(folder / name)) {
            for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder / name)) {
                if (entry.is_regular_file()) {
                    names.insert(fs::relative(entry.path(), folder / name).string());
                }
            }
        }
        return names;
    }

    std::set<std::string> expected_files() const {
        std::set<std::string> names{"block.mp4", "trajectory.h5", "summary.json", "frames/run.json"};
        for (int k = 0; k < frame_count; ++k) {
            names.insert(render::frame_file_name(k));
        }
        return names;
    }
};

inline void expect_one_line(const std::string& text) {
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
}

} // namespace test
