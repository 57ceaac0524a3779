/// The catalogue of messages.txt: every wrong argument and file gives exactly its message and exit code, and
/// leaves everything as it was.
#include "tests/program/program_fixture.h"

#include <fstream>
#include <vector>

namespace fs = std::filesystem;
using test::Outcome;

namespace {

class messages : public test::Program {};

struct Case {
    std::string what;
    std::string command;
    int code = 0;
    std::string message; ///< all that is printed
};

std::vector<Case> read_cases() {
    std::ifstream file(TUMBLE_SOURCE_DIR "/tests/program/messages.txt");
    std::vector<Case> cases;
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("## ")) {
            cases.push_back({line.substr(3), {}, 0, {}});
        } else if (cases.empty() || line.empty()) {
            continue;
        } else if (line.starts_with("$ tumble")) {
            cases.back().command = line.substr(8);
        } else if (line.starts_with("= ")) {
            cases.back().code = std::stoi(line.substr(2));
        } else {
            cases.back().message += line + "\n";
        }
    }
    return cases;
}

/// Empty lines separate the cases of the catalogue.
std::string without_empty_lines(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c != '\n' || (!result.empty() && result.back() != '\n')) {
            result += c;
        }
    }
    return result;
}

} // namespace

TEST_F(messages, of_the_catalogue_are_exactly_what_a_user_sees) {
    const Outcome prepared = shell(sim::read_text_file(TUMBLE_SOURCE_DIR "/tests/program/messages_setup.sh"));
    ASSERT_EQ(prepared.code, 0) << prepared.err;
    const std::set<std::string> files = files_in(".");
    const std::vector<Case> cases = read_cases();
    EXPECT_GE(cases.size(), 60u);
    for (const Case& c : cases) {
        SCOPED_TRACE(c.what + "\ntumble" + c.command);
        const Outcome outcome = tumble(c.command + " 2>&1");
        EXPECT_EQ(outcome.code, c.code);
        EXPECT_EQ(without_empty_lines(outcome.out), c.message);
    }
    for (const std::string& file : files_in(".")) {
        EXPECT_TRUE(files.contains(file) || file.starts_with("out/baselines/"))
            << "a refused command wrote " << file;
    }
}
