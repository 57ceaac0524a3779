#include "sim/scene/pattern.h"

#include "sim/base/random.h"
#include "sim/model/polytope.h"
#include "sim/scene/body.h"
#include "sim/scene/shape.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <optional>

namespace sim {

namespace {

/// Largest number of bodies a lattice may have.
constexpr double most_bodies = 1e6;

/// The plate whose outside is east, its inner surface at z = 0 of a frame with x up the slope. The others
/// follow by quarter turns.
struct Plate {
    Vec3 half_extents; ///< [m] up the slope, across, through
    Vec3 centre;       ///< [m]
    Mat3 axes;         ///< columns: up the slope, across, inner normal
};

Plate east_plate(Section& section) {
    const double mouth = section.number("mouth");
    const double throat = section.number("throat");
    const double mouth_height = section.number("mouth_height");
    const double throat_height = section.number("throat_height");
    const double thickness = section.number("thickness");
    if (mouth <= throat) {
        section.fail("mouth",
                     fmt::format("mouth is {}, expected more than throat, which is {}", mouth, throat));
    }
    if (mouth_height <= throat_height) {
        section.fail("mouth_height",
                     fmt::format("mouth_height is {}, expected more than throat_height, which is {}",
                                 mouth_height, throat_height));
    }
    // The inner surface, seen along y, goes from the throat's edge to the mouth's edge.
    const Vec3 low(throat / 2.0, 0.0, throat_height);
    const Vec3 high(mouth / 2.0, 0.0, mouth_height);
    const double length = (high - low).norm();
    const Vec3 up = (high - low) / length;
    const Vec3 normal(-up.z(), 0.0, up.x());
    Plate plate;
    plate.axes << up, Vec3::UnitY(), normal;
    // Wider than the mouth by the thickness on both sides, so that neighbours close the corner over their
    // whole thickness. What stands out lies behind the neighbour's inner surface, outside the funnel.
    plate.half_extents = Vec3(length / 2.0, mouth / 2.0 + thickness, thickness / 2.0);
    plate.centre = (low + high) / 2.0 - normal * (thickness / 2.0);
    return plate;
}

/// What is drawn of the plate: up to the vertical planes through the funnel's edges, where it meets its neighbours.
/// None of a plate that is all but a plane.
std::optional<Shape> mitred(const Plate& plate) {
    std::vector<Vec3> corners;
    for (const double up : {-plate.half_extents.x(), plate.half_extents.x()}) {
        for (const double through : {-plate.half_extents.z(), plate.half_extents.z()}) {
            const double reach = (plate.centre + plate.axes * Vec3(up, 0.0, through)).x();
            corners.push_back({up, -reach, through});
            corners.push_back({up, reach, through});
        }
    }
    std::optional<Polytope> polytope = convex_hull(corners);
    if (!polytope) {
        return std::nullopt;
    }
    return Hull{std::make_shared<const Polytope>(std::move(*polytope))};
}

/// The bodies that the places of a lattice take.
class Mixture {
public:
    Mixture(const TextSource& source, Section& lattice, const std::string& title) : source_(source) {
        add(lattice.table("body"), "lattice.body", title + " body", 1.0);
        for (const TreeNode* node : lattice.tables("mix")) {
            const std::string name = fmt::format("{} mix {}", title, kinds_.size() - 1);
            Section section(source, *node, scene_section("lattice.mix"), name);
            add(*node, "lattice.mix", name, section.number("share"));
        }
    }

    /// The body of one place, whose number is `index`.
    BodyDef take(std::int64_t index, Random& random) const {
        double left = kinds_.size() > 1 ? random.uniform() * total_ : 0.0;
        std::size_t chosen = 0;
        while (chosen + 1 < kinds_.size() && left >= kinds_[chosen].share) {
            left -= kinds_[chosen++].share;
        }
        const Kind& kind = kinds_[chosen];
        return is_random_shape(*kind.node) ? read(kind, index) : kind.body;
    }

private:
    struct Kind {
        const TreeNode* node;
        std::string section;
        std::string title;
        double share;
        BodyDef body;
    };

    void add(const TreeNode& node, const std::string& section, const std::string& title, double share) {
        kinds_.push_back({&node, section, title, share, {}});
        kinds_.back().body = read(kinds_.back(), 0);
        total_ += share;
    }

    BodyDef read(const Kind& kind, std::int64_t index) const {
        Section section(source_, *kind.node, scene_section(kind.section), kind.title);
        return read_body_template(section, index);
    }

    const TextSource& source_;
    std::vector<Kind> kinds_;
    double total_ = 0.0;
};

} // namespace

std::vector<BodyDef> read_lattice(const TextSource& source, const TreeNode& node, const std::string& title) {
    Section section(source, node, scene_section("lattice"), title);
    const std::string name = section.text("name");
    const Eigen::Vector3i count = section.counts("count");
    const Vec3 spacing = section.vector("spacing");
    const Vec3 origin = section.vector("origin");
    const double turn_max = section.number("turn_max_degrees") * (std::numbers::pi / 180.0);
    Random random(static_cast<std::uint64_t>(section.long_integer("seed")));
    const std::vector<Vec3> palette =
        section.has("palette") ? section.colors("palette") : std::vector<Vec3>{};
    const Vec3 jitter = section.vector("jitter");
    const Mixture mixture(source, section, title);
    // Numbers of their own, so that turns stay what they are without jitter and mixture.
    Random places(static_cast<std::uint64_t>(section.long_integer("seed")) ^ 0x6A09E667F3BCC908u);
    const double interval = section.number("release_interval");
    if (count.cast<double>().prod() > most_bodies) {
        section.fail("count", fmt::format("count makes {:.0f} bodies, expected at most {:.0f}",
                                          count.cast<double>().prod(), most_bodies));
    }

    std::vector<BodyDef> bodies;
    for (int k = 0; k < count.z(); ++k) {
        for (int j = 0; j < count.y(); ++j) {
            for (int i = 0; i < count.x(); ++i) {
                BodyDef body = mixture.take(static_cast<std::int64_t>(bodies.size()), places);
                const Quat orientation = body.pose.orientation;
                body.name = fmt::format("{}_{}", name, bodies.size());
                body.pose.position = origin + spacing.cwiseProduct(Vec3(i, j, k));
                for (int axis = 0; axis < 3; ++axis) {
                    body.pose.position[axis] += jitter[axis] > 0.0 ? jitter[axis] * (2.0 * places.uniform() - 1.0) : 0.0;
                }
                if (turn_max > 0.0) {
                    const Vec3 axis = random.direction();
                    body.pose.orientation =
                        Quat(Eigen::AngleAxisd(turn_max * random.uniform(), axis)) * orientation;
                }
                body.release = read_release(section, body) + k * interval;
                if (!palette.empty()) {
                    body.look.color = palette[static_cast<std::size_t>(k) % palette.size()];
                }
                settle(body);
                bodies.push_back(std::move(body));
            }
        }
    }
    return bodies;
}

std::vector<BodyDef> read_funnel(const TextSource& source, const TreeNode& node, const std::string& title) {
    Section section(source, node, scene_section("funnel"), title);
    const std::string name = section.text("name");
    const Vec3 position = section.vector("position");
    const Plate east = east_plate(section);
    BodyDef body;
    body.material = read_material(section);
    body.look = read_look(section);
    body.shape = Box{east.half_extents};
    body.drawn = mitred(east);

    std::vector<BodyDef> plates;
    Mat3 turn = Mat3::Identity();
    for (const char* side : {"east", "north", "west", "south"}) {
        body.name = fmt::format("{}_{}", name, side);
        body.pose = {position + turn * east.centre, Quat(Mat3(turn * east.axes)).normalized()};
        plates.push_back(body);
        // A quarter turn about z, without rounding.
        Mat3 quarter;
        quarter << 0, -1, 0, 1, 0, 0, 0, 0, 1;
        turn = quarter * turn;
    }
    return plates;
}

} // namespace sim
