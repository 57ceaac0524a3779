/// Odd but legal: each works, or is refused with one line.
#include "render/picture/image.h"
#include "tests/program/program_fixture.h"
#include "tests/support/film_reader.h"

#include <unistd.h>

namespace fs = std::filesystem;
using test::expect_one_line;
using test::Outcome;

namespace {

class odd : public test::Program {
protected:
    /// Runs the scene, and expects so many whole frames of a size in PNG and film.
    void expect_film(const std::string& arguments, const fs::path& run, int frames, int width,
                     int height) const {
        SCOPED_TRACE(arguments);
        const Outcome outcome = tumble("run " + arguments + " --quiet");
        ASSERT_EQ(outcome.code, 0) << outcome.err;
        EXPECT_EQ(outcome.out + outcome.err, "");
        for (int k = 0; k < frames; ++k) {
            const render::Image picture = render::read_image(folder / run / render::frame_file_name(k));
            EXPECT_EQ(picture.width, width);
            EXPECT_EQ(picture.height, height);
        }
        EXPECT_FALSE(fs::exists(folder / run / render::frame_file_name(frames)));
        const test::Film film = test::read_film(folder / run / (run.filename().string() + ".mp4"));
        EXPECT_EQ(film.frames.size(), static_cast<std::size_t>(frames));
        EXPECT_EQ(film.width, width + width % 2);
        EXPECT_EQ(film.height, height + height % 2);
    }
};

std::string repeated(const std::string& text, int count) {
    std::string result;
    for (int i = 0; i < count; ++i) {
        result += text;
    }
    return result;
}

} // namespace

TEST_F(odd, sizes_down_to_one_pixel) {
    expect_film("block.toml --duration 0.1 --size 1x1", "out/block", 2, 1, 1);
    expect_film("block.toml --duration 0.1 --size 161x91", "out/block", 2, 161, 91);
    expect_film("block.toml --duration 0.1 --size 3x1", "out/block", 2, 3, 1);
    expect_film("block.toml --duration 0.1 --size 1x33", "out/block", 2, 1, 33);
    expect_film("block.toml --duration 0.05 --size 4096x2", "out/block", 1, 4096, 2);
}

TEST_F(odd, one_frame_and_a_thousandth_of_a_second) {
    expect_film("block.toml --size 16x9 --duration 0.05", "out/block", 1, 16, 9);
    expect_film("block.toml --size 16x9 --duration 0.001 --fps 1000", "out/block", 1, 16, 9);
    const Outcome outcome = tumble("run block.toml --size 16x9 --duration 0.001 --fps 60");
    EXPECT_EQ(outcome.code, 2);
    expect_one_line(outcome.err);
    EXPECT_NE(outcome.err.find("makes no frame, expected at least"), std::string::npos) << outcome.err;
}

TEST_F(odd, frame_rates_from_slow_to_fast_and_broken) {
    expect_film("block.toml --size 16x9 --duration 0.1 --fps 240", "out/block", 24, 16, 9);
    expect_film("block.toml --size 16x9 --duration 0.125 --fps 24000/1001", "out/block", 3, 16, 9);
    const test::Film film = test::read_film(folder / "out/block/block.mp4");
    EXPECT_EQ(film.times[2], sim::make_rational(2 * 1001, 24000));
    expect_film("block.toml --size 16x9 --duration 2 --fps 0.5 --time-step 0.01", "out/block", 1, 16, 9);
    expect_film("block.toml --size 16x9 --duration 0.002 --fps 1000000/1001", "out/block", 2, 16, 9);
}

TEST_F(odd, scenes_without_a_dynamic_body_or_any_body) {
    sim::write_file(folder / "floor.toml",
                    std::string("[[body]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nstatic = true\n"));
    sim::write_file(folder / "empty.toml", std::string());
    expect_film("floor.toml --size 16x9 --duration 0.05", "out/floor", 3, 16, 9);
    expect_film("empty.toml --size 16x9 --duration 0.05", "out/empty", 3, 16, 9);
    EXPECT_EQ(tumble("render out/empty/trajectory.h5 --size 8x8 --out again").code, 0);
    EXPECT_EQ(tumble("check empty.toml").code, 0);
}

TEST_F(odd, a_chain_without_sag_tells_into_what_its_steps_are_divided) {
    const std::string link = "shape = { kind = \"box\", size = [0.4, 0.1, 0.1] }\n";
    const std::string joint = "[[joint]]\nkind = \"ball\"\n";
    sim::write_file(folder / "taut.toml", "[[body]]\nname = \"a\"\nposition = [0.25, 0, 0]\n" + link +
                                              "[[body]]\nname = \"b\"\nposition = [0.75, 0, 0]\n" + link + joint +
                                              "name = \"1\"\nbodies = [\"a\"]\nanchor = [0, 0, 0]\n" + joint +
                                              "name = \"2\"\nbodies = [\"a\", \"b\"]\nanchor = [0.5, 0, 0]\n" + joint +
                                              "name = \"3\"\nbodies = [\"b\"]\nanchor = [1, 0, 0]\n");
    const std::string taut = tumble("simulate taut.toml --set output.duration=0.1").out;
    EXPECT_NE(taut.find("; steps of 0.001 s were divided into "), std::string::npos) << taut;
    EXPECT_EQ(tumble("simulate block.toml").out.find("divided"), std::string::npos);
}

TEST_F(odd, names_with_spaces_quotes_and_letters_of_all_scripts) {
    const std::string name = "Б л\xC3\xB6"
                             "ck 'n' \xE7\xA2\x81";
    fs::create_directories(folder / "a b");
    std::string text = test::scene_text;
    const std::string body = "\\\"\xC3\xA4 \xE7\xA2\x81\\\"";
    text.replace(text.find("\"block\""), 7, "\"" + body + "\"");
    sim::write_file(folder / "a b" / (name + ".toml"), text);
    expect_film("a*/*.toml --size 16x9 --duration 0.1 --body-ids --out 'o \xC3\xBC'",
                fs::path("o \xC3\xBC") / name, 2, 16, 9);
    const std::string run = "'o \xC3\xBC'/*";
    EXPECT_EQ(tumble("join " + run + " --quiet").code, 0);
    EXPECT_EQ(tumble("render " + run + "/trajectory.h5 --quiet --out again").code, 0);
    EXPECT_EQ(tumble("compare " + run + " again/* --quiet --report 'a report'").code, 0);
    EXPECT_EQ(tumble("gallery 'o \xC3\xBC' --quiet").code, 0);
    EXPECT_EQ(tumble("baseline update a*/*.toml --size 16x9 --quiet").code, 0);
    EXPECT_EQ(tumble("baseline check a*/*.toml --quiet").code, 0);
}

TEST_F(odd, output_on_another_disk) {
    const fs::path other = "/dev/shm";
    if (!fs::is_directory(other)) {
        GTEST_SKIP() << "no second disk here";
    }
    const fs::path place = other / ("tumble_test_" + std::to_string(::getpid()));
    const Outcome outcome =
        tumble("run block.toml --size 16x9 --duration 0.1 --quiet --out " + place.string());
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(fs::exists(place / "block/block.mp4"));
    fs::remove_all(place);
}

TEST_F(odd, long_paths_work_and_names_too_long_are_refused) {
    const std::string path = repeated("folder/", 30); // 210 letters, and the name of the frame
    expect_film("block.toml --size 16x9 --duration 0.1 --out " + path, path + "block", 2, 16, 9);
    const std::string name = repeated("n", 200);
    fs::copy_file(folder / "block.toml", folder / (name + ".toml"));
    expect_film(name + ".toml --size 16x9 --duration 0.1", "out/" + name, 2, 16, 9);
    const std::string too_long = repeated("n", 250);
    fs::copy_file(folder / "block.toml", folder / (too_long + ".toml"));
    EXPECT_EQ(tumble("run " + too_long + ".toml").code, 2);
    for (const std::string& arguments : {"block.toml --out " + repeated("n", 256),
                                         "block.toml --out " + repeated("folder/", 700)}) {
        const Outcome outcome = tumble("run --size 16x9 --duration 0.1 " + arguments);
        EXPECT_EQ(outcome.code, 3);
        expect_one_line(outcome.err);
        EXPECT_NE(outcome.err.find("File name too long"), std::string::npos) << outcome.err;
    }
}

TEST_F(odd, texts_as_editors_on_other_systems_write_them) {
    std::string lines;
    for (const char c : std::string(test::scene_text)) {
        lines += c == '\n' ? std::string("\r\n") : std::string(1, c);
    }
    sim::write_file(folder / "crlf.toml", lines);
    sim::write_file(folder / "mark.toml", "\xEF\xBB\xBF" + std::string(test::scene_text));
    for (const char* name : {"crlf", "mark"}) {
        expect_film(std::string(name) + ".toml --size 16x9 --duration 0.1", fs::path("out") / name, 2, 16, 9);
        EXPECT_TRUE(bytes(fs::path("out") / name / render::frame_file_name(1)) ==
                    bytes("out/crlf/frames/frame_000001.png"));
    }
}

TEST_F(odd, places_that_are_links_folders_above_or_the_present_one) {
    fs::create_directories(folder / "real");
    fs::create_directory_symlink("real", folder / "link");
    fs::create_symlink("block.toml", folder / "other.toml");
    expect_film("other.toml --size 16x9 --duration 0.1 --out link", "real/other", 2, 16, 9);
    expect_film("./real/../block.toml --size 16x9 --duration 0.1 --out .", "block", 2, 16, 9);
}

TEST_F(odd, what_cannot_be_printed_is_no_success) {
    for (const char* arguments : {"check block.toml", "man", "scenes .", "--help"}) {
        const Outcome outcome = tumble(std::string(arguments) + " >/dev/full");
        EXPECT_EQ(outcome.code, 3) << arguments;
        EXPECT_EQ(outcome.err, "tumble: cannot write to the standard output\n");
    }
    EXPECT_EQ(tumble("run block.toml --out - --format y4m --quiet >/dev/full").err, "tumble: cannot write to standard output\n");
}

/// A film, a table and a text, of which another program reads a few bytes, or none.
TEST_F(odd, a_reader_that_goes_early_is_no_error) {
    ASSERT_EQ(tumble("simulate block.toml --quiet --record-every 1").code, 0);
    for (const char* arguments : {"run block.toml --out - --format y4m --quiet", "export out/block --csv -", "man"}) {
        for (const char* reader : {"head -c 10", "true"}) {
            const Outcome outcome = shell(std::string("(sleep 0.1; \"$TUMBLE\" ") + arguments + "; echo $? >code) | " + reader);
            EXPECT_EQ(bytes("code"), "0\n") << arguments << " | " << reader;
            EXPECT_EQ(outcome.err, "") << arguments << " | " << reader;
        }
    }
}

TEST_F(odd, files_without_an_end_are_refused_and_pipes_can_be_interrupted) {
    const Outcome endless = tumble("check /dev/zero");
    EXPECT_EQ(endless.code, 3);
    EXPECT_EQ(endless.err, "tumble: cannot read /dev/zero: it is larger than 256 MiB\n");
    // Once the pipe can be written to, it is read.
    const Outcome pipe = shell("mkfifo pipe.toml; \"$TUMBLE\" check pipe.toml & process=$!\nexec 3>pipe.toml; sleep 0.1; kill "
                               "$process; wait $process");
    EXPECT_EQ(pipe.code, 130);
    EXPECT_EQ(pipe.err, "tumble: interrupted\n");
    EXPECT_EQ(tumble("run /dev/stdin --size 16x9 --duration 0.1 --quiet <block.toml").code, 0);
}
