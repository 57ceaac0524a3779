// Baselines as a user keeps them: what is drawn, what is kept, what is told, and what two calls at once may do.
#include "tests/program/program_fixture.h"

#include <nlohmann/json.hpp>

namespace fs = std::filesystem;

namespace {

/// Replaces the first `from` of a file.
void replace_in(const fs::path& path, const std::string& from, const std::string& to) {
    std::string text = sim::read_text_file(path);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    sim::write_file(path, text.replace(at, from.size(), to));
}

} // namespace

class baseline : public test::Program {
protected:
    nlohmann::json result_of_check(const std::string& arguments, int code) const {
        const test::Outcome outcome = tumble("baseline check --json " + arguments);
        EXPECT_EQ(outcome.code, code) << outcome.out << outcome.err;
        return nlohmann::json::parse(outcome.out, nullptr, false);
    }
    nlohmann::json record(const std::string& name = "common") const {
        return nlohmann::json::parse(bytes("baselines/block/" + name + "/baseline.json"));
    }
};

TEST_F(baseline, is_what_run_draws_at_start_quarters_and_end) {
    replace_in(folder / "block.toml", "[output]",
               "[overlay]\nshow = [\"title\", \"time\", \"contacts\", \"trails\", \"plots\"]\ncolor_by = \"speed\"\n"
               "[[plot]]\nquantity = \"energy\"\n[output]\nshutter = 0.5\nsubframes = 2");
    ASSERT_EQ(tumble("baseline update block.toml --quiet").code, 0);
    ASSERT_EQ(tumble("run block.toml --size 640x360 --body-ids --no-video --quiet").code, 0);
    for (const int frame : {0, 1, 3, 5, 7}) {
        const std::string name = fs::path(render::frame_file_name(frame)).filename().string();
        EXPECT_EQ(bytes("baselines/block/common/" + name), bytes("out/block/frames/" + name)) << name;
        EXPECT_TRUE(fs::exists(folder / "baselines/block/common" / (name.substr(0, 12) + ".bodies.png")));
    }
    EXPECT_EQ(files_in("baselines").size(), 16u); // five times picture, bodies and their names; the record
    EXPECT_EQ(tumble("baseline check --quiet").code, 0);
    EXPECT_EQ(tumble("baseline check --fail-on identical --quiet").code, 1); // they are compared at all
}

TEST_F(baseline, of_one_machine_asks_for_equality_and_names_the_key) {
    ASSERT_EQ(tumble("baseline update block.toml --frames 0,4,7 --size 320x180 --quiet").code, 0);
    const struct {
        const char* from;
        const char* to;
        const char* told;
    } edits[] = {
        {"density = 1000", "density = 900", "body.block.density is 900, was 1000"},
        {"A block falls", "A block  falls", "title is \"A block  falls\", was \"A block falls\""},
        {"duration = 0.4", "duration = 0.4\nshutter = 0.01", "output.shutter is 0.01, was not set"},
        {"fps = 20", "fps = 20\n[simulation]\ntime_step = 0.002", "simulation.time_step is 0.002, was not set"},
    };
    const std::string text = bytes("block.toml");
    for (const auto& edit : edits) {
        replace_in(folder / "block.toml", edit.from, edit.to);
        const nlohmann::json json = nlohmann::json::parse(tumble("baseline check block.toml --json").out);
        EXPECT_EQ(json["cases"][0]["cause"], "scene") << edit.to;
        EXPECT_NE(json["cases"][0]["cause_text"].get<std::string>().find(edit.told), std::string::npos)
            << json["cases"][0]["cause_text"];
        sim::write_file(folder / "block.toml", text);
    }
    // One level, by a light that moves nothing.
    sim::write_file(folder / "block.toml", text + "[light]\nsun_intensity = 3.405\n");
    EXPECT_EQ(result_of_check("block.toml", 1)["cases"][0]["frames"][0]["largest_difference"], 1);
    sim::write_file(folder / "block.toml", text);
    // One level in one pixel, of a baseline that the same program has drawn from the same scene.
    EXPECT_EQ(result_of_check("block.toml", 0)["cases"][0]["tier"], "identical");
    const fs::path picture = folder / "baselines/block/common/frame_000004.png";
    render::Image image = render::read_image(picture);
    image.rgb[100] ^= 1;
    sim::write_file(picture, render::encode_png(image));
    EXPECT_EQ(result_of_check("block.toml", 1)["cases"][0]["tier"], "changed");
    // Another version of OpenGL may differ by one, and another processor by what edges do.
    replace_in(folder / "baselines/block/common/baseline.json", "Mesa", "Mesa 0");
    EXPECT_EQ(result_of_check("block.toml", 0)["cases"][0]["tier"], "noise");
    image.rgb[100] ^= 6;
    sim::write_file(picture, render::encode_png(image));
    EXPECT_EQ(result_of_check("block.toml", 1)["cases"][0]["tier"], "changed");
    replace_in(folder / "baselines/block/common/baseline.json", "x86-64", "another");
    EXPECT_EQ(result_of_check("block.toml", 0)["cases"][0]["tier"], "noise");
}

TEST_F(baseline, a_changed_title_is_changed) {
    replace_in(folder / "block.toml", "[output]", "[overlay]\nshow = [\"title\"]\n[output]");
    ASSERT_EQ(tumble("baseline update block.toml --frames 0 --quiet").code, 0);
    replace_in(folder / "block.toml", "A block falls", "A block fells");
    const nlohmann::json json = result_of_check("block.toml", 1);
    EXPECT_EQ(json["cases"][0]["tier"], "changed");
    const std::string message = json["cases"][0]["message"];
    EXPECT_NE(message.find("is \"A block fells\""), std::string::npos) << message;
    EXPECT_EQ(json["cases"][0]["frames"][0]["bodies"].size(), 0u); // of what a text covers no body is told
    // What is hidden of a text is not read.
    const std::string drawn = "out/baselines/candidates/block/common/frames ";
    EXPECT_EQ(tumble("compare baselines/block/common " + drawn + "--mask 0,0,640,40 --quiet").code, 0);
    EXPECT_EQ(tumble("compare baselines/block/common " + drawn + "--mask 0,0,640,2 --quiet").code, 1);
}

TEST_F(baseline, settings_stay_and_are_taken_back) {
    ASSERT_EQ(tumble("baseline update block.toml --frames 0 --size 64x36 --set light.sun_intensity=2 --quiet").code, 0);
    const test::Outcome resized = tumble("baseline update block.toml --size 48x27");
    EXPECT_NE(resized.out.find("output.width: 64 -> 48"), std::string::npos) << resized.out;
    EXPECT_EQ(record()["overrides"].dump(), R"(["light.sun_intensity=2","output.width=48","output.height=27"])");
    ASSERT_EQ(tumble("baseline update block.toml --set light.sun_intensity=3 --set body.block.mass=2 "
                     "--unset output.height --set output.height=30 --quiet").code, 2); // mass and density
    EXPECT_EQ(record()["overrides"].size(), 3u);
    ASSERT_EQ(tumble("baseline update block.toml --unset light.sun_intensity --mask 0,0,8,8 --ignore-body floor "
                     "--quiet").code, 0);
    EXPECT_EQ(record()["overrides"].dump(), R"(["output.width=48","output.height=27"])");
    EXPECT_EQ(record()["masks"].dump(), R"(["0,0,8,8"])");
    for (const char* nothing : {"--ignore-body flor", "--mask 0,0,48,30", "--mask 50,0,4,4"}) {
        const test::Outcome refused = tumble(std::string("baseline update block.toml ") + nothing);
        EXPECT_NE(refused.code, 0) << nothing;
        test::expect_one_line(refused.err);
    }
    EXPECT_EQ(record()["masks"].dump(), R"(["0,0,8,8"])");
    // Another baseline of the scene, checked with the first.
    ASSERT_EQ(tumble("baseline update block.toml --name large --frames 2 --size 96x54 --quiet").code, 0);
    const nlohmann::json json = result_of_check("", 0);
    ASSERT_EQ(json["cases"].size(), 2u);
    EXPECT_EQ(json["cases"][1]["name"], "block/large");
    const test::Outcome taken_back = tumble("baseline update block.toml --name common --unset mask --frames default");
    EXPECT_NE(taken_back.out.find("masks: 0,0,8,8 -> not set"), std::string::npos) << taken_back.out;
    EXPECT_NE(taken_back.out.find("frames: 0 -> start, quarters, end"), std::string::npos) << taken_back.out;
}

TEST_F(baseline, accept_takes_the_pictures_that_were_reviewed) {
    sim::write_file(folder / "other.toml", bytes("block.toml"));
    ASSERT_EQ(tumble("baseline update block.toml other.toml --frames 0,7 --size 64x36 --quiet").code, 0);
    for (const char* name : {"block.toml", "other.toml"}) {
        replace_in(folder / name, "0.5, 0.5, 0.5", "0.5, 0.5, 0.6");
    }
    EXPECT_EQ(tumble("baseline check --quiet").code, 1);
    const std::string drawn = bytes("out/baselines/candidates/block/common/frames/frame_000007.png");
    // Another drawing since then is not what was reviewed.
    replace_in(folder / "block.toml", "0.5, 0.5, 0.6", "0.5, 0.5, 0.7");
    ASSERT_EQ(tumble("baseline accept out/baselines block").code, 0);
    EXPECT_EQ(bytes("baselines/block/common/frame_000007.png"), drawn);
    replace_in(folder / "block.toml", "0.5, 0.5, 0.7", "0.5, 0.5, 0.6");
    EXPECT_EQ(tumble("baseline check block.toml --report again --quiet").code, 0);
    EXPECT_EQ(tumble("baseline check other.toml --report again --quiet").code, 1);
    EXPECT_EQ(tumble("baseline accept out/baselines blok").code, 2);
    ASSERT_EQ(tumble("baseline accept again --quiet").code, 0);
    EXPECT_EQ(tumble("baseline check --report again --quiet").code, 0);
    // A picture that was touched after the check.
    replace_in(folder / "other.toml", "0.5, 0.5, 0.6", "0.5, 0.5, 0.7");
    EXPECT_EQ(tumble("baseline check other.toml --report again --quiet").code, 1);
    sim::write_file(folder / "again/candidates/other/common/frames/frame_000007.png", drawn);
    EXPECT_EQ(tumble("baseline accept again").code, 3);
    EXPECT_NE(files_in("baselines/other").count("common/frame_000007.png"), 0u);
}

TEST_F(baseline, one_bad_scene_does_not_end_the_others_report) {
    sim::write_file(folder / "other.toml", bytes("block.toml"));
    ASSERT_EQ(tumble("baseline update block.toml other.toml --frames 0 --size 64x36 --quiet").code, 0);
    replace_in(folder / "block.toml", "density = 1000", "density = -1");
    const nlohmann::json json = result_of_check("--jobs 2", 2);
    ASSERT_EQ(json["cases"].size(), 2u);
    EXPECT_NE(json["cases"][0]["message"].get<std::string>().find("density"), std::string::npos);
    EXPECT_EQ(json["cases"][1]["tier"], "identical");
    // Nor does it end the acceptance of others.
    replace_in(folder / "other.toml", "density = 1000", "density = 900");
    replace_in(folder / "other.toml", "0.5, 0.5, 0.5", "0.5, 0.5, 0.6");
    result_of_check("", 2);
    const test::Outcome accepted = tumble("baseline accept out/baselines");
    EXPECT_EQ(accepted.code, 4);
    EXPECT_NE(accepted.out.find("other: "), std::string::npos) << accepted.out;
    test::expect_one_line(accepted.err);
    // A record with a frame that cannot be.
    replace_in(folder / "baselines/other/common/baseline.json", "\"frames\": [\n    0", "\"frames\": [\n    -1");
    EXPECT_EQ(tumble("baseline check other.toml --quiet").code, 3);
    // Another vector width than that of the shaders which OpenGL keeps from call to call.
    ASSERT_EQ(tumble("baseline update other.toml --frames 0 --quiet").code, 3);
    fs::remove_all(folder / "baselines/other");
    ASSERT_EQ(tumble("baseline update other.toml --frames 0 --size 64x36 --quiet").code, 0);
    EXPECT_EQ(shell("LP_NATIVE_VECTOR_WIDTH=128 \"$TUMBLE\" baseline check other.toml --quiet").code, 0);
}

TEST_F(baseline, two_checks_at_once_do_not_touch_each_others_files) {
    ASSERT_EQ(tumble("baseline update block.toml --size 64x36 --quiet").code, 0);
    const test::Outcome outcome = shell("for i in 1 2 3 4; do \"$TUMBLE\" baseline check block.toml --quiet & done\n"
                                        "code=0; for i in 1 2 3 4; do wait -n || code=$?; done; exit $code");
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    // A folder that was asked for is not shared, and not left for another.
    const test::Outcome refused = shell("mkdir -p mine; exec 9<mine; flock 9; "
                                        "\"$TUMBLE\" baseline check block.toml --report mine --quiet");
    EXPECT_EQ(refused.code, 3);
    test::expect_one_line(refused.err);
}
