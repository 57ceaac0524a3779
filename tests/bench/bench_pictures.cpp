/// Wall and processor time of the pictures of the funnel's film by preset and of a film with motion blur; of the funnel's
/// whole run beside simulation and pictures alone; of a PNG beside stb's. Arguments: TUMBLE [REPEATS]. Writes out/bench/pictures.md.
#include "render/film/film.h"
#include "render/picture/image.h"
#include "sim/base/cores.h"
#include "sim/base/file_io.h"

#include <fmt/format.h>
#include <stb_image_write.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <limits>
#include <regex>
#include <string>
#include <sys/resource.h>
#include <vector>

namespace {

namespace fs = std::filesystem;

const fs::path folder = fs::path(TUMBLE_OUT_DIR) / "bench" / "pictures";

const fs::path printed = folder / "printed.txt"; ///< by the last command

/// Of one command, start-up included [ms].
struct Times {
    double wall = std::numeric_limits<double>::max();
    double processor = 0.0; ///< user and system, of all cores
};

double child_ms() {
    rusage use{};
    getrusage(RUSAGE_CHILDREN, &use);
    const auto ms = [](const timeval& t) {
        return 1e3 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_usec);
    };
    return ms(use.ru_utime) + ms(use.ru_stime);
}

Times time_of(const std::string& command) {
    const double processor = child_ms();
    const auto start = std::chrono::steady_clock::now();
    if (std::system((command + " >'" + printed.string() + "' 2>/dev/null").c_str()) != 0) {
        std::fprintf(stderr, "failed: %s\n", command.c_str());
        std::exit(3);
    }
    const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
    return {wall.count(), child_ms() - processor};
}

/// The repetition with the least wall time.
Times best_of(int repeats, const std::string& command) {
    Times best;
    for (int i = 0; i < repeats; ++i) {
        const Times times = time_of(command);
        best = times.wall < best.wall ? times : best;
    }
    return best;
}

struct Film {
    const char* name;
    const char* scene;
    const char* options;
    double goal; ///< [ms] wall a frame
};
constexpr Film films[] = {{"standard, 1280x720", "funnel", "", 24.0},
                          {"draft, 1280x720", "funnel", " --preset draft", 15.0},
                          {"standard, 1920x1080", "funnel", " --size 1920x1080", 42.0},
                          {"tippe top, 16 sub-frames", "tippe_top", "", 69.0}}; // 25 s

/// Least processor time of this thread in some repetitions [ms].
template <class Work>
double thread_ms(const Work& work) {
    const auto now = [] {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
    };
    double least = std::numeric_limits<double>::max();
    for (int i = 0; i < 5; ++i) {
        const double start = now();
        work();
        least = std::min(least, now() - start);
    }
    return least;
}

std::string png_rows(int frame_count) {
    std::string rows;
    for (int frame = 0; frame < frame_count; frame += frame_count / 4) {
        const render::Image image =
            render::read_image(folder / "2" / "funnel" / render::frame_file_name(frame));
        std::size_t bytes = 0;
        const double ours = thread_ms([&] { bytes = render::encode_png(image).size(); });
        std::vector<std::uint8_t> file;
        const auto take = [](void* to, void* data, int size) {
            const auto* begin = static_cast<const std::uint8_t*>(data);
            static_cast<std::vector<std::uint8_t>*>(to)->assign(begin, begin + size);
        };
        const double stb = thread_ms([&] {
            stbi_write_png_to_func(take, &file, image.width, image.height, 3, image.rgb.data(),
                                   3 * image.width);
        });
        rows += fmt::format("| {} | {:.1f} | {} | {:.1f} | {} |\n", frame, ours, bytes / 1000, stb,
                            file.size() / 1000);
    }
    return rows;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: bench_pictures TUMBLE [REPEATS]\n");
        return 2;
    }
    const std::string tumble = argv[1];
    const int repeats = argc > 2 ? std::atoi(argv[2]) : 2;
    fs::remove_all(folder);
    fs::create_directories(folder);
    const std::string scene = TUMBLE_SCENE_DIR "/funnel.toml";
    const auto out = [](const std::string& name) { return " --out '" + (folder / name).string() + "'"; };

    const Times simulation = best_of(1, tumble + " simulate '" + scene + "'" + out("sim"));
    best_of(1, tumble + " simulate '" TUMBLE_SCENE_DIR "/tippe_top.toml'" + out("sim"));
    constexpr int frame_count = 360; // of each film
    std::string text = fmt::format(
        "# Films of {} frames, {} cores, the best of {}\n\n"
        "PNG and MP4 written, start-up included; [ms] a frame.\n\n"
        "| film | wall | goal | processor | list | draw | edges | png | video | pixels in threads of their own, start-up |\n"
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n",
        frame_count, sim::core_count(), repeats);
    double pictures = 0.0;
    for (std::size_t i = 0; i < std::size(films); ++i) {
        const Film& film = films[i];
        const std::string trajectory = (folder / "sim" / film.scene / "trajectory.h5").string();
        const Times times =
            best_of(repeats, tumble + " render '" + trajectory + "'" + film.options + out(std::to_string(i)));
        const std::string stages = sim::read_text_file(printed);
        std::string columns;
        double sum = 0.0;
        for (const char* stage : {"list", "draw", "edges", "png", "video"}) {
            std::smatch found;
            std::regex_search(stages, found, std::regex(stage + std::string(" ([0-9.]+)")));
            const double ms = std::stod(found[1]);
            columns += fmt::format(" {:.1f} |", ms);
            sum += ms;
        }
        text += fmt::format("| {} | {:.1f} | {:.0f} | {:.1f} |{} {:.1f} |\n", film.name,
                            times.wall / frame_count, film.goal, times.processor / frame_count, columns,
                            times.processor / frame_count - sum);
        std::printf("%s: %.1f ms a frame\n", film.name, times.wall / frame_count);
        std::fflush(stdout);
        pictures = i == 0 ? times.wall : pictures;
    }
    const Times all = best_of(1, tumble + " run '" + scene + "'" + out("run"));
    text += fmt::format("\n| the funnel's film | wall [s] |\n| --- | --- |\n| simulation alone | {:.1f} |\n"
                        "| pictures alone | {:.1f} |\n| both together | {:.1f} |\n"
                        "| share of the larger (goal 1.3) | {:.2f} |\n",
                        1e-3 * simulation.wall, 1e-3 * pictures, 1e-3 * all.wall,
                        all.wall / std::max(simulation.wall, pictures));
    text += "\n| 1920x1080, frame | PNG [ms of one core] | kB | stb's PNG [ms] | kB |\n| --- | --- | --- | "
            "--- | --- |\n" +
            png_rows(frame_count);
    sim::write_file(folder.parent_path() / "pictures.md", text);
    std::printf("\n%s", text.c_str());
    return 0;
}
