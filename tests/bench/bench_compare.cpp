/// Processor time of `tumble compare` for a pair of 1920x1080 pictures within a run of many, on one core; beside odiff,
/// where its program is given. Arguments: TUMBLE [ODIFF].
#include "render/compare/picture.h"
#include "sim/base/file_io.h"
#include "tests/compare/painter.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <sys/resource.h>
#include <vector>

namespace {

namespace fs = std::filesystem;

constexpr int pair_count = 100;

/// [ms] of user and system, of all children so far.
double child_ms() {
    rusage use{};
    getrusage(RUSAGE_CHILDREN, &use);
    const auto ms = [](const timeval& t) { return 1e3 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_usec); };
    return ms(use.ru_utime) + ms(use.ru_stime);
}

/// [ms] of one command, its shell included.
double time_of(const std::string& command) {
    const double start = child_ms();
    if (std::system((command + " >/dev/null 2>&1").c_str()) < 0) {
        std::perror("system");
        std::exit(3);
    }
    return child_ms() - start;
}

void write_folder(const fs::path& folder, const diff::Bytes& png) {
    fs::create_directories(folder);
    sim::write_file(folder / "frame_000.png", png);
    for (int i = 1; i < pair_count; ++i) {
        fs::create_hard_link(folder / "frame_000.png", folder / ("frame_" + std::to_string(1000 + i).substr(1) + ".png"));
    }
}

/// The same pixels in other bytes: with a text before the last part.
diff::Bytes with_text(diff::Bytes png) {
    const diff::Bytes text{0, 0, 0, 3, 't', 'E', 'X', 't', 'a', 0, 'b', 0xdc, 0x49, 0xa2, 0x3b};
    png.insert(png.end() - 12, text.begin(), text.end());
    return png;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_compare TUMBLE [ODIFF]\n");
        return 2;
    }
    const std::string tumble = argv[1];
    const fs::path folder = fs::path(TUMBLE_OUT_DIR) / "bench" / "compare";
    fs::remove_all(folder);
    test::Scene scene = test::make_scene(1, 300, 5);
    scene.width = 1920;
    scene.height = 1080;
    for (test::Shape& s : scene.shapes) {
        s.x *= 6;
        s.y *= 6;
        s.size *= 3;
    }
    const diff::Picture picture = test::paint(scene, test::grid_pattern(2));
    const diff::Bytes png = diff::encode_png(picture);
    test::Scene moved = scene;
    moved.shapes[250].x += 40;
    write_folder(folder / "reference", png);
    write_folder(folder / "equal", png);
    write_folder(folder / "resaved", with_text(png));
    write_folder(folder / "moved", diff::encode_png(test::paint(moved, test::grid_pattern(2))));
    write_folder(folder / "noise", diff::encode_png(test::paint(scene, test::rotated_pattern)));
    write_folder(folder / "brighter", diff::encode_png(test::each_channel(picture, [](double v) { return 1.05 * v; })));

    const auto path = [&folder](const char* name) { return " '" + (folder / name).string() + "'"; };
    const std::string one = "/frame_000.png'";
    const auto file = [&](const char* name) { return " '" + (folder / name).string() + one; };
    const double shell = time_of("true");
    std::printf("start-up: %.1f ms\n", time_of(tumble + " compare --quiet" + file("reference") + file("equal")) - shell);
    std::printf("%-26s %12s %12s %12s\n", "processor time [ms/pair]", "tumble", "with report", argc > 2 ? "odiff" : "");
    for (const char* name : {"equal", "resaved", "noise", "moved", "brighter"}) {
        const std::string ours = tumble + " compare --quiet --threads 1" + path("reference") + path(name);
        std::printf("%-26s %12.2f %12.2f", name, time_of(ours) / pair_count,
                    time_of(ours + " --report" + path("report")) / pair_count);
        if (argc > 2) {
            constexpr int repeats = 10;
            double theirs = 0;
            for (int i = 0; i < repeats; ++i) {
                theirs += time_of(std::string(argv[2]) + file("reference") + file(name) + " '" + (folder / "odiff.png").string() + "'") - shell;
            }
            std::printf(" %12.2f", theirs / repeats);
        }
        std::printf("\n");
        std::fflush(stdout);
    }
    fs::remove_all(folder);
    return 0;
}
