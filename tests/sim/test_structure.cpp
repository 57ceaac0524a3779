// The structure of the code as README.md states it: the include levels of sim/, what render/ may see of sim/,
// and which files own the headers of each library. The two lists are read from the page, so it cannot fall
// behind.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// One include directive of one file.
struct Include {
    std::string file; ///< "sim/world.cpp", relative to the project
    std::string path; ///< what stands between the quotes or brackets
};

/// First word of a line of a list -> the other words.
using WordList = std::map<std::string, std::vector<std::string>>;

/// What stands between the quotes or brackets of an include directive; empty if the line is none.
std::string included_path(const std::string& line) {
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#') {
        return {};
    }
    const std::size_t word = line.find_first_not_of(" \t", hash + 1);
    if (word == std::string::npos || line.compare(word, 7, "include") != 0) {
        return {};
    }
    const std::size_t open = line.find_first_of("\"<", word);
    const std::size_t close = open == std::string::npos ? open : line.find_first_of("\">", open + 1);
    return close == std::string::npos ? std::string() : line.substr(open + 1, close - open - 1);
}

/// All include directives of the C++ files under the project's folders.
std::vector<Include> all_includes() {
    const fs::path root = TUMBLE_SOURCE_DIR;
    std::vector<Include> includes;
    for (const char* folder : {"sim", "render", "tests"}) {
        for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root / folder)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".h" && extension != ".cpp") {
                continue;
            }
            std::ifstream in(entry.path());
            for (std::string line; std::getline(in, line);) {
                if (std::string path = included_path(line); !path.empty()) {
                    includes.push_back(
                        {entry.path().lexically_relative(root).generic_string(), std::move(path)});
                }
            }
        }
    }
    return includes;
}

/// The fenced list that follows the comment <!-- name --> in README.md.
WordList list_of_readme(const std::string& name) {
    std::ifstream in(fs::path(TUMBLE_SOURCE_DIR) / "README.md");
    WordList list;
    std::string line;
    while (std::getline(in, line) && line != "<!-- " + name + " -->") {
    }
    std::getline(in, line); // the fence
    while (std::getline(in, line) && line != "```") {
        std::istringstream words(line);
        std::string key;
        words >> key;
        for (std::string word; words >> word;) {
            list[key].push_back(word);
        }
    }
    return list;
}

bool starts_with(const std::string& text, const std::string& beginning) {
    return text.compare(0, beginning.size(), beginning) == 0;
}

bool contains(const std::vector<std::string>& list, const std::string& word) {
    return std::ranges::find(list, word) != list.end();
}

/// "sim/world.cpp" -> "world".
std::string unit_of(const std::string& file) {
    return fs::path(file).stem().string();
}

/// Level of each unit of sim/; 0 if README.md does not name it.
int level_of(const WordList& levels, const std::string& unit) {
    for (const auto& [level, units] : levels) {
        if (level != "render" && contains(units, unit)) {
            return std::stoi(level);
        }
    }
    return 0;
}

/// What is wrong with an include of sim/ in sim/; empty if nothing is.
std::string level_fault(const WordList& levels, const Include& include) {
    const int from = level_of(levels, unit_of(include.file));
    const int to = level_of(levels, unit_of(include.path));
    if (from == 0 || to == 0) {
        return "README.md names no level of " + (from == 0 ? include.file : include.path);
    }
    const bool is_header = fs::path(include.file).extension() == ".h";
    if (is_header ? to < from : to <= from) {
        return {};
    }
    return include.file + " (level " + std::to_string(from) + ") includes " + include.path + " (level " +
           std::to_string(to) + ")";
}

/// What is wrong with the include of a library's header; empty if nothing is. An owner that ends in / is a
/// folder.
std::string owner_fault(const WordList& owners, const Include& include) {
    const auto is_of = [&](const auto& entry) { return starts_with(include.path, entry.first); };
    const auto owner = std::ranges::find_if(owners, is_of);
    if (owner == owners.end()) {
        return {};
    }
    const auto is_here = [&](const std::string& name) {
        return name.back() == '/' ? starts_with(include.file, name) : include.file == name;
    };
    return std::ranges::any_of(owner->second, is_here)
               ? std::string()
               : include.file + " includes <" + include.path + ">, which README.md gives to other files";
}

} // namespace

TEST(structure, include_directives_are_read_in_every_form) {
    EXPECT_EQ(included_path("#include \"sim/world.h\""), "sim/world.h");
    EXPECT_EQ(included_path("  #  include <libavutil/opt.h> // for av_opt_set"), "libavutil/opt.h");
    EXPECT_EQ(included_path("// #include <hdf5.h>"), "");
    EXPECT_EQ(included_path("#define include"), "");
    EXPECT_EQ(included_path(""), "");
}

TEST(structure, faults_are_seen) {
    const WordList levels = {{"1", {"error"}}, {"2", {"shape", "scene_tree"}}, {"3", {"body"}}};
    EXPECT_EQ(level_fault(levels, {"sim/body.h", "sim/shape.h"}), "");
    EXPECT_EQ(level_fault(levels, {"sim/shape.cpp", "sim/scene_tree.h"}), "");
    EXPECT_NE(level_fault(levels, {"sim/shape.h", "sim/scene_tree.h"}), "");
    EXPECT_NE(level_fault(levels, {"sim/shape.cpp", "sim/body.h"}), "");
    EXPECT_NE(level_fault(levels, {"sim/new.cpp", "sim/body.h"}), "");
    const WordList owners = {{"hdf5.h", {"sim/trajectory_hdf5.h"}}, {"glm/", {"render/"}}};
    EXPECT_EQ(owner_fault(owners, {"sim/trajectory_hdf5.h", "hdf5.h"}), "");
    EXPECT_EQ(owner_fault(owners, {"render/mesh.h", "glm/glm.hpp"}), "");
    EXPECT_EQ(owner_fault(owners, {"sim/world.cpp", "vector"}), "");
    EXPECT_NE(owner_fault(owners, {"sim/world.cpp", "hdf5.h"}), "");
    EXPECT_NE(owner_fault(owners, {"sim/math.h", "glm/glm.hpp"}), "");
}

TEST(structure, every_header_of_sim_sees_lower_levels_only) {
    const WordList levels = list_of_readme("levels");
    int checked = 0;
    for (const Include& include : all_includes()) {
        if (starts_with(include.file, "sim/") && starts_with(include.path, "sim/")) {
            EXPECT_EQ(level_fault(levels, include), "");
            ++checked;
        }
    }
    EXPECT_GT(checked, 50) << "nothing was searched";
}

TEST(structure, sim_sees_nothing_of_render_and_neither_sees_the_tests) {
    int checked = 0;
    for (const Include& include : all_includes()) {
        const bool is_sim = starts_with(include.file, "sim/");
        if (is_sim || starts_with(include.file, "render/")) {
            EXPECT_FALSE(starts_with(include.path, "tests/")) << include.file;
            EXPECT_FALSE(is_sim && starts_with(include.path, "render/")) << include.file << ": " << include.path;
            ++checked;
        }
    }
    EXPECT_GT(checked, 200) << "nothing was searched";
}

TEST(structure, study_sees_nothing_of_the_pictures) {
    int checked = 0;
    for (const Include& include : all_includes()) {
        if (starts_with(include.file, "render/study/") && starts_with(include.path, "render/")) {
            EXPECT_TRUE(starts_with(include.path, "render/study/")) << include.file << ": " << include.path;
            ++checked;
        }
    }
    EXPECT_GT(checked, 10) << "nothing was searched";
}

TEST(structure, render_sees_of_sim_only_what_the_page_says_and_not_its_own_verbs) {
    const WordList levels = list_of_readme("levels");
    ASSERT_TRUE(levels.contains("render"));
    int checked = 0;
    for (const Include& include : all_includes()) {
        if (!starts_with(include.file, "render/") || starts_with(include.file, "render/cmd/") ||
            starts_with(include.file, "render/study/")) {
            continue;
        }
        EXPECT_FALSE(starts_with(include.path, "render/cmd/")) << include.file;
        if (starts_with(include.path, "sim/")) {
            EXPECT_TRUE(contains(levels.at("render"), unit_of(include.path)))
                << include.file << ": " << include.path;
            ++checked;
        }
    }
    EXPECT_GT(checked, 10) << "nothing was searched";
}

TEST(structure, headers_of_libraries_stay_in_the_files_that_own_them) {
    const WordList owners = list_of_readme("owners");
    EXPECT_GT(owners.size(), 8u) << "the list of README.md was not read";
    for (const Include& include : all_includes()) {
        EXPECT_EQ(owner_fault(owners, include), "");
    }
}
