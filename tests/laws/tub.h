#pragma once
/// A scene that laws and benchmarks share.

namespace laws {

/// Shapes of four kinds fall into a tub.
inline constexpr const char* tub = R"(
[simulation]
time_step = "1/1000"
velocity_tolerance = 0.05
[[body]]
name = "floor"
shape = { kind = "plane" }
static = true
[[lattice]]
name = "wall_x"
count = [2, 1, 1]
spacing = [2.5, 1, 1]
origin = [-1.25, 0, 2]
[lattice.body]
shape = { kind = "box", size = [0.4, 6, 4] }
static = true
[[lattice]]
name = "wall_y"
count = [1, 2, 1]
spacing = [1, 2.5, 1]
origin = [0, -1.25, 2]
[lattice.body]
shape = { kind = "box", size = [6, 0.4, 4] }
static = true
[[lattice]]
name = "piece"
count = [4, 4, 4]
spacing = [0.52, 0.52, 0.52]
origin = [-0.78, -0.78, 0.4]
jitter = [0.01, 0.01, 0.01]
turn_max_degrees = 180
[lattice.body]
shape = { kind = "sphere", radius = 0.2 }
restitution = 0.3
friction = 0.4
[[lattice.mix]]
shape = { kind = "box", size = [0.26, 0.26, 0.26] }
restitution = 0.3
friction = 0.4
[[lattice.mix]]
shape = { kind = "capsule", radius = 0.1, length = 0.25 }
restitution = 0.3
friction = 0.4
[[lattice.mix]]
shape = { kind = "cylinder", radius = 0.15, length = 0.25 }
restitution = 0.3
friction = 0.4
)";

} // namespace laws
