/// The pictures that somebody has looked at and accepted: the start and a few early frames of each scene, and
/// each feature of the shaders. After a change of the look that is meant:
///     build/tumble baseline update scenes/*.toml tests/golden/features.toml --baselines tests/golden
#include "tests/program/program_fixture.h"

namespace fs = std::filesystem;

class golden : public test::Program {};

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
    const test::Outcome outcome =
        tumble("baseline check " + scenes + " --baselines '" TUMBLE_SOURCE_DIR "/tests/golden'");
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_GE(count, 8);
    const std::uintmax_t most_bytes = 1'500'000;
    std::uintmax_t bytes = 0;
    for (const fs::directory_entry& entry :
         fs::recursive_directory_iterator(TUMBLE_SOURCE_DIR "/tests/golden")) {
        bytes += entry.is_regular_file() ? entry.file_size() : 0;
    }
    EXPECT_LT(bytes, most_bytes);
}
