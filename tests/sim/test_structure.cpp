// The structure of the code as sim/README.md and render/README.md state it: the order of the rooms, what render/ may see
// of sim/, and which files own the headers of each library. The lists are read from the pages, so they cannot fall behind.
#include "sim/collide/box_pairs.h"
#include "sim/solve/contact_memory.h"
#include "sim/solve/rest_batch.h"
#include "sim/world/candidates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// One include directive of one file.
struct Include {
    std::string file; ///< "sim/world/world.cpp", relative to the project
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

/// The fenced list that follows the comment <!-- name --> in a page, a line each.
std::vector<std::string> list_of(const std::string& page, const std::string& name) {
    std::ifstream in(fs::path(TUMBLE_SOURCE_DIR) / page);
    std::vector<std::string> lines;
    std::string line;
    while (std::getline(in, line) && line != "<!-- " + name + " -->") {
    }
    std::getline(in, line); // the fence
    while (std::getline(in, line) && line != "```") {
        lines.push_back(line);
    }
    return lines;
}

using Values = std::map<std::string, std::set<std::string>>;

/// Names and values of the constants of the core, as the code has them.
Values constants_of_code() {
    const std::set<std::string> of_the_language = {"infinity", "cache_line"};
    static const std::regex constant(R"(constexpr (?:double|int|std::size_t) (\w+) = ([^;]+);)");
    Values values;
    for (const char* room : {"sim/block", "sim/solve", "sim/world"}) {
        for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(TUMBLE_SOURCE_DIR) / room)) {
            std::ifstream in(entry.path());
            for (std::string line; std::getline(in, line);) {
                std::smatch found;
                if (std::regex_search(line, found, constant) && !of_the_language.contains(found[1])) {
                    values[found[1]].insert(found[2]);
                }
            }
        }
    }
    return values;
}

/// The same, as the second column of the table of sim/README.md has them: `name` value and value, ...
Values constants_of_page() {
    static const std::regex constant(R"(`(\w+)` ([^,]+))");
    std::ifstream in(fs::path(TUMBLE_SOURCE_DIR) / "sim/README.md");
    Values values;
    std::string line;
    while (std::getline(in, line) && line != "<!-- constants -->") {
    }
    while (std::getline(in, line)) {
        const std::size_t first = line.find(" | ");
        const std::string column = first == std::string::npos ? "" : line.substr(first + 3, line.find(" | ", first + 3) - first - 3);
        for (std::sregex_iterator i(column.begin(), column.end(), constant); i != std::sregex_iterator(); ++i) {
            std::string all = (*i)[2];
            for (std::size_t end = all.find(" and "); end != std::string::npos; end = all.find(" and ")) {
                values[(*i)[1]].insert(all.substr(0, end));
                all = all.substr(end + 5);
            }
            values[(*i)[1]].insert(all);
        }
    }
    return values;
}

/// First word of each line -> the other words.
WordList words_of(const std::vector<std::string>& lines) {
    WordList list;
    for (const std::string& line : lines) {
        std::istringstream words(line);
        std::string key;
        words >> key;
        for (std::string word; words >> word;) {
            list[key].push_back(word);
        }
    }
    return list;
}

/// The rooms of "sim" or "render", in the order of its page.
std::vector<std::string> rooms_of(const std::string& top) {
    std::vector<std::string> rooms;
    for (const std::string& line : list_of(top + "/README.md", "rooms")) {
        rooms.push_back(line.substr(0, line.find(' ')));
    }
    return rooms;
}

bool starts_with(const std::string& text, const std::string& beginning) {
    return text.compare(0, beginning.size(), beginning) == 0;
}

bool contains(const std::vector<std::string>& list, const std::string& word) {
    return std::ranges::find(list, word) != list.end();
}

/// "sim/world/world.cpp" -> "world".
std::string room_of(const std::string& file) {
    const std::size_t first = file.find('/');
    const std::size_t second = file.find('/', first + 1);
    return second == std::string::npos ? std::string() : file.substr(first + 1, second - first - 1);
}

/// What is wrong with an include within sim/ or render/; empty if nothing is.
std::string room_fault(const std::vector<std::string>& rooms, const Include& include) {
    const auto from = std::ranges::find(rooms, room_of(include.file));
    const auto to = std::ranges::find(rooms, room_of(include.path));
    if (from == rooms.end() || to == rooms.end()) {
        return "the page names no room of " + (from == rooms.end() ? include.file : include.path);
    }
    return to <= from ? std::string() : include.file + " includes " + include.path + " of a later room";
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
               : include.file + " includes <" + include.path + ">, which the page gives to other files";
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
    const std::vector<std::string> rooms = {"base", "model", "world"};
    EXPECT_EQ(room_fault(rooms, {"sim/model/body.h", "sim/base/math.h"}), "");
    EXPECT_EQ(room_fault(rooms, {"sim/model/body.h", "sim/model/shape.h"}), "");
    EXPECT_NE(room_fault(rooms, {"sim/model/body.cpp", "sim/world/world.h"}), "");
    EXPECT_NE(room_fault(rooms, {"sim/new/body.cpp", "sim/base/math.h"}), "");
    EXPECT_NE(room_fault(rooms, {"sim/body.cpp", "sim/base/math.h"}), "");
    const WordList owners = {{"hdf5.h", {"sim/record/hdf5.h"}}, {"glm/", {"render/"}}};
    EXPECT_EQ(owner_fault(owners, {"sim/record/hdf5.h", "hdf5.h"}), "");
    EXPECT_EQ(owner_fault(owners, {"render/scene/mesh.h", "glm/glm.hpp"}), "");
    EXPECT_EQ(owner_fault(owners, {"sim/world/world.cpp", "vector"}), "");
    EXPECT_NE(owner_fault(owners, {"sim/world/world.cpp", "hdf5.h"}), "");
    EXPECT_NE(owner_fault(owners, {"sim/base/math.h", "glm/glm.hpp"}), "");
}

TEST(structure, every_file_of_sim_sees_its_own_and_earlier_rooms_only) {
    const std::vector<std::string> rooms = rooms_of("sim");
    int checked = 0;
    for (const Include& include : all_includes()) {
        if (starts_with(include.file, "sim/") && starts_with(include.path, "sim/")) {
            EXPECT_EQ(room_fault(rooms, include), "");
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

TEST(structure, every_file_of_render_sees_its_own_and_earlier_rooms_and_of_sim_what_the_page_says) {
    const std::vector<std::string> rooms = rooms_of("render");
    std::vector<std::string> seen;
    for (const std::string& line : list_of("render/README.md", "sees")) {
        std::istringstream words(line);
        for (std::string word; words >> word;) {
            seen.push_back(word);
        }
    }
    ASSERT_FALSE(seen.empty());
    const auto is_generated = [](const std::string& path) {
        return path == "render/shader_texts.h" || path == "render/font_data.h";
    };
    int checked = 0;
    for (const Include& include : all_includes()) {
        const bool is_room = contains(rooms, room_of(include.file));
        if (!starts_with(include.file, "render/") || (!is_room && !starts_with(include.file, "render/compare/"))) {
            continue;
        }
        if (is_room && starts_with(include.path, "render/") && !is_generated(include.path)) {
            EXPECT_EQ(room_fault(rooms, include), "");
        }
        EXPECT_FALSE(starts_with(include.path, "render/cmd/")) << include.file;
        if (starts_with(include.path, "sim/")) {
            EXPECT_TRUE(contains(seen, include.path)) << include.file << ": " << include.path;
            ++checked;
        }
    }
    EXPECT_GT(checked, 10) << "nothing was searched";
}

TEST(structure, headers_of_libraries_stay_in_the_files_that_own_them) {
    WordList owners = words_of(list_of("sim/README.md", "owners"));
    owners.merge(words_of(list_of("render/README.md", "owners")));
    EXPECT_GT(owners.size(), 8u) << "the lists of the pages were not read";
    for (const Include& include : all_includes()) {
        EXPECT_EQ(owner_fault(owners, include), "");
    }
}

/// A folder that a command left there would be committed with the next change.
TEST(structure, nothing_lies_at_the_top_beside_what_the_project_consists_of) {
    const std::set<std::string> project{
        ".ci", ".clang-format", ".clang-tidy", ".git", ".gitignore", "CMakeLists.txt", "CMakePresets.json", "LICENSE",
        "README.md", "out", "render", "run", "scenes", "shaders", "sim", "tests"};
    for (const fs::directory_entry& entry : fs::directory_iterator(TUMBLE_SOURCE_DIR)) {
        const std::string name = entry.path().filename();
        EXPECT_TRUE(project.contains(name) || name.starts_with("build")) << name;
    }
}

TEST(structure, table_of_constants_is_that_of_the_code) {
    const Values code = constants_of_code();
    EXPECT_GT(code.size(), 20u) << "nothing was searched";
    EXPECT_LE(code.size(), 40u) << "one more only for one that goes";
    EXPECT_EQ(constants_of_page(), code);
}

TEST(structure, table_of_records_is_that_of_the_code) {
    using namespace sim;
    const std::map<std::string, std::size_t> code = {
        {"Contact", sizeof(Contact)},
        {"BatchPoint", sizeof(BatchPoint) / lane_count},
        {"RestPoint", sizeof(RestPoint) / lane_count},
        {"ExtrapolatedPoint", sizeof(ExtrapolatedPoint) / lane_count},
        {"PairContacts", sizeof(PairContacts)},
        {"BlockBatch", sizeof(BlockBatch) / lane_count},
        {"RestBlock", sizeof(RestBlock) / lane_count},
        {"Block", sizeof(Block)},
        {"Candidate", sizeof(Candidate)},
        {"BoxAxes", sizeof(BoxAxes)},
        {"BodyProps", sizeof(BodyProps)},
        {"Pose", sizeof(Pose)},
        {"Velocity", sizeof(Velocity)},
        {"BodyRows", sizeof(BodyRows)},
        {"PlacedBoxRow", sizeof(PlacedBoxRow)},
    };
    static const std::regex row(R"(\| `(\w+)` \| `([\w/.]+)` \| (\d+) \|.*)");
    std::ifstream in(fs::path(TUMBLE_SOURCE_DIR) / "sim/README.md");
    std::map<std::string, std::size_t> page;
    std::string line;
    while (std::getline(in, line) && line != "<!-- records -->") {
    }
    while (std::getline(in, line) && line.starts_with("|")) {
        std::smatch found;
        if (std::regex_match(line, found, row)) {
            page[found[1]] = std::stoul(found[3]);
            std::ifstream file(fs::path(TUMBLE_SOURCE_DIR) / "sim" / found[2].str());
            const std::string text(std::istreambuf_iterator<char>(file), {});
            EXPECT_TRUE(std::regex_search(text, std::regex("struct (alignas\\(\\d+\\) )?" + found[1].str() + " \\{"))) << line;
        }
    }
    EXPECT_EQ(page, code);
}
