// The same bits from every instruction set: whole runs, so that every kernel takes part.
#include "tests/program/program_fixture.h"

using test::Program;

TEST_F(Program, motion_is_the_same_on_every_instruction_set) {
    // A heap large enough that its sweeps are extrapolated; its cubes land tilted, on faces and edges.
    const auto hash_on = [&](const std::string& set) {
        const test::Outcome run =
            shell("TUMBLE_KERNELS=" + set + " \"$TUMBLE\" simulate '" TUMBLE_SCENE_DIR "/funnel.toml' --quiet --out " + set +
                  " --duration 1.25 --set 'lattice.cube.count=[7,7,7]' --set 'lattice.cube.origin=[-3.9,-3.9,13]' && "
                  "grep state_hash " + set + "/funnel/summary.json");
        EXPECT_EQ(run.code, 0) << run.err;
        return run.out;
    };
    const std::string widest = hash_on("widest"); // what no set is named: the processor's own
    EXPECT_FALSE(widest.empty());
    EXPECT_EQ(hash_on("avx2"), widest);
    EXPECT_EQ(hash_on("baseline"), widest);
}
