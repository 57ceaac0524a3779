#include "tests/page/sample_report.h"

#include "render/film/video_writer.h"
#include "render/picture/image.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>

namespace {

namespace fs = std::filesystem;
using Document = nlohmann::ordered_json;
using render::Image;

struct Color {
    int r, g, b;
};

void fill(Image& image, int x0, int y0, int width, int height, Color color) {
    for (int y = std::max(0, y0); y < std::min(image.height, y0 + height); ++y) {
        for (int x = std::max(0, x0); x < std::min(image.width, x0 + width); ++x) {
            std::uint8_t* pixel = image.rgb.data() + (static_cast<std::size_t>(y) * image.width + x) * 3;
            pixel[0] = static_cast<std::uint8_t>(color.r);
            pixel[1] = static_cast<std::uint8_t>(color.g);
            pixel[2] = static_cast<std::uint8_t>(color.b);
        }
    }
}

/// Sky, floor and three cubes; the last one is `shift` [px] off to the right.
Image sample_picture(int shift, int lift = 0) {
    Image image(sample_width, sample_height);
    for (int y = 0; y < sample_height; ++y) {
        const bool is_floor = y >= 110;
        fill(image, 0, y, sample_width, 1,
             is_floor ? Color{150 + (y - 110) / 2, 146 + (y - 110) / 2, 138 + (y - 110) / 2}
                      : Color{116 + y / 2, 160 + y / 3, 214});
    }
    fill(image, 40, 90 - lift, 50, 50, {213, 94, 0});
    fill(image, 130, 80, 60, 60, {0, 114, 178});
    fill(image, 230 + shift, 100, 40, 40, {240, 228, 66});
    return image;
}

Image difference(const Image& a, const Image& b) {
    Image image(a.width, a.height);
    for (std::size_t i = 0; i < a.rgb.size(); i += 3) {
        const int gray = 40 + a.rgb[i] / 5;
        const bool differs = !std::equal(&a.rgb[i], &a.rgb[i] + 3, &b.rgb[i]);
        image.rgb[i] = static_cast<std::uint8_t>(differs ? 255 : gray);
        image.rgb[i + 1] = image.rgb[i + 2] = static_cast<std::uint8_t>(differs ? 40 : gray);
    }
    return image;
}

std::string write_picture(const fs::path& folder, const std::string& name, const Image& image) {
    const fs::path path = fs::path("pictures") / name;
    fs::create_directories((folder / path).parent_path());
    sim::write_file(folder / path, render::encode_png(image));
    return path.string();
}

Document gate(const char* name, double value, double limit, const char* unit, const char* reason) {
    return {{"name", name},
            {"value", value},
            {"limit", limit},
            {"unit", unit},
            {"reason", reason},
            {"source", "default"},
            {"is_exceeded", value > limit}};
}

Document frame_of(const std::string& name, int index, const std::string& tier, const std::string& message) {
    return {{"name", name},
            {"index", index},
            {"status", "compared"},
            {"tier", tier},
            {"message", message},
            {"width", sample_width},
            {"height", sample_height},
            {"candidate_width", sample_width},
            {"candidate_height", sample_height},
            {"differing_pixels", 0},
            {"largest_difference", 0},
            {"mean_difference", 0.0},
            {"curve", 0.0},
            {"gates", Document::array()},
            {"clusters", Document::array()},
            {"bodies", Document::array()},
            {"reference_picture", ""},
            {"candidate_picture", ""},
            {"difference_picture", ""}};
}

void add_pictures(Document& frame, const fs::path& folder, const std::string& stem, const Image& a,
                  const Image& b) {
    frame["reference_picture"] = write_picture(folder, stem + ".reference.png", a);
    frame["candidate_picture"] = write_picture(folder, stem + ".candidate.png", b);
    frame["difference_picture"] = write_picture(folder, stem + ".difference.png", difference(a, b));
}

Document case_of(const std::string& name, const Document& frames) {
    const Document origin = {{"program", "tumble 0.1.0"},
                         {"scene", "funnel"},
                         {"state_hash", "5f0c9d1be2a7743c"},
                         {"shaders_hash", "90aa11c2cc5d0e17"},
                         {"renderer", "llvmpipe (LLVM 15.0.6, 256 bits)"}};
    const Document& worst = *std::max_element(
        frames.begin(), frames.end(), [](const Document& a, const Document& b) { return a["curve"] < b["curve"]; });
    return {{"name", name},
            {"reference", "golden/" + name},
            {"candidate", "out/" + name},
            {"is_sequence", frames.size() > 1},
            {"is_failed", worst["tier"] == "changed"},
            {"status", worst["status"]},
            {"tier", worst["tier"]},
            {"message", worst["message"]},
            {"cause", "unknown"},
            {"cause_text", ""},
            {"reference_origin", origin},
            {"candidate_origin", origin},
            {"first_bad_frame", nullptr},
            {"worst_frame", nullptr},
            {"shift", nullptr},
            {"bad_runs", Document::array()},
            {"missing_frames", Document::array()},
            {"extra_frames", Document::array()},
            {"film", ""},
            {"fps", 0.0},
            {"is_flaky", false},
            {"history", Document::array()},
            {"frames", frames}};
}

/// A cube that has moved by `shift` [px].
Document moved_frame(const fs::path& folder, const std::string& stem, int index, int shift, int lift) {
    Document frame = frame_of(fmt::format("frame_{:06}.png", index), index, "changed",
                          fmt::format("cube_3 moved {} px, {:.1f} mm", shift, shift * 2.4));
    add_pictures(frame, folder, stem, sample_picture(0, lift), sample_picture(shift, lift));
    frame["differing_pixels"] = 80 * shift;
    frame["largest_difference"] = 148;
    frame["mean_difference"] = 0.11 * shift;
    frame["curve"] = 1.9 * shift;
    frame["gates"] = {
        gate("faint", 32.0 * shift, 24, "px", "The fullest window of 32 x 32 px is at 224, 96."),
        gate("displacement", shift, 0.5, "px", "The cluster at 230, 100 has moved to the right."),
        gate("drift", 0.04, 0.5, "levels", "The mean colour of the picture.")};
    const Document box = {230, 100, 40 + shift, 40};
    const Document displacement = {{"x", double(shift)}, {"y", 0.0}, {"explained", 0.98}};
    frame["clusters"] = Document::array({Document{{"box", box},
                                          {"pixels", 80 * shift},
                                          {"largest_difference", 148},
                                          {"kind", "moved"},
                                          {"displacement", displacement},
                                          {"bodies", Document::array({"cube_3"})}}});
    frame["bodies"] = Document::array({Document{{"name", "cube_3"},
                                        {"kind", "moved"},
                                        {"displacement", displacement},
                                        {"distance", 0.0024 * shift},
                                        {"pixels", 1600},
                                        {"box", box}}});
    return frame;
}

Document noise_frame(const fs::path& folder) {
    Document frame = frame_of("edges.png", 0, "noise", "212 px differ, all at edges");
    const Image a = sample_picture(0);
    Image b = a;
    fill(b, 130, 80, 1, 60, {20, 118, 180});
    add_pictures(frame, folder, "edges/edges", a, b);
    frame["differing_pixels"] = 60;
    frame["largest_difference"] = 20;
    frame["curve"] = 0.4;
    frame["gates"] = {gate("faint", 8, 24, "px", "The fullest window of 32 x 32 px is at 112, 80."),
                      gate("displacement", 0.02, 0.5, "px", "No cluster has moved.")};
    return frame;
}

Document film_case(const fs::path& folder) {
    Document frames = Document::array();
    for (int i = 0; i < 12; ++i) {
        if (i >= 5 && i <= 7) {
            frames.push_back(
                moved_frame(folder, fmt::format("film/frame_{:06}", i), i, i == 6 ? 4 : 2, 3 * i));
        } else {
            frames.push_back(frame_of(fmt::format("frame_{:06}.png", i), i, "identical", "the same pixels"));
        }
    }
    Document item = case_of("film", frames);
    item["first_bad_frame"] = 5;
    item["worst_frame"] = 6;
    item["bad_runs"] = Document::array({Document::array({5, 8})});
    item["cause"] = "simulation";
    item["cause_text"] = "The simulation changed: same scene and shaders, another state hash.";
    item["candidate_origin"]["state_hash"] = "0b1844d6f0937a2e";
    item["film"] = "film.mp4";
    item["fps"] = 10.0;
    render::VideoWriter film(folder / "film.mp4", 3 * sample_width, sample_height, {.fps = {10, 1}});
    for (int i = 0; i < 12; ++i) {
        const Image a = sample_picture(0, 3 * i);
        const Image b = sample_picture(i >= 5 && i <= 7 ? 2 : 0, 3 * i);
        const Image c = difference(a, b);
        Image all(3 * sample_width, sample_height);
        for (int y = 0; y < sample_height; ++y) {
            for (int k = 0; k < 3; ++k) {
                const Image& part = k == 0 ? a : k == 1 ? b : c;
                const auto* row = part.rgb.data() + static_cast<std::size_t>(y) * sample_width * 3;
                std::copy(row, row + sample_width * 3,
                          all.rgb.data() + (static_cast<std::size_t>(y) * 3 + k) * sample_width * 3);
            }
        }
        film.add(all);
    }
    film.finish();
    return item;
}

Document missing_case(const fs::path& folder) {
    Document frame = frame_of("gone.png", 0, "changed", "out/gone.png does not exist");
    frame["status"] = "candidate_missing";
    frame["candidate_width"] = frame["candidate_height"] = 0;
    frame["reference_picture"] = write_picture(folder, "gone/gone.reference.png", sample_picture(0));
    Document item = case_of("gone", Document::array({frame}));
    item["is_failed"] = true;
    return item;
}

} // namespace

void write_sample_report(const fs::path& folder, diff::PagePictures pictures) {
    fs::remove_all(folder);
    fs::create_directories(folder);
    Document cases = Document::array();
    cases.push_back(case_of("moved cube", Document::array({moved_frame(folder, "moved cube/frame", 0, 3, 0)})));
    cases.push_back(case_of("edges", Document::array({noise_frame(folder)})));
    cases.back()["is_flaky"] = true;
    for (const double curve : {0.4, 1.8, 0.3, 1.7, 0.2}) {
        cases.back()["history"].push_back({{"time", "2026-01-31T12:00:00Z"}, {"is_failed", curve > 1}, {"curve", curve}});
    }
    cases.push_back(case_of("same", Document::array({frame_of("same.png", 0, "identical", "the same bytes")})));
    cases.push_back(film_case(folder));
    cases.push_back(missing_case(folder));
    cases.push_back(case_of(hostile_name, Document::array({moved_frame(folder, "hostile/frame", 0, 1, 0)})));
    const Document result = {
        {"version", 1},
        {"program", "tumble 0.1.0"},
        {"command", "tumble compare golden out --report out/report"},
        {"accept", "tumble baseline accept out/report"},
        {"fail_on", "changed"},
        {"exit_code", 4},
        {"counts", {{"identical", 1}, {"noise", 1}, {"changed", 3}, {"not_compared", 1}, {"failed", 4}}},
        {"cases", cases}};
    diff::write_report_page(folder, result.dump(2), pictures);
}
