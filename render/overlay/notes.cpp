#include "render/overlay/notes.h"

#include "render/scene/camera.h"
#include "sim/model/film_clock.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace render {

namespace {

using sim::Vec3;

/// A curve over the whole film has at most about so many points.
constexpr double most_curve_points = 1500.0;
/// Points of a path lie so many view distances apart, on a body so many distances from its centre.
constexpr double spacing_in_views = 0.002;
constexpr double spacing_on_body = 0.01;
/// A contact that moves farther in one go, in distances from the body's centre, is another contact.
constexpr double largest_jump = 0.3;
/// Pieces of a contact path that belong together are no farther apart in time [s], and in distance from the body's
/// centre by no larger share.
constexpr double longest_hop = 0.05;
constexpr double largest_climb = 0.1;

/// Adds a point to a path. The last point is always the present one: it is moved until it lies `spacing` from
/// the one before.
void extend(Path& path, const PathPoint& point, double spacing) {
    const std::size_t count = path.size();
    if (count >= 2 && (path[count - 1].at - path[count - 2].at).norm() < spacing) {
        path.back() = point;
    } else {
        path.push_back(point);
    }
}

void extend(Curve& curve, const CurvePoint& point, double spacing) {
    const std::size_t count = curve.size();
    if (count >= 2 && curve[count - 1].time - curve[count - 2].time < spacing) {
        curve.back() = point;
    } else {
        curve.push_back(point);
    }
}

} // namespace

bool is_hop(const Path& from, const Path& to) {
    if (from.empty() || to.empty() || to.front().time - from.back().time > longest_hop) {
        return false;
    }
    const double a = from.back().at.norm();
    const double b = to.front().at.norm();
    return std::abs(a - b) <= largest_climb * std::max(a, b);
}

bool is_hop_in_world(const ContactPath& path, std::size_t i) {
    if (!is_hop(path.on_body[i - 1], path.on_body[i])) {
        return false;
    }
    const double distance = (path.in_world[i].front().at - path.in_world[i - 1].back().at).norm();
    return distance <= largest_jump * path.on_body[i].front().at.norm();
}

Energies energies(const sim::SceneDef& scene, const sim::Snapshot& snapshot) {
    const sim::Mechanics all = sim::mechanics(scene, snapshot);
    double mass = 0.0;
    for (const sim::BodyDef& body : scene.bodies) {
        mass += body.mass.mass;
    }
    return {all.kinetic_energy,
            all.potential_energy - mass * scene.step.gravity.norm() * scene.overlay.zero_height};
}

std::vector<double> plot_values(const sim::SceneDef& scene, const sim::PlotDef& plot,
                                const sim::Snapshot& snapshot) {
    std::vector<double> values;
    switch (plot.quantity) {
    case sim::PlotQuantity::energy: {
        const Energies now = energies(scene, snapshot);
        values = {now.kinetic, now.potential, now.total()};
        break;
    }
    case sim::PlotQuantity::contacts:
        values = {static_cast<double>(snapshot.contact_count)};
        break;
    case sim::PlotQuantity::inclination:
        for (const int body : plot.bodies) {
            const Vec3 axis = snapshot.bodies[static_cast<std::size_t>(body)].orientation * Vec3::UnitZ();
            values.push_back(std::acos(std::clamp(axis.z(), -1.0, 1.0)) * 180.0 / std::numbers::pi);
        }
        break;
    case sim::PlotQuantity::distance:
        for (const int body : plot.bodies) {
            const auto i = static_cast<std::size_t>(body);
            values.push_back((snapshot.bodies[i].position - scene.bodies[i].pose.position).norm());
        }
        break;
    }
    return values;
}

std::vector<int> path_bodies(const sim::SceneDef& scene) {
    std::vector<int> bodies = scene.overlay.bodies;
    for (std::size_t i = 0; i < scene.bodies.size() && scene.overlay.bodies.empty(); ++i) {
        if (!scene.bodies[i].is_static()) {
            bodies.push_back(static_cast<int>(i));
        }
    }
    return bodies;
}

NoteTaker::NoteTaker(const sim::SceneDef& scene)
    : scene_(scene), has_plots_(scene.overlay.shows(sim::Shown::plots) && !scene.plots.empty()),
      has_trails_(scene.overlay.shows(sim::Shown::trails)),
      has_contact_paths_(scene.overlay.shows(sim::Shown::contact_paths)), bodies_(path_bodies(scene)),
      time_spacing_(sim::simulated_duration(scene.output) / most_curve_points) {
    spacing_ = spacing_in_views * view_scale(find_camera(scene, scene.output.camera));
    notes_.plots.resize(has_plots_ ? scene.plots.size() : 0);
    notes_.trails.resize(has_trails_ ? bodies_.size() : 0);
    for (std::size_t i = 0; i < bodies_.size() && has_contact_paths_; ++i) {
        notes_.contact_paths.push_back({bodies_[i], {}, {}});
    }
}

void NoteTaker::observe(const sim::Snapshot& snapshot) {
    if (snapshot.step <= last_step_) {
        return;
    }
    last_step_ = snapshot.step;
    for (std::size_t i = 0; i < notes_.plots.size(); ++i) {
        const std::vector<double> values = plot_values(scene_, scene_.plots[i], snapshot);
        notes_.plots[i].resize(values.size());
        for (std::size_t k = 0; k < values.size(); ++k) {
            extend(notes_.plots[i][k], CurvePoint{snapshot.time, values[k]}, time_spacing_);
        }
    }
    for (std::size_t i = 0; i < notes_.trails.size(); ++i) {
        const auto body = static_cast<std::size_t>(bodies_[i]);
        if (!scene_.bodies[body].is_there(snapshot.time)) {
            continue;
        }
        extend(notes_.trails[i], PathPoint{snapshot.time, snapshot.bodies[body].position}, spacing_);
        Path& trail = notes_.trails[i];
        const double oldest = snapshot.time - scene_.overlay.trail_time;
        while (scene_.overlay.trail_time > 0.0 && trail.front().time < oldest) {
            trail.erase(trail.begin());
        }
    }
    for (ContactPath& path : notes_.contact_paths) {
        observe_contacts(snapshot, path);
    }
}

void NoteTaker::observe_contacts(const sim::Snapshot& snapshot, ContactPath& path) const {
    const sim::ContactSnapshot* strongest = nullptr;
    float most = 0.0f;
    for (const sim::ContactSnapshot& contact : snapshot.contacts) {
        const float p_n = std::abs(contact.impulse.dot(contact.normal));
        if ((contact.bodies[0] == path.body || contact.bodies[1] == path.body) && p_n > most) {
            strongest = &contact;
            most = p_n;
        }
    }
    if (strongest == nullptr) {
        // In the air: the next contact begins a new piece.
        if (!path.on_body.empty() && !path.on_body.back().empty()) {
            path.on_body.emplace_back();
            path.in_world.emplace_back();
        }
        return;
    }
    const sim::BodySnapshot& body = snapshot.bodies[static_cast<std::size_t>(path.body)];
    const Vec3 at = strongest->point.cast<double>();
    const Vec3 on_body = body.orientation.conjugate() * (at - body.position);
    const double radius = on_body.norm();
    const bool is_new =
        path.on_body.empty() || (!path.on_body.back().empty() &&
                                 (path.on_body.back().back().at - on_body).norm() > largest_jump * radius);
    if (is_new) {
        path.on_body.emplace_back();
        path.in_world.emplace_back();
    }
    extend(path.on_body.back(), PathPoint{snapshot.time, on_body}, spacing_on_body * radius);
    extend(path.in_world.back(), PathPoint{snapshot.time, at}, spacing_);
}

std::shared_ptr<const Notes> NoteTaker::notes() const {
    return std::make_shared<const Notes>(notes_);
}

} // namespace render
