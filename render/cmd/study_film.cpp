#include "render/cmd/study_film.h"

#include "render/cmd/workplace.h"
#include "render/film/film.h"
#include "render/film/panels.h"
#include "render/film/thread_group.h"
#include "render/film/video_writer.h"
#include "sim/scene/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>

namespace cmd {

namespace fs = std::filesystem;

namespace {

constexpr int panel_width = 480, panel_height = 270; // [px]
constexpr int film_fps = 30;
constexpr std::size_t most_panels = 4;

std::vector<std::string> labels_of(const study::Plan& plan, const study::Row& row) {
    return {fmt::format("{}: {}{}", row.engine, row.knob.empty() ? "" : row.knob + " ", row.value),
            fmt::format("{:.3g} s a second, error {:.2g}{}, overlap {:.1g} m", row.cost, row.error,
                        plan.is_statistical() ? "" : " m", row.overlap)};
}

/// The scene of a task as the panel shows it.
sim::SceneDef panel_scene(const study::Plan& plan, const study::Task& task) {
    std::vector<std::string> overrides = task.overrides;
    for (const std::string& more :
         {fmt::format("output.width={}", panel_width), fmt::format("output.height={}", panel_height),
          fmt::format("output.fps={}", film_fps), std::string("overlay.show=[]")}) {
        overrides.push_back(more);
    }
    return sim::load_scene(plan.scene_file, overrides);
}

std::int64_t frames_of(const sim::SceneDef& scene) {
    return sim::frame_count(scene.output.duration, scene.output.fps);
}

} // namespace

std::vector<Panel> choose_panels(const study::Plan& plan, const study::Table& table) {
    int cheapest = -1, best = -1;
    std::vector<int> chosen;
    for (int i = 0; i < static_cast<int>(table.rows.size()); ++i) {
        const study::Row& row = table.rows[static_cast<std::size_t>(i)];
        if (row.status != study::Status::done) {
            continue;
        }
        if (row.knob.empty()) {
            chosen.push_back(i);
        } else if (row.engine == table.rows.front().engine && row.is_on_front) {
            const auto at = [&](int k) -> const study::Row& { return table.rows[static_cast<std::size_t>(k)]; };
            cheapest = cheapest < 0 || row.cost < at(cheapest).cost ? i : cheapest;
            best = best < 0 || row.error < at(best).error ? i : best;
        }
    }
    for (const int extra : {cheapest, best}) {
        if (extra >= 0 && std::find(chosen.begin(), chosen.end(), extra) == chosen.end()) {
            chosen.push_back(extra);
        }
    }
    chosen.resize(std::min(chosen.size(), most_panels));
    std::vector<Panel> panels;
    for (const int i : chosen) {
        const study::Row& row = table.rows[static_cast<std::size_t>(i)];
        panels.push_back({i, plan.tasks[static_cast<std::size_t>(row.task)].name, labels_of(plan, row)});
    }
    return panels;
}

void draw_panel(const study::Plan& plan, const study::Task& task, const study::EngineKind& engine,
                const fs::path& folder, std::atomic<std::int64_t>& steps_done) {
    const sim::SceneDef scene = panel_scene(plan, task);
    study::Engine world = engine.make(scene, task.setting.variant);
    make_folder(folder / "frames");
    render::Film film(scene, {.folder = folder, .write_video = false});
    render::ThreadGroup threads; // ends before what its threads use
    film.start(threads);
    threads.start([&] {
        std::int64_t step = 0;
        for (std::int64_t k = 0; k < frames_of(scene); ++k) {
            const std::int64_t wanted = sim::step_of_frame(k, scene.output.fps, scene.step.time_step);
            for (; step < wanted; ++step) {
                world.step();
                ++steps_done;
            }
            if (!film.add(k, std::make_shared<const sim::Snapshot>(world.snapshot()))) {
                return;
            }
        }
        film.close();
    });
    threads.join();
}

void join_panels(const study::Plan& plan, std::span<const Panel> panels, const fs::path& folder) {
    render::Font font;
    std::vector<render::Panel> pictures;
    for (const Panel& panel : panels) {
        pictures.push_back({{}, panel.labels});
    }
    const render::PanelSize size{panel_width, panel_height, label_height(pictures, panel_width, font)};
    const render::PanelSize whole = render::arranged_size(size, panels.size());
    const std::int64_t frames = sim::frame_count(plan.scene.output.duration, {film_fps, 1});
    render::VideoSettings settings = render::video_settings(plan.scene);
    settings.fps = {film_fps, 1};
    settings.crf = 23; // a page holds the film
    settings.encoder = render::automatic_encoder;
    settings.bits = 8;
    render::VideoWriter video(folder / "film.mp4", whole.width, whole.height, settings);
    for (std::int64_t k = 0; k < frames; ++k) {
        for (std::size_t i = 0; i < panels.size(); ++i) {
            pictures[i].picture = render::read_image(folder / panels[i].name / render::frame_file_name(k));
        }
        video.add(render::arranged(pictures, size, font));
    }
    video.finish();
}

} // namespace cmd
