/// Writes the pairs of pictures by which the judge of comparisons is judged: real drawings of all scenes, edited states,
/// other samples, other encodings. Arguments: FOLDER SEED SCENE.toml...
///
///     FOLDER/seen/CLASS/NAME.a.png, .b.png      four of five pairs of seed 0; limits may be chosen by them
///     FOLDER/unseen/CLASS/...                   every fifth pair of each class; of any other seed all pairs, of other moments
///
/// As of a stranger's pictures, no file tells which texts are written over it.
/// A class begins with "noise", or with "changed"; those of films and JPEG files have "film" or "JPEG" in their name.
#include "render/compare/picture.h"
#include "render/film/video_reader.h"
#include "render/film/video_writer.h"
#include "render/overlay/overlay.h"
#include "render/picture/renderer.h"
#include "render/scene/camera.h"
#include "sim/base/file_io.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"
#include "tests/tools/judge_pictures.h"

#include <fmt/format.h>
#include <stb_image_write.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace judge;

/// What is drawn.
struct Drawing {
    sim::SceneDef scene;
    sim::Snapshot snapshot;
    int width = 640;
    int height = 360;
    bool smooth_edges = true;
};

Image world_of(const Drawing& d, int factor) {
    sim::SceneDef scene = d.scene;
    scene.output.width = d.width * factor;
    scene.output.height = d.height * factor;
    render::RenderSettings settings = render::render_settings(scene.output);
    settings.smooth_edges = d.smooth_edges;
    render::Renderer renderer(scene, scene.output.width, scene.output.height, settings);
    return renderer.draw(d.snapshot);
}

/// Title and time over it, as films have them.
Image with_text(Image image, const Drawing& d) {
    render::Overlay overlay(d.scene);
    const render::Notes notes;
    const render::DepthPicture depth;
    overlay.draw(image, {d.snapshot.time, d.snapshot, notes, depth});
    return image;
}

Image draw(const Drawing& d) {
    return with_text(world_of(d, 1), d);
}

/// As the last of three frames of a film shows it: encoders leave most to see of what moves.
Image filmed(const Drawing& d, const fs::path& folder, int crf, const char* preset) {
    constexpr int frames = 3;
    constexpr double fps = 30.0;
    const fs::path path = folder / "film.mp4";
    render::VideoSettings settings;
    settings.crf = crf;
    settings.preset = preset;
    render::VideoWriter writer(path, d.width, d.height, settings);
    for (int i = 0; i < frames; ++i) {
        Drawing frame = d;
        frame.snapshot = render::moved(d.snapshot, (i + 1 - frames) / fps);
        writer.add(draw(frame));
    }
    writer.finish();
    render::VideoReader reader(path);
    Image shown;
    for (int i = 0; i < frames; ++i) {
        reader.read(shown);
    }
    return shown;
}

/// As a JPEG file shows it.
Image as_jpeg(const Image& image, int quality) {
    diff::Bytes bytes;
    const auto append = [](void* to, void* from, int size) {
        const auto* first = static_cast<const std::uint8_t*>(from);
        static_cast<diff::Bytes*>(to)->insert(static_cast<diff::Bytes*>(to)->end(), first, first + size);
    };
    stbi_write_jpg_to_func(append, &bytes, image.width, image.height, 3, image.rgb.data(), quality);
    diff::Picture shown;
    diff::ReaderMemory memory;
    diff::decode_picture(bytes, "JPEG", {}, shown, memory);
    Image result(image.width, image.height);
    result.rgb = shown.rgb;
    return result;
}

class Corpus {
public:
    Corpus(fs::path folder, bool has_seen) : folder_(std::move(folder)), has_seen_(has_seen) { fs::create_directories(folder_); }

    const fs::path& folder() const { return folder_; }

    void add(const std::string& kind, const std::string& name, Image a, Image b) {
        if (a.rgb == b.rgb) {
            return; // nothing is to be seen of the change
        }
        const int number = counts_[kind]++;
        const fs::path place = folder_ / (has_seen_ && number % 5 != 4 ? "seen" : "unseen") / kind;
        fs::create_directories(place);
        a.texts.clear();
        b.texts.clear();
        sim::write_file_unsynced(place / fmt::format("{}_{:03}.a.png", name, number), render::encode_png(a));
        sim::write_file_unsynced(place / fmt::format("{}_{:03}.b.png", name, number), render::encode_png(b));
    }

    void print() const {
        int sum = 0;
        for (const auto& [kind, count] : counts_) {
            std::printf("%-28s %4d\n", kind.c_str(), count);
            sum += count;
        }
        std::printf("%-28s %4d\n", "pairs", sum);
    }

private:
    fs::path folder_;
    bool has_seen_;
    std::map<std::string, int> counts_;
};

/// Where a body is seen [px], and how many pixels show it.
struct Seen {
    double x = 0, y = 0;
    int pixels = 0;
};

std::vector<Seen> seen_bodies(const Drawing& d) {
    render::RenderSettings settings = render::render_settings(d.scene.output);
    render::Renderer renderer(d.scene, d.width, d.height, settings);
    renderer.draw(d.snapshot);
    std::vector<Seen> seen(d.scene.bodies.size());
    const std::vector<std::uint32_t> ids = renderer.body_ids();
    for (std::size_t i = 0; i < ids.size(); ++i) {
        if (ids[i] > 0) {
            Seen& s = seen[ids[i] - 1];
            s.x += static_cast<double>(i % static_cast<std::size_t>(d.width));
            s.y += static_cast<double>(i / static_cast<std::size_t>(d.width));
            ++s.pixels;
        }
    }
    for (Seen& s : seen) {
        s.x /= std::max(s.pixels, 1);
        s.y /= std::max(s.pixels, 1);
    }
    return seen;
}

class Pairs {
public:
    Pairs(Corpus& corpus, const std::string& name, Drawing drawing, unsigned seed)
        : corpus_(corpus), name_(name), base_(std::move(drawing)), random_(seed), picture_(draw(base_)),
          large_(world_of(base_, 4)) {}

    void add_noise() {
        const auto all = [](int, int) { return true; };
        const std::pair<const char*, std::function<bool(int, int)>> patterns[] = {
            {"grid of 16", all},
            {"rotated 4", [](int x, int y) { return (x * 2 + 1) % 5 == y + (x > 1); }},
            {"middle 4", [](int x, int y) { return x % 3 != 0 && y % 3 != 0; }},
            {"chequered 8", [](int x, int y) { return (x + y) % 2 == 0; }},
        };
        // Rods thinner than a pixel are drawn one pixel wide: in the larger picture they are thinner.
        if (base_.scene.joints.empty()) {
            for (const auto& [what, takes] : patterns) {
                add("noise samples", sampled_text(large_, takes));
            }
            Image moved = large_;
            std::rotate(moved.rgb.begin(), moved.rgb.begin() + moved.width * 3, moved.rgb.end());
            corpus_.add("noise view by a quarter pixel", name_, sampled_text(large_, all), sampled_text(moved, all));
        }
        Drawing hard = base_;
        hard.smooth_edges = false;
        add("noise no smooth edges", draw(hard));
        std::uniform_real_distribution<double> uniform;
        add("noise levels", each_channel(picture_, [&](double v) { return uniform(random_) < 0.1 ? v + (uniform(random_) < 0.5 ? 1 : -1) : v; }));
        std::normal_distribution<double> normal;
        add("noise grain", each_channel(picture_, [&](double v) { return v + 1.5 * normal(random_); }));
    }

    void add_films() {
        const auto as_film = [this](const Drawing& d, int crf, const char* preset) { return filmed(d, corpus_.folder(), crf, preset); };
        const Image good = as_film(base_, 18, "veryfast");
        corpus_.add("noise film of another crf", name_, good, as_film(base_, 23, "ultrafast"));
        corpus_.add("noise film of a far crf", name_, good, as_film(base_, 28, "veryfast"));
        corpus_.add("noise film and its frames", name_, picture_, good);
        for_bodies(1, [&](std::size_t body) {
            const Drawing elsewhere = moved(body, 2.0);
            if (is_seen(elsewhere)) {
                corpus_.add("changed film body moved 2 px", name_, good, as_film(elsewhere, 23, "ultrafast"));
            }
            if (is_seen(without(body))) {
                corpus_.add("changed film body missing", name_, good, as_film(without(body), 18, "veryfast"));
            }
        });
        if (is_seen(lit(1.1))) {
            corpus_.add("changed film sun 10 %", name_, good, as_film(lit(1.1), 18, "veryfast"));
            corpus_.add("changed film view 2 px", name_, good, as_film(opened(2.0), 23, "veryfast"));
        }
    }

    /// 85 and 90 have their colours at half the size, 95 has not.
    void add_jpegs() {
        const Image good = as_jpeg(picture_, 95);
        const Image small = as_jpeg(picture_, 85);
        corpus_.add("noise JPEG of another quality", name_, good, small);
        corpus_.add("noise JPEG and its picture", name_, picture_, as_jpeg(picture_, 90));
        for_bodies(1, [&](std::size_t body) {
            const Drawing elsewhere = moved(body, 2.0);
            if (is_seen(elsewhere)) {
                corpus_.add("changed JPEG body moved 2 px", name_, good, as_jpeg(draw(elsewhere), 85));
            }
            if (is_seen(without(body))) {
                corpus_.add("changed JPEG body missing", name_, small, as_jpeg(draw(without(body)), 85));
            }
        });
        if (is_seen(lit(1.1))) {
            corpus_.add("changed JPEG sun 10 %", name_, small, as_jpeg(draw(lit(1.1)), 85));
        }
    }

    void add_bodies() {
        for_bodies(3, [&](std::size_t body) {
            add("changed body moved 1 px", draw(moved(body, 1.0)));
            add("changed body moved 2 px", draw(moved(body, 2.0)));
            add("changed body missing", draw(without(body)));
            Drawing d = base_;
            std::swap(d.scene.bodies[body].look.color.x(), d.scene.bodies[body].look.color.z());
            if ((d.scene.bodies[body].look.color - base_.scene.bodies[body].look.color).norm() > 0.1) {
                add("changed body recoloured", draw(d));
            }
            if (base_.scene.joints.empty()) {
                Image large = world_of(moved(body, 2.0), 4);
                add("changed body moved 2 px in noise", sampled_text(large, [](int, int) { return true; }));
            }
        });
    }

    void add_light() {
        for (const double factor : {0.98, 0.99, 1.01, 1.02}) {
            add(fmt::format("changed sun {:+.0f} %", 100 * (factor - 1)), draw(lit(factor)));
        }
        Drawing d = base_;
        d.scene.light.sky_intensity *= 1.03;
        add("changed sky 3 %", draw(d));
        add("changed one level up", each_channel(picture_, [](double v) { return v + 1; }));
        add("changed gain 3 %", each_channel(picture_, [](double v) { return v * 1.03; }));
        add("changed gamma", each_channel(picture_, [](double v) { return 255 * std::pow(v / 255, 1.03); }));
    }

    void add_sharpness() {
        add("changed half resolution", with_text(half_resolution(world_of(base_, 1)), base_));
        add("changed blur", filtered(picture_, 0.25, 0.125, 0.0625));
        add("changed sharpened", filtered(picture_, 2.0, -0.25, 0.0));
    }

    void add_text() {
        const auto retold = [&](const std::string& kind, const std::function<void(Drawing&)>& edit) {
            Drawing d = base_;
            edit(d);
            const Image other = with_text(world_of(base_, 1), d);
            add(kind, other);
        };
        retold("changed digit", [](Drawing& d) { d.snapshot.time += 0.01; });
        retold("changed digit", [](Drawing& d) { d.snapshot.time += 0.05; });
        retold("changed digit", [](Drawing& d) { d.snapshot.time += 3.0; });
        retold("changed title", [](Drawing& d) { d.scene.title[d.scene.title.size() / 2] ^= 2; });
        if (base_.scene.joints.empty()) {
            Drawing d = base_;
            d.snapshot.time += 0.03;
            add("changed digit in noise", with_text(sampled(large_, 4, [](int x, int y) { return (x + y) % 2 == 0; }), d));
        }
        Image salt = picture_;
        for (int i = 0; i < salt.width * salt.height / 1000; ++i) {
            const auto pixel = random_() % static_cast<unsigned>(salt.width * salt.height);
            std::fill_n(salt.rgb.begin() + static_cast<long>(pixel) * 3, 3, std::uint8_t{255});
        }
        add("changed salt", salt);
        Image block = picture_;
        const int x = static_cast<int>(random_() % static_cast<unsigned>(block.width - 8));
        const int y = static_cast<int>(random_() % static_cast<unsigned>(block.height - 8));
        for (int k = 0; k < 64; ++k) {
            std::uint8_t* rgb = &block.rgb[static_cast<std::size_t>(((y + k / 8) * block.width + x + k % 8) * 3)];
            std::fill_n(rgb, 3, static_cast<std::uint8_t>(rgb[1] ^ 0x40));
        }
        add("changed block of 8x8", block);
    }

    void add_view() {
        for (const double px : {1.0, 3.0}) {
            add(fmt::format("changed view {:.0f} px", px), draw(opened(px)));
        }
    }

    /// Bodies a tenth of the way to white.
    void add_paler() {
        for_bodies(2, [&](std::size_t body) {
            Drawing d = base_;
            sim::Vec3& color = d.scene.bodies[body].look.color;
            color += 0.1 * (sim::Vec3::Ones() - color);
            add("changed body a little paler", draw(d));
        });
    }

private:
    /// False of what a title card hides: of that, an encoder's noise shows nothing.
    bool is_seen(const Drawing& other) const { return draw(other).rgb != picture_.rgb; }

    void add(const std::string& kind, const Image& other) { corpus_.add(kind, name_, picture_, other); }

    Image sampled_text(const Image& large, const std::function<bool(int, int)>& takes) const {
        return with_text(sampled(large, 4, takes), base_);
    }

    Drawing without(std::size_t body) const {
        Drawing d = base_;
        d.scene.bodies[body].look.visible = false;
        return d;
    }

    Drawing lit(double factor) const {
        Drawing d = base_;
        d.scene.light.sun_intensity *= factor;
        return d;
    }

    /// Seen by a camera that opens wider, by about so many pixels at the corners.
    Drawing opened(double px) const {
        Drawing d = base_;
        const double wider = 1.0 + px / (0.35 * d.height);
        for (sim::CameraDef& camera : d.scene.cameras) {
            camera.fov_degrees *= wider;
            for (sim::CameraKey& key : camera.keys) {
                key.fov_degrees *= wider; // 0 is the camera's
            }
        }
        return d;
    }

    /// A body moved by about so many pixels, across or up.
    Drawing moved(std::size_t body, double px) const {
        const Seen before = seen_bodies(base_)[body];
        const sim::Vec3 way = body % 2 == 0 ? sim::Vec3::UnitX() : sim::Vec3::UnitZ();
        double length = 1e-3;
        for (int i = 0; i < 4; ++i) {
            Drawing d = base_;
            d.snapshot.bodies[body].position += length * way;
            const Seen after = seen_bodies(d)[body];
            const double shift = std::hypot(after.x - before.x, after.y - before.y);
            length *= std::clamp(px / std::max(shift, 0.05), 0.2, 10.0);
        }
        Drawing d = base_;
        d.snapshot.bodies[body].position += length * way;
        return d;
    }

    /// Calls use(body) for some that move and are well seen.
    void for_bodies(int count, const std::function<void(std::size_t)>& use) {
        const std::vector<Seen> seen = seen_bodies(base_);
        std::vector<std::size_t> bodies;
        for (std::size_t i = 0; i < seen.size(); ++i) {
            if (!base_.scene.bodies[i].is_static() && seen[i].pixels >= 60) {
                bodies.push_back(i);
            }
        }
        std::shuffle(bodies.begin(), bodies.end(), random_);
        bodies.resize(std::min<std::size_t>(bodies.size(), static_cast<std::size_t>(count)));
        std::for_each(bodies.begin(), bodies.end(), use);
    }

    Corpus& corpus_;
    std::string name_;
    Drawing base_;
    std::mt19937 random_;
    Image picture_;
    Image large_;
};

} // namespace

int main(int argc, char** argv) {
    if (argc < 4) {
        std::fprintf(stderr, "usage: judge_corpus FOLDER SEED SCENE.toml...\n");
        return 2;
    }
    const auto seed = static_cast<unsigned>(std::strtoul(argv[2], nullptr, 10));
    Corpus corpus(argv[1], seed == 0);
    std::mt19937 random(seed);
    for (int i = 3; i < argc; ++i) {
        const std::vector<std::string> text{"overlay.show=[\"title\",\"time\"]"};
        const sim::SceneDef scene = sim::load_scene(argv[i], text);
        sim::World world(scene, 1);
        for (auto [time, height] : {std::pair{0.0, 360}, {0.3, 180}, {0.6, 360}}) {
            time += seed == 0 ? 0.0 : 0.3 * random() / 4294967296.0;
            while (world.time() < time) {
                world.step();
            }
            Drawing drawing{scene, world.take_snapshot(), height * 16 / 9, height};
            Pairs pairs(corpus, fs::path(argv[i]).stem().string(), drawing, seed * 1000 + static_cast<unsigned>((i - 1) * 10 + height));
            pairs.add_noise();
            pairs.add_films();
            pairs.add_bodies();
            pairs.add_light();
            pairs.add_sharpness();
            pairs.add_text();
            pairs.add_view();
            pairs.add_jpegs();
            pairs.add_paler(); // last: those before keep their random numbers
        }
    }
    std::filesystem::remove(corpus.folder() / "film.mp4");
    corpus.print();
    return 0;
}
