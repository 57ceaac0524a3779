#include "sim/base/file_io.h"

#include "sim/base/error.h"
#include "tests/support/out_folder.h"

#include <gtest/gtest.h>

#include <string>

using namespace sim;
namespace fs = std::filesystem;

TEST(file_io, written_text_is_read_back_and_no_part_file_is_left) {
    const fs::path path = test::fresh_folder("file_io") / "a b.txt";
    std::string text = "first\nsecond";
    text += '\0';
    text += std::string(200000, 'x');
    write_file(path, text);
    EXPECT_EQ(read_text_file(path), text);
    EXPECT_FALSE(fs::exists(part_path(path)));
}

TEST(file_io, writing_again_replaces_the_file) {
    const fs::path path = test::fresh_folder("file_io") / "a.txt";
    write_file(path, std::string("a longer text"));
    write_file(path, std::string("short"));
    EXPECT_EQ(read_text_file(path), "short");
}

// FIPS 180-2, appendix B.1 and B.3, and the empty message.
TEST(file_io, sha256_gives_the_published_values) {
    const fs::path path = test::fresh_folder("file_io") / "message";
    write_file(path, std::string("abc"));
    EXPECT_EQ(sha256_of_file(path), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    write_file(path, std::string(1000000, 'a'));
    EXPECT_EQ(sha256_of_file(path), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
    write_file(path, std::string());
    EXPECT_EQ(sha256_of_file(path), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

TEST(file_io, a_missing_file_is_an_io_error_that_names_it) {
    const fs::path path = test::fresh_folder("file_io") / "missing.txt";
    try {
        read_text_file(path);
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_EQ(error.what(), "cannot read " + path.string() + ": No such file or directory");
    }
}

TEST(file_io, a_missing_folder_is_an_io_error_on_writing) {
    const fs::path path = test::fresh_folder("file_io") / "nowhere" / "a.txt";
    try {
        write_file(path, std::string("text"));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
    }
}

TEST(file_io, a_full_device_is_an_io_error) {
    // The part file is a link to the device that is always full.
    const fs::path path = test::fresh_folder("file_io") / "a.txt";
    fs::create_symlink("/dev/full", part_path(path));
    try {
        write_file(path, std::string("text"));
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::io);
        EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos);
    }
    EXPECT_FALSE(fs::exists(path));
    EXPECT_FALSE(fs::is_symlink(part_path(path)));
}

TEST(file_io, a_described_file_has_its_size_and_hash) {
    const fs::path folder = test::fresh_folder("file_io");
    write_file(folder / "abc", std::string("abc"));
    const WrittenFile file = describe_file(folder, "abc");
    EXPECT_EQ(file.name, "abc");
    EXPECT_EQ(file.bytes, 3u);
    EXPECT_EQ(file.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_THROW(describe_file(folder, "missing"), Error);
}
