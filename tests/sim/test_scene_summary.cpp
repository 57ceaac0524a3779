#include "sim/scene/summary.h"

#include "sim/scene/file.h"

#include <gtest/gtest.h>

using namespace sim;

TEST(scene_summary, tells_what_the_funnel_contains) {
    const std::vector<std::string> overrides{"output.fps=24000/1001"};
    const SceneDef scene = load_scene(std::filesystem::path(TUMBLE_SCENE_DIR) / "funnel.toml", overrides);
    // 143.86 frames become 144; the steps are those of 6 s.
    EXPECT_EQ(describe_scene(scene), R"(funnel: 1000 cubes fall into a funnel
  bodies      1000 dynamic (1000 boxes), 5 static (1 plane, 4 boxes)
  mass        1e+06 kg
  joints      none
  steps       6000 of 0.001 s; 6 s
  frames      144 of 1280 x 720 at 24000/1001 a second
  trajectory  one record a frame
  gravity     0 0 -9.81 m/s^2
  tolerances  0.0001 m contact, 1e-10 m joint, 0.05 m/s impact, at most 200 sweeps
  model       contacts: 1000 moving bodies, 1005 in all
              restitution: 0.48
              friction: 0.1
              contacts ahead of impacts: elastic bodies (restitution 0.9 or more): none
              warm start: simulation.warm_start is true
  not used    joints, springs, motors, kinematic bodies, bodies released later, support points (libccd), compounds, gyroscopic term, stop at impacts
  cameras     'main' (3 keys), 'top' (fixed), 'orbit' (orbit in 24 s)
  set         output.fps=24000/1001
)");
}

TEST(scene_summary, tells_what_the_parts_of_the_model_are) {
    const SceneDef scene = parse_scene(R"(
[simulation]
time_step = "1/240"
impacts = "stop"
warm_start = false
[output]
record_every = 5
camera = "b"
[[body]]
name = "ball"
shape = { kind = "sphere", radius = 1 }
mass = 2.5
mu_s = 0.4
mu_d = 0.3
[[body]]
name = "other"
shape = { kind = "sphere", radius = 1 }
position = [5, 0, 0]
mass = 2
mu_s = 0.2
mu_d = 0.1
[[joint]]
name = "rope"
kind = "ball"
bodies = ["ball"]
anchor = [0, 0, 3]
[[camera]]
name = "a"
kind = "orbit"
eye = [1, 0, 0]
target = [0, 0, 0]
[[camera]]
name = "b"
kind = "follow"
body = "ball"
eye = [1, 0, 0]
target = [0, 0, 0]
)",
                                       "s.toml");
    EXPECT_EQ(describe_scene(scene), R"(s
  bodies      2 dynamic (2 spheres), 0 static
  mass        4.5 kg
  joints      1 ball, 1 to the world
  steps       1440 of 1/240 s; 6 s
  frames      360 of 1280 x 720 at 60 a second
  trajectory  one record every 5 steps
  gravity     0 0 -9.81 m/s^2
  tolerances  0.0001 m contact, 1e-10 m joint, 1e-07 m/s impact, at most 2000 sweeps
  model       contacts: 2 moving bodies, 2 in all
              friction: static 0.2 to 0.4, dynamic 0.1 to 0.3
              joints: 1 ball
              stop at impacts: simulation.impacts is "stop"
  not used    restitution, springs, motors, kinematic bodies, bodies released later, support points (libccd), compounds, gyroscopic term, contacts ahead of impacts, warm start
  cameras     'a' (orbit in 20 s), 'b' (follows a body, chosen)
)");
}
