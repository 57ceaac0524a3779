/// Random scenes as a film-maker might write them, at nearly default settings: 8 to 40 bodies of all shapes, of sizes to 1 : 10,
/// aspects to 30 and densities to 1 : 100, chains of joints, in tubs with upright and leaning walls, from 1/2000 to 1/240 s a
/// step.
#include "sim/base/random.h"
#include "sim/scene/file.h"
#include "tests/laws/law_scene.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

namespace {

using namespace laws;

/// Each draw is a statement of its own: compilers differ in the order of arguments.
class Generator {
public:
    explicit Generator(int seed) : random_(static_cast<std::uint64_t>(seed)) {}

    std::string scene() {
        size_ = spread(0.03, 1.0);
        aspect_ = is(0.5) ? 2.0 : spread(2.0, 30.0);
        friction_ = is(0.1) ? 0.0 : spread(0.05, 1.2);
        restitution_ = is(0.5) ? 0.0 : between(random_, 0.0, 0.8);
        has_many_materials_ = is(0.3);
        const char* const steps[] = {"1/2000", "1/1000", "1/1000", "1/500", "1/240"};
        std::string text = fmt::format("[simulation]\ntime_step = \"{}\"\n", steps[below(5)]);
        text += fmt::format("impacts = \"{}\"\n", is(0.15) ? "stop" : "ahead");
        text += is(0.4) ? "velocity_tolerance = 0.02\n" : "";
        text += is(0.2) ? "tolerance = 1e-3\n" : "";
        cell_ = 2.6 * size_ * std::sqrt(aspect_);
        text += tub();
        text += bodies();
        return text;
    }

private:
    bool is(double probability) { return random_.uniform() < probability; }
    int below(int end) { return std::min(static_cast<int>(random_.uniform() * end), end - 1); }
    /// Evenly on a logarithmic scale.
    double spread(double low, double high) { return low * std::pow(high / low, random_.uniform()); }
    double within(double length) { return between(random_, -length, length); }
    static std::string list(const Vec3& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }
    std::string vector(double length) {
        const double x = within(length), y = within(length), z = within(length);
        return list({x, y, z});
    }
    std::string surface() {
        const double friction = has_many_materials_ ? random_.uniform() : friction_;
        const double restitution = has_many_materials_ ? between(random_, 0.0, 0.6) : restitution_;
        return fmt::format("friction = {}\nrestitution = {}\n", friction, restitution);
    }

    /// kinds: the first so many of all. place: more keys.
    std::string shape(double size, int kinds, const std::string& place = "") {
        const auto length = [&] { return size * spread(1.0 / std::sqrt(aspect_), std::sqrt(aspect_)); };
        const double x = length(), y = length(), z = length();
        switch (below(kinds)) {
        case 0:
            return fmt::format("{{ kind = \"box\", size = [{}, {}, {}]{} }}", x, y, z, place);
        case 1:
            return fmt::format("{{ kind = \"sphere\", radius = {}{} }}", 0.5 * x, place);
        case 2:
            return fmt::format("{{ kind = \"cylinder\", radius = {}, length = {}{} }}", 0.5 * x, y, place);
        case 3:
            return fmt::format("{{ kind = \"capsule\", radius = {}, length = {}{} }}", 0.3 * x, 0.7 * y, place);
        case 4: {
            const int corners = 4 + below(30), seed = below(1000);
            return fmt::format("{{ kind = \"rock\", size = [{}, {}, {}], corners = {}, seed = {} }}", x, y, z, corners, seed);
        }
        case 5: {
            std::string points;
            for (int i = 4 + below(8); i > 0; --i) {
                points += vector(0.5 * size) + ", ";
            }
            return fmt::format("{{ kind = \"hull\", points = [{}] }}", points);
        }
        default: {
            const std::string one = shape(0.5 * size, 4, fmt::format(", position = [{}, 0, 0]", 0.3 * size));
            const std::string other = shape(0.5 * size, 4, fmt::format(", position = [0, {}, 0]", within(0.3 * size)));
            return fmt::format("{{ kind = \"compound\", parts = [{}, {}] }}", one, other);
        }
        }
    }

    std::string tub() {
        std::string text = "[[body]]\nname = \"floor\"\nshape = { kind = \"plane\" }\nstatic = true\n";
        text += surface();
        if (is(0.2)) {
            text += fmt::format("euler_degrees = [{}, 0, 0]\n", between(random_, 0.0, 15.0));
        }
        const int kind = below(4); // none, upright ones twice, leaning ones
        if (kind == 0) {
            return text;
        }
        const double lean = kind == 3 ? between(random_, 0.0, 25.0) : 0.0;
        const double height = 20.0 * cell_, thickness = 2.0 * cell_, half = (1.2 + (is(0.5) ? random_.uniform() : 0.0)) * cell_;
        const double out = half + 0.5 * thickness * std::cos(lean * pi / 180) + 0.5 * height * std::sin(lean * pi / 180);
        for (int i = 0; i < 4; ++i) {
            const double sign = i % 2 == 0 ? 1.0 : -1.0;
            text += fmt::format("[[body]]\nname = \"wall{}\"\nstatic = true\n", i);
            text += surface();
            const Vec3 side = i < 2 ? Vec3::UnitX() : Vec3::UnitY();
            text +=
                fmt::format("shape = {{ kind = \"box\", size = {} }}\n", list(height * (Vec3::Ones() - side) + thickness * side));
            text += fmt::format("position = {}\n", list(sign * out * side + 0.4 * height * Vec3::UnitZ()));
            text += fmt::format("euler_degrees = {}\n", list(sign * lean * Vec3::UnitZ().cross(side)));
        }
        return text;
    }

    std::string bodies() {
        const double smallest = 1.0 / (is(0.7) ? 1.5 : spread(1.5, 10.0));
        const double lightest = 1000.0 / (is(0.6) ? 1.0 : spread(1.0, 100.0));
        const double speed = is(0.7) ? 0.0 : between(random_, 0.0, 5.0), spin = is(0.7) ? 0.0 : between(random_, 0.0, 20.0);
        const int count = 8 + below(33), joints = is(0.3) ? 1 + below(count / 2) : 0;
        const double lowest = (1.2 + (is(0.3) ? 3.0 * random_.uniform() : 0.0)) * cell_;
        std::string text;
        Vec3 before = Vec3::Zero();
        for (int i = 0; i < count; ++i) {
            const Vec3 place((i % 2 - 0.5) * cell_, (i / 2 % 2 - 0.5) * cell_, lowest + i / 4 * cell_);
            const double size = size_ * spread(smallest, 1.0);
            text += fmt::format("[[body]]\nname = \"b{}\"\nshape = {}\n", i, shape(size, 7));
            text += surface();
            text += fmt::format("position = {}\n", list(place));
            text += fmt::format("density = {}\n", spread(lightest, 1000.0));
            const double x = random_.uniform(), y = random_.uniform(), turn = between(random_, 0.0, 180.0);
            text += fmt::format("axis_angle_degrees = [{}, {}, 1, {}]\n", x, y, turn);
            text += "velocity = " + vector(speed) + "\n";
            text += "angular_velocity = " + vector(spin) + "\n";
            if (i > 0 && i <= joints) {
                text += fmt::format("[[joint]]\nname = \"j{0}\"\nbodies = [\"b{1}\", \"b{0}\"]\nanchor = {2}\n", i, i - 1,
                                    list(0.5 * (before + place)));
                text += is(0.5) ? "kind = \"ball\"\n" : "kind = \"hinge\"\naxis = [0, 1, 0]\n";
            }
            before = place;
        }
        return text;
    }

    sim::Random random_;
    double size_ = 0.0, aspect_ = 0.0, cell_ = 0.0, friction_ = 0.0, restitution_ = 0.0;
    bool has_many_materials_ = false;
};

/// How fast the anchors of any joint are told to part, at most [m/s].
double fastest_opening(const sim::SceneDef& scene, sim::Snapshot snapshot) {
    constexpr double instant = 1e-7; // [s]
    for (sim::BodySnapshot& body : snapshot.bodies) {
        body.position += instant * body.velocity;
        const Vec3 turn = 0.5 * instant * body.angular_velocity;
        body.orientation = (sim::Quat(1.0, turn.x(), turn.y(), turn.z()) * body.orientation).normalized();
    }
    return largest_joint_gap(scene, snapshot) / instant;
}

/// Of all scenes together.
struct Found {
    int unconverged = 0;  ///< those with a step that did not converge
    double gain = 0.0;    ///< [-] the most of a step
    double overlap = 0.0; ///< [-] of the tolerance, in steps that converged
    double sweeps = 0.0;  ///< [-] a step, mean
};

Found run_scenes(int first, int last) {
    Found found;
    std::int64_t steps = 0, sweeps = 0;
    for (int seed = first; seed <= last; ++seed) {
        const sim::SceneDef scene = sim::parse_scene(Generator(seed).scene(), "random.toml");
        sim::World world(scene);
        bool converged = true;
        double gain = 0.0;
        while (world.time() < 1.5) {
            const sim::StepReport report = world.step();
            converged = converged && !report.at_iteration_limit;
            gain = std::max(gain, report.energy_gain);
            found.overlap =
                std::max(found.overlap, report.at_iteration_limit ? 0.0 : report.max_penetration / scene.step.tolerance);
            sweeps += report.contact_iterations;
            ++steps;
        }
        found.unconverged += converged ? 0 : 1;
        found.gain = std::max(found.gain, gain);
        if (!converged || gain > sim::energy_gain_allowed) {
            fmt::print("random scene {}: {}, energy gained {:.1e}\n", seed, converged ? "converged" : "a step did not converge",
                       gain);
        }
    }
    found.sweeps = static_cast<double>(sweeps) / static_cast<double>(steps);
    return found;
}

/// unconverged: at most so many of the scenes. sweeps: of a step, mean, at most. gain [-]: of energy in a step, at most.
void judge(int first, int last, int unconverged, double sweeps = 15.0, double gain = sim::energy_gain_allowed) {
    const Found found = run_scenes(first, last);
    const auto hold = [&](const std::string& quantity, double value, double most) {
        record({fmt::format("random scenes {} to {}", first, last), quantity, no_value, value, most});
        EXPECT_LE(value, most) << quantity;
    };
    hold("with a step that does not converge", found.unconverged, unconverged);
    hold("energy gained in a step, relative", found.gain, gain);
    hold("overlap in steps that converge, of the tolerance", found.overlap, 1.0);
    hold("sweeps of a step, mean", found.sweeps, sweeps);
}

TEST(law_random_scenes, most_converge_and_none_gains_energy) {
    judge(1, 12, 1);
}

/// What an impact turns touches elsewhere as the step ends than as it began: what is asked of it there would give 0.03 of all energy.
TEST(law_random_scenes, what_an_impact_turns_gives_no_energy) {
    judge(847, 847, 0, 40.0);
}

/// What wedges a row lies at contacts that bore nothing before: half of what the others take up is told of no instant.
TEST(law_random_scenes, what_is_told_of_a_jam_has_no_energy_of_its_own) {
    judge(1352, 1352, 0);
}

/// A capsule that a ball presses to the floor: what holds the two apart ahead of their impact takes 4483 J, and the floor, which
/// throws the capsule against the ball, gives 2200 J of them.
TEST(law_random_scenes, an_impact_gives_back_no_more_than_was_lost) {
    judge(2853, 2853, 0);
}

/// Chains that an impact makes whip: how fast their joints vibrate then, nothing of the step before tells.
TEST(law_random_scenes, chains_that_are_hit_gain_no_energy) {
    judge(3220, 3220, 0);
    judge(3867, 3867, 0);
}

/// Chains that are put together in motion: how fast their joints vibrate, no step before the first one tells. 5e-3 and 3e-3 of their
/// energy where one step of the power iteration is to find it.
TEST(law_random_scenes, chains_that_start_fast_gain_no_energy) {
    judge(9114, 9114, 0);
    judge(12342, 12342, 0);
}

/// A step of twelve intervals, in many of which contacts give what one may.
TEST(law_random_scenes, what_contacts_give_does_not_add_up) {
    judge(2735, 2735, 0);
}

/// A jam that only short intervals solve: where each of them is first tried with all that is left of the step, the step's work ends
/// before it does.
TEST(law_random_scenes, what_had_to_be_divided_is_not_tried_whole) {
    judge(2665, 2665, 0, 60.0);
}

/// A chain is jammed: what its joints tell of half kicks holds against those of contacts, of which an impact leaves some.
TEST(law_random_scenes, what_is_told_of_jammed_chains_has_no_energy_of_its_own) {
    judge(587, 587, 0, 25.0);
}

/// Where half kicks are cut, the joints close after it, or they are told to open.
TEST(law_random_scenes, joints_of_jammed_chains_are_told_to_stay_closed) {
    const sim::SceneDef scene = sim::parse_scene(Generator(587).scene(), "random.toml");
    sim::World world(scene);
    double fastest = 0.0; // [m/s]
    while (world.time() < 1.5) {
        world.step();
        fastest = std::max(fastest, fastest_opening(scene, world.take_snapshot()));
    }
    EXPECT_LT(fastest, 0.01); // poses keep them within 1e-9 m
}

/// A chain in a heap that is given far too few sweeps: what they leave would give it 1.6e-3 of all energy.
TEST(law_random_scenes, a_plan_that_falls_short_throws_nothing_among_joints) {
    sim::SceneDef scene = sim::parse_scene(Generator(178).scene(), "random.toml");
    scene.step.iteration_limit = 20;
    sim::World world(scene);
    int unconverged = 0; // steps
    while (world.time() < 1.5) {
        const sim::StepReport report = world.step();
        unconverged += report.at_iteration_limit ? 1 : 0;
        EXPECT_LE(report.energy_gain, sim::energy_gain_allowed);
    }
    EXPECT_GT(unconverged, 100);
}

/// 5073 is told to gain 1.14e-3: as a ball that spins is turned upwards, what is told of one instant, the mean of two flights'
/// velocities, has less energy than either flight, by 1.3e-3 and 4.2e-3.
TEST(law_random_scenes, DISABLED_most_of_four_hundred_converge_and_none_gains_energy) {
    judge(1, 200, 2);
    judge(5001, 5200, 2, 15.0, 1.2e-3); // nothing is tuned on these
}

} // namespace
