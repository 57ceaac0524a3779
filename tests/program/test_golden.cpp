/// The pictures that somebody has looked at and accepted: the start and a few early frames of each scene, and
/// each feature of the shaders. After a change of the look that is meant:
///     build/tumble baseline update scenes/*.toml tests/golden/features.toml --baselines tests/golden
#include "tests/program/program_fixture.h"

#include <sstream>

namespace fs = std::filesystem;

class golden : public test::Program {
protected:
    /// What else can draw here: in software the same bytes as out/baselines has, graphics cards the same but for noise.
    void expect_the_same_of_other_devices(const std::string& check) const {
        std::istringstream devices(tumble("devices").out);
        for (std::string line; std::getline(devices, line);) {
            const std::string word = line.substr(0, line.find(' '));
            if (line.ends_with("; auto takes it") || line.find("; ") == std::string::npos) {
                continue;
            }
            const test::Outcome outcome = tumble(check + " --gl " + word + " --report " + word);
            EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
            const std::set<std::string> pictures = files_in("out/baselines/candidates");
            EXPECT_EQ(pictures, files_in(word + "/candidates"));
            for (const std::string& name : pictures) {
                const std::string one = "out/baselines/candidates/" + name;
                const std::string other = word + "/candidates/" + name;
                if (!word.starts_with("egl:") && bytes(one) != bytes(other)) {
                    ADD_FAILURE() << name << " of " << word << ": " << tumble("compare " + one + " " + other).out;
                }
            }
        }
    }
};

TEST_F(golden, pictures_are_as_they_were_accepted) {
    std::string scenes = "'" TUMBLE_SOURCE_DIR "/tests/golden/features.toml'";
    int count = 1;
    for (const fs::directory_entry& entry : fs::directory_iterator(TUMBLE_SCENE_DIR)) {
        if (entry.path().extension() == ".toml") {
            scenes += " '" + entry.path().string() + "'";
            ++count;
        }
    }
    // Missing baselines fail too, with exit code 4.
    const std::string check = "baseline check " + scenes + " --baselines '" TUMBLE_SOURCE_DIR "/tests/golden'";
    const test::Outcome outcome = tumble(check);
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    expect_the_same_of_other_devices(check);
    EXPECT_GE(count, 8);
    const std::uintmax_t most_bytes = 1'500'000;
    std::uintmax_t bytes = 0;
    for (const fs::directory_entry& entry :
         fs::recursive_directory_iterator(TUMBLE_SOURCE_DIR "/tests/golden")) {
        bytes += entry.is_regular_file() ? entry.file_size() : 0;
    }
    EXPECT_LT(bytes, most_bytes);
}
