/// steps SCENE N [KEY=VALUE...]: N steps of a scene on one thread, and nothing else, for counting instructions.
#include "sim/base/error.h"
#include "sim/scene/file.h"
#include "sim/world/world.h"

#include <fmt/format.h>

#include <cstdlib>

int main(int argc, char** argv) {
    if (argc < 3) {
        fmt::print(stderr, "usage: steps SCENE N [KEY=VALUE...]\n");
        return 2;
    }
    try {
        const std::vector<std::string> overrides(argv + 3, argv + argc);
        sim::World world(sim::load_scene(argv[1], overrides), 1);
        for (long i = std::strtol(argv[2], nullptr, 10); i > 0; --i) {
            world.step();
        }
        fmt::print("{:016x}\n", sim::state_hash(world.take_snapshot()));
        return 0;
    } catch (const sim::Error& error) {
        fmt::print(stderr, "steps: {}\n", error.what());
        return static_cast<int>(error.code());
    }
}
