/// The built program as a user runs it: exit codes, files, messages.
#include "render/film/video_reader.h"
#include "render/gl/context.h"
#include "sim/record/trajectory.h"
#include "sim/scene/file.h"
#include "tests/program/program_fixture.h"
#include "tests/support/film_reader.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <regex>

namespace fs = std::filesystem;
using test::expect_one_line;
using test::frame_count;
using test::Outcome;

namespace {

class program : public test::Program {};

} // namespace

TEST_F(program, run_writes_frames_film_trajectory_and_summary) {
    const Outcome outcome = tumble("run block.toml");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    expect_one_line(outcome.out);
    EXPECT_EQ(outcome.err, "");
    EXPECT_EQ(files_in("out/block"), expected_files());

    // The film is its frames, each at its time.
    const test::Film film = test::read_film(folder / "out/block/block.mp4");
    ASSERT_EQ(film.frames.size(), static_cast<std::size_t>(frame_count));
    EXPECT_EQ(film.width, 320);
    EXPECT_EQ(film.height, 180);
    EXPECT_EQ(film.metadata.at("title"), "A block falls");
    for (int k = 0; k < frame_count; ++k) {
        EXPECT_EQ(film.times[k], sim::make_rational(k, 20));
        const render::Image picture = render::read_image(folder / "out/block" / render::frame_file_name(k));
        EXPECT_EQ(picture.width, 320);
        EXPECT_EQ(picture.height, 180);
        // Half-size chroma costs most; a frame in the wrong place reads below 30 dB.
        EXPECT_GT(test::psnr(test::to_rgb(film.frames[k]), picture), 34.0) << "frame " << k;
    }

    // The summary knows every other file.
    const nlohmann::json summary = nlohmann::json::parse(bytes("out/block/summary.json"));
    EXPECT_EQ(summary["steps"], 400);
    EXPECT_EQ(summary["simulated_time_s"], 0.4);
    EXPECT_NE(std::string(summary["renderer"]).find("llvmpipe"), std::string::npos);
    EXPECT_EQ(summary["processor"], render::processor_class());
    for (const char* stage : {"list", "draw", "edges", "png", "video"}) {
        EXPECT_GT(summary["picture_ms_per_frame"][stage], 0.0) << stage;
    }
    std::set<std::string> named{"summary.json"};
    for (const nlohmann::json& file : summary["files"]) {
        named.insert(file["name"]);
        const sim::WrittenFile found = sim::describe_file(folder / "out/block", file["name"]);
        EXPECT_EQ(file["bytes"], found.bytes);
        EXPECT_EQ(file["sha256"], found.sha256);
    }
    EXPECT_EQ(named, expected_files());
}

TEST_F(program, frame_k_shows_the_step_nearest_to_its_time) {
    ASSERT_EQ(tumble("simulate block.toml --fps 24000/1001 --time-step 0.003").code, 0);
    const sim::TrajectoryReader trajectory(folder / "out/block/trajectory.h5");
    ASSERT_EQ(trajectory.steps().size(), 10u); // round(0.4 * 23.976)
    for (std::size_t k = 0; k < trajectory.steps().size(); ++k) {
        EXPECT_EQ(trajectory.steps()[k], std::llround(double(k) * 1001 / 24000 / 0.003));
        EXPECT_DOUBLE_EQ(trajectory.read(k).time, 0.003 * double(trajectory.steps()[k]));
    }
    EXPECT_EQ(files_in("out/block"), (std::set<std::string>{"trajectory.h5", "summary.json"}));
}

TEST_F(program, a_step_longer_than_a_frame_is_shown_by_several_frames) {
    ASSERT_EQ(tumble("run block.toml --fps 100 --time-step 0.02 --duration 0.1 --no-video").code, 0);
    EXPECT_EQ(sim::TrajectoryReader(folder / "out/block/trajectory.h5").steps(),
              (std::vector<std::int64_t>{0, 1, 2, 3, 4, 5}));
    EXPECT_EQ(files_in("out/block/frames").size(), 11u);
    EXPECT_TRUE(bytes("out/block/frames/frame_000001.png") == bytes("out/block/frames/frame_000002.png"));
}

TEST_F(program, record_every_n_steps_includes_the_start) {
    ASSERT_EQ(tumble("simulate block.toml --record-every 150").code, 0);
    EXPECT_EQ(sim::TrajectoryReader(folder / "out/block/trajectory.h5").steps(),
              (std::vector<std::int64_t>{0, 150, 300}));
}

TEST_F(program, one_and_two_threads_two_runs_and_a_later_rendering_give_the_same_bytes) {
    ASSERT_EQ(tumble("run block.toml --threads 1 --out a").code, 0);
    ASSERT_EQ(tumble("run block.toml --threads 2 --out b").code, 0);
    ASSERT_EQ(tumble("simulate block.toml --out c").code, 0);
    ASSERT_EQ(tumble("render c/block/trajectory.h5").code, 0);
    for (const std::string& name : expected_files()) {
        if (name != "summary.json") { // which has wall times
            EXPECT_TRUE(bytes("a/block/" + name) == bytes("b/block/" + name)) << name;
            EXPECT_TRUE(bytes("a/block/" + name) == bytes("c/block/" + name)) << name;
        }
    }
    const auto hash_of = [this](const std::string& run) {
        return nlohmann::json::parse(bytes(run + "/block/summary.json"))["state_hash"];
    };
    EXPECT_EQ(hash_of("a"), hash_of("b"));
    EXPECT_EQ(hash_of("a"), hash_of("c"));
}

TEST_F(program, the_film_made_from_the_png_files_has_the_same_bytes) {
    ASSERT_EQ(tumble("run block.toml").code, 0);
    const sim::SceneDef scene = sim::load_scene(folder / "block.toml");
    render::VideoWriter video(folder / "again.mp4", 320, 180, render::video_settings(scene));
    for (int k = 0; k < frame_count; ++k) {
        video.add(render::read_image(folder / "out/block" / render::frame_file_name(k)));
    }
    video.finish();
    EXPECT_TRUE(bytes("again.mp4") == bytes("out/block/block.mp4"));
}

// An encoder blurs and rings at every edge; a block 3 px higher is a change all the same.
TEST_F(program, films_are_compared_with_films_of_another_rate_and_with_frames) {
    ASSERT_EQ(shell("sed 's/position = .*/position = [0, 0, 0.97]/' block.toml >higher.toml\n"
                    "\"$TUMBLE\" run block.toml --quiet && "
                    "\"$TUMBLE\" run block.toml --set output.crf=28 --out b --quiet && "
                    "\"$TUMBLE\" run higher.toml --set output.crf=28 --out b --quiet").code, 0);
    for (const char* other : {"b/block/block.mp4", "out/block"}) {
        for (const std::string& pair : {std::string("out/block/block.mp4 ") + other, other + std::string(" out/block/block.mp4")}) {
            const test::Outcome compared = tumble("compare " + pair);
            EXPECT_EQ(compared.code, 0) << pair << ": " << compared.out;
            EXPECT_NE(compared.out.find("8 noise"), std::string::npos) << compared.out;
        }
    }
    EXPECT_EQ(tumble("compare out/block/block.mp4 b/higher/higher.mp4 --quiet").code, 1);
    EXPECT_EQ(tumble("compare out/block b/higher/higher.mp4 --quiet").code, 1);
    // Of a top that spins, encoders leave less.
    const std::string top = "run \"" TUMBLE_SCENE_DIR "/tippe_top.toml\" --size 320x180 --fps 24 --set output.duration=1/2 --quiet ";
    ASSERT_EQ(tumble(top).code, 0);
    ASSERT_EQ(tumble(top + "--crf 28 --out b").code, 0);
    ASSERT_EQ(tumble(top + "--crf 28 --out wider --set camera.main.fov_degrees=27.5").code, 0);
    EXPECT_EQ(tumble("compare out/tippe_top/tippe_top.mp4 b/tippe_top/tippe_top.mp4 --quiet").code, 0);
    EXPECT_EQ(tumble("compare out/tippe_top/tippe_top.mp4 wider/tippe_top/tippe_top.mp4 --quiet").code, 1);
}

TEST_F(program, frames_and_film_do_not_depend_on_cores_threads_of_opengl_or_its_vectors) {
    ASSERT_EQ(tumble("simulate block.toml").code, 0);
    const std::string draw = "\"$TUMBLE\" render out/block/trajectory.h5 --out ";
    ASSERT_EQ(shell(draw + "a").code, 0);
    for (const char* setting : {"taskset -c 0", "env LP_NUM_THREADS=3", "env LP_NATIVE_VECTOR_WIDTH=128",
                                "env LP_NATIVE_VECTOR_WIDTH=256"}) {
        ASSERT_EQ(shell(setting + (" " + draw) + "b").code, 0) << setting;
        EXPECT_TRUE(bytes("a/block/block.mp4") == bytes("b/block/block.mp4")) << setting;
        for (int k = 0; k < frame_count; ++k) {
            const std::string name = "block/" + render::frame_file_name(k);
            EXPECT_TRUE(bytes("a/" + name) == bytes("b/" + name)) << setting << ", " << name;
        }
    }
}

TEST_F(program, portable_pictures_do_not_depend_on_vectors_or_the_mathematical_library) {
    ASSERT_EQ(tumble("simulate block.toml").code, 0);
    const std::string draw =
        "\"$TUMBLE\" render out/block/trajectory.h5 --portable --no-video --frames 4:6 --out ";
    ASSERT_EQ(shell(draw + "a").code, 0);
    // The last one takes the C library's code paths for processors without fused multiply-add.
    for (const char* setting : {"env LP_NATIVE_VECTOR_WIDTH=128", "env LP_NATIVE_VECTOR_WIDTH=256",
                                "env GLIBC_TUNABLES=glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX"}) {
        ASSERT_EQ(shell(setting + (" " + draw) + "b").code, 0) << setting;
        const std::string name = "block/" + render::frame_file_name(5);
        EXPECT_TRUE(bytes("a/" + name) == bytes("b/" + name)) << setting;
    }
}

TEST_F(program, the_decoded_film_shows_the_frames) {
    ASSERT_EQ(tumble("run block.toml").code, 0);
    const test::Film film = test::read_film(folder / "out/block/block.mp4");
    ASSERT_EQ(film.frames.size(), static_cast<std::size_t>(frame_count));
    EXPECT_TRUE(film.is_tagged_bt709);
    for (int k = 0; k < frame_count; ++k) {
        const render::Image shown = test::to_rgb(film.frames[static_cast<std::size_t>(k)]);
        const auto db = [&](int frame) {
            return test::psnr(shown,
                              render::read_image(folder / "out/block" / render::frame_file_name(frame)));
        };
        EXPECT_GT(db(k), 36.0) << k;
        EXPECT_GT(db(k), db(k == 0 ? 1 : k - 1)) << k;
    }
}

TEST_F(program, frames_of_other_shaders_or_another_renderer_are_not_mixed) {
    ASSERT_EQ(tumble("run block.toml --frames 0:2").code, 0);
    const std::string record = bytes("out/block/frames/run.json");
    nlohmann::json json = nlohmann::json::parse(record);
    for (const char* key : {"renderer", "shaders_hash"}) {
        nlohmann::json other = json;
        other[key] = "another";
        sim::write_file(folder / "out/block/frames/run.json", other.dump());
        const Outcome outcome = tumble("run block.toml --frames 2:4");
        EXPECT_EQ(outcome.code, 2);
        EXPECT_NE(outcome.err.find("another"), std::string::npos) << outcome.err;
    }
    json["renderer"] =
        std::regex_replace(std::string(json["renderer"]), std::regex("[0-9]+ bits"), "64 bits");
    sim::write_file(folder / "out/block/frames/run.json", json.dump());
    EXPECT_EQ(tumble("run block.toml --frames 2:4").code, 0);
}

TEST_F(program, render_draws_an_earlier_simulation_in_another_size_and_rate) {
    ASSERT_EQ(tumble("simulate block.toml").code, 0);
    const Outcome outcome =
        tumble("render out/block/trajectory.h5 --out other --size 161x91 --fps 10 --no-png");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(files_in("other/block"), (std::set<std::string>{"block.mp4"}));
    const test::Film film = test::read_film(folder / "other/block/block.mp4");
    EXPECT_EQ(film.frames.size(), 4u);
    EXPECT_EQ(film.width, 162); // even
    EXPECT_EQ(film.height, 92);
}

// The shutter is open for all of a frame's 50 ms, in which the block falls 12 cm in frame 5.
TEST_F(program, an_open_shutter_blurs_what_moves_and_nothing_else) {
    ASSERT_EQ(tumble("run block.toml --out sharp --no-video --size 160x90").code, 0);
    ASSERT_EQ(tumble("render sharp/block/trajectory.h5 --out blurred --no-video "
                     "--set output.shutter=1 --set output.subframes=4")
                  .code,
              0);
    const std::string name = "block/" + render::frame_file_name(5);
    const render::Image sharp = render::read_image(folder / "sharp" / name);
    const render::Image blurred = render::read_image(folder / "blurred" / name);
    int changed = 0;
    for (std::size_t i = 0; i < sharp.rgb.size(); ++i) {
        changed += std::abs(sharp.rgb[i] - blurred.rgb[i]) > 8 ? 1 : 0;
    }
    EXPECT_GT(changed, 30);
    EXPECT_LT(changed, static_cast<int>(sharp.rgb.size() / 10));
}

TEST_F(program, portable_pictures_say_so_and_are_not_mixed_with_others) {
    const std::string small = "run block.toml --no-video --preset draft --size 160x90 ";
    ASSERT_EQ(tumble(small + "--portable").code, 0);
    const nlohmann::json summary = nlohmann::json::parse(bytes("out/block/summary.json"));
    EXPECT_EQ(summary["processor"], "x86-64, no more than sse4.1");
    EXPECT_EQ(summary["settings"]["effort"], "ultrafast");
    const Outcome mixed = tumble(small + "--resume");
    EXPECT_EQ(mixed.code, 2);
    EXPECT_NE(mixed.err.find("it was x86-64, no more than sse4.1"), std::string::npos) << mixed.err;
}

TEST_F(program, a_second_run_leaves_nothing_of_the_first) {
    ASSERT_EQ(tumble("run block.toml").code, 0);
    ASSERT_EQ(tumble("run block.toml --duration 0.1 --no-video").code, 0);
    EXPECT_EQ(files_in("out/block"),
              (std::set<std::string>{"frames/run.json", "frames/frame_000000.png", "frames/frame_000001.png",
                                     "summary.json", "trajectory.h5"}));
}

TEST_F(program, several_scenes_names_with_spaces_and_a_single_frame) {
    const std::string name = "ein B\xC3\xA4ll";
    fs::copy_file(folder / "block.toml", folder / (name + ".toml"));
    const Outcome outcome = tumble("run block.toml ein*.toml --duration 0.05 --size 1x1");
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    for (const std::string& scene : {std::string("block"), name}) {
        EXPECT_EQ(files_in("out/" + scene),
                  (std::set<std::string>{"frames/run.json", "frames/frame_000000.png", "summary.json",
                                         "trajectory.h5", scene + ".mp4"}));
    }
}

TEST_F(program, quiet_prints_nothing) {
    const Outcome outcome = tumble("run block.toml --duration 0.1 --quiet");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.out + outcome.err, "");
}

TEST_F(program, a_film_that_browsers_do_not_play_is_told) {
    const std::string note = "crf 0 is a lossless film, which browsers do not play\n";
    EXPECT_NE(tumble("run block.toml --duration 0.1 --crf 0").out.find(note), std::string::npos);
    EXPECT_NE(tumble("render out/block --crf 0").out.find(note), std::string::npos);
    EXPECT_EQ(tumble("run block.toml --duration 0.1 --crf 1").out.find(note), std::string::npos);
    EXPECT_EQ(tumble("run block.toml --duration 0.1 --crf 0 --no-video").out.find(note), std::string::npos);
}

TEST_F(program, check_prints_the_scene_and_writes_nothing) {
    const Outcome outcome = tumble("check block.toml");
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.out.find("A block falls"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST_F(program, version_and_help_are_good) {
    EXPECT_EQ(tumble("--version").out.substr(0, 7), "tumble ");
    EXPECT_EQ(tumble("--help").code, 0);
    EXPECT_NE(tumble("run --help").out.find("--record-every"), std::string::npos);
}

TEST_F(program, a_trajectory_without_the_needed_records_is_refused_before_anything_is_removed) {
    ASSERT_EQ(tumble("run block.toml").code, 0);
    const Outcome rate = tumble("render out/block/trajectory.h5 --fps 30");
    EXPECT_EQ(rate.code, 2);
    EXPECT_NE(rate.err.find("would show 'block' wrong by up to"), std::string::npos) << rate.err;
    const Outcome length = tumble("render out/block/trajectory.h5 --duration 1");
    EXPECT_EQ(length.code, 2);
    EXPECT_NE(length.err.find("ends at step 350"), std::string::npos) << length.err;
    const Outcome physics = tumble("render out/block/trajectory.h5 --set simulation.tolerance=1");
    EXPECT_EQ(physics.code, 2);
    EXPECT_EQ(files_in("out/block"), expected_files());
}

TEST_F(program, interruption_keeps_whole_frames_only) {
    for (const char* name : {"INT", "TERM"}) {
        fs::remove_all(folder / "out");
        const Outcome outcome = shell("\"$TUMBLE\" run block.toml --duration 10000 & process=$!\n"
                                      "until [ -e out/block/frames/frame_000003.png ]; do sleep 0.02; done\n"
                                      "kill -" +
                                      std::string(name) + " $process; wait $process");
        EXPECT_EQ(outcome.code, 130);
        EXPECT_NE(outcome.err.find("tumble: interrupted; "), std::string::npos) << outcome.err;
        int frames = 0;
        for (const std::string& file : files_in("out/block")) {
            if (file == "frames/run.json" || file.starts_with("checkpoint.")) {
                continue;
            }
            EXPECT_TRUE(file.starts_with("frames/frame_") && file.ends_with(".png")) << file;
            EXPECT_EQ(render::read_image(folder / "out/block" / file).width, 320);
            ++frames;
        }
        EXPECT_GE(frames, 4);
    }
}

TEST_F(program, an_interrupted_simulation_keeps_a_checkpoint_only) {
    const Outcome outcome = shell("\"$TUMBLE\" simulate block.toml --duration 10000 --quiet & process=$!\n"
                                  "until [ -e out/block/trajectory.h5.part ]; do sleep 0.02; done\n"
                                  "kill -TERM $process; wait $process");
    EXPECT_EQ(outcome.code, 130);
    EXPECT_EQ(outcome.err,
              "tumble: interrupted; what is done is kept in out/block: the same command with --resume goes on\n");
    EXPECT_EQ(files_in("out/block"), (std::set<std::string>{"checkpoint.bin", "checkpoint.states"}));
}

TEST_F(program, a_second_run_into_the_same_folder_is_refused) {
    const Outcome outcome = shell("\"$TUMBLE\" run block.toml --duration 10000 --quiet & process=$!\n"
                                  "until [ -e out/block/frames/frame_000001.png ]; do sleep 0.02; done\n"
                                  "\"$TUMBLE\" run block.toml; code=$?\n"
                                  "kill $process; wait $process; exit $code");
    EXPECT_EQ(outcome.code, 3);
    EXPECT_NE(outcome.err.find("tumble: another run is writing into out/block\n"), std::string::npos)
        << outcome.err;
}

TEST_F(program, what_a_killed_run_left_is_cleared_by_the_next) {
    shell("\"$TUMBLE\" run block.toml --duration 10000 --quiet & process=$!\n"
          "until [ -e out/block/frames/frame_000003.png ]; do sleep 0.02; done\n"
          "kill -KILL $process; wait $process");
    EXPECT_TRUE(fs::exists(folder / "out/block/trajectory.h5.part"));
    ASSERT_EQ(tumble("run block.toml").code, 0);
    EXPECT_EQ(files_in("out/block"), expected_files());
}

// A limit on the size of files fails the write that crosses it, as a full disk does: 40 kB for a trajectory
// of more than 100 kB and a film in full size.
TEST_F(program, a_write_that_fails_is_one_line_and_leaves_no_half_file) {
    for (const char* arguments : {"simulate block.toml", "run block.toml --no-png"}) {
        const Outcome outcome = shell("ulimit -f 40\n\"$TUMBLE\" " + std::string(arguments) + " --quiet");
        EXPECT_EQ(outcome.code, 3) << outcome.err;
        expect_one_line(outcome.err);
        EXPECT_NE(outcome.err.find("File too large"), std::string::npos) << outcome.err;
        EXPECT_TRUE(files_in("out/block").empty());
    }
}

TEST_F(program, a_simulation_that_stops_is_told_apart) {
    if (has_sanitizer) {
        GTEST_SKIP();
    }
    // What leaves the range of numbers is refused before the first step; what leaves the memory stops.
    const Outcome outcome =
        shell("ulimit -v 500000; \"$TUMBLE\" simulate \"" TUMBLE_SCENE_DIR
              "/funnel.toml\" --set 'lattice.cube.count=[90,90,90]' --duration 0.01 --quiet");
    EXPECT_EQ(outcome.code, 5) << outcome.err;
    expect_one_line(outcome.err);
    EXPECT_TRUE(files_in("out/funnel").empty());
}

/// Slow motion asks for states between steps; a later rendering finds them between the same two records.
TEST_F(program, slow_motion_of_a_run_and_of_its_trajectory_are_the_same_bytes) {
    const std::string slow = " --set output.speed=0.01 --set simulation.time_step=0.002 --duration 0.4";
    ASSERT_EQ(tumble("run block.toml --no-video --quiet" + slow).code, 0); // a frame is a quarter of a step
    ASSERT_EQ(tumble("render out/block --no-video --quiet --out again").code, 0);
    for (int k = 0; k < frame_count; ++k) {
        const std::string name = render::frame_file_name(k);
        EXPECT_EQ(bytes("out/block/" + name), bytes("again/block/" + name)) << k;
    }
    EXPECT_NE(bytes("out/block/" + render::frame_file_name(0)), bytes("out/block/" + render::frame_file_name(7)));
    const nlohmann::json summary = nlohmann::json::parse(bytes("out/block/summary.json"));
    EXPECT_EQ(summary["steps"], 2);
}

/// What a pipe gets is what the PNG files show.
TEST_F(program, frames_go_to_a_pipe_as_they_are) {
    const std::string few = " --size 66x34 --duration 0.15 --progress json ";
    ASSERT_EQ(tumble("run block.toml --no-video --quiet" + few).code, 0);
    const std::string raw = tumble("run block.toml --out - --format rgb24" + few).out;
    ASSERT_EQ(raw.size(), 3u * 3 * 66 * 34);
    for (int k = 0; k < 3; ++k) {
        const render::Image image = render::read_image(folder / "out/block" / render::frame_file_name(k));
        EXPECT_EQ(raw.substr(image.rgb.size() * static_cast<std::size_t>(k), image.rgb.size()),
                  std::string(image.rgb.begin(), image.rgb.end()));
    }
    EXPECT_EQ(tumble("render out/block --out - --format rgb24 --frames 1:3").out, raw.substr(raw.size() / 3));
    ASSERT_EQ(shell("\"$TUMBLE\" run block.toml --out - --format y4m --quiet > film.y4m" + few).code, 0);
    render::VideoReader reader(folder / "film.y4m");
    EXPECT_EQ(reader.fps(), 20.0);
    int count = 0;
    for (render::Image image; reader.read(image); ++count) {
        double sum = 0.0;
        for (std::size_t i = 0; i < image.rgb.size(); ++i) {
            sum += std::abs(image.rgb[i] - static_cast<std::uint8_t>(raw[image.rgb.size() * static_cast<std::size_t>(count) + i]));
        }
        EXPECT_LT(sum / static_cast<double>(image.rgb.size()), 2.0); // of 255: rounding, there and back
    }
    EXPECT_EQ(count, 3);
    EXPECT_FALSE(std::filesystem::exists(folder / "-"));
}

/// From full speed to a stand: the last frames are one picture.
TEST_F(program, a_ramp_ends_in_a_picture_that_stands) {
    ASSERT_EQ(tumble("run block.toml --no-video --quiet --set "
                     "'output.speed_keys=[{time=0.1,speed=1},{time=0.2,speed=0}]'")
                  .code,
              0);
    EXPECT_EQ(bytes("out/block/" + render::frame_file_name(4)), bytes("out/block/" + render::frame_file_name(7)));
    EXPECT_NE(bytes("out/block/" + render::frame_file_name(2)), bytes("out/block/" + render::frame_file_name(4)));
}
