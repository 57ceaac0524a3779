#include "sim/scene/model.h"

#include "sim/model/integrate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>

namespace sim {

namespace {

using Test = std::function<bool(const BodyDef&)>;

/// "5 bodies, such as 'plate'"; empty if there is none.
std::string bodies_where(const SceneDef& scene, const Test& test) {
    const auto count = std::ranges::count_if(scene.bodies, test);
    if (count == 0) {
        return {};
    }
    const std::string& first = std::ranges::find_if(scene.bodies, test)->name;
    return count == 1 ? fmt::format("'{}'", first) : fmt::format("{} bodies, such as '{}'", count, first);
}

/// "0.1" or "0.1 to 0.7" of the values above zero; empty if there is none.
std::string range_of(const SceneDef& scene, std::optional<double> MaterialDef::*value) {
    std::set<double> values;
    for (const BodyDef& body : scene.bodies) {
        if ((body.material.*value).value_or(0.0) > 0.0) {
            values.insert(*(body.material.*value));
        }
    }
    if (values.empty()) {
        return {};
    }
    return values.size() == 1 ? fmt::format("{}", *values.begin())
                              : fmt::format("{} to {}", *values.begin(), *values.rbegin());
}

std::string friction_of(const SceneDef& scene) {
    const std::string mu_s = range_of(scene, &MaterialDef::mu_s), mu_d = range_of(scene, &MaterialDef::mu_d);
    if (mu_s.empty() || mu_s == mu_d) {
        return mu_s;
    }
    return fmt::format("static {}, dynamic {}", mu_s, mu_d.empty() ? "0" : mu_d);
}

template <class Kind>
bool has_part(const Shape& shape) {
    if (const auto* compound = std::get_if<Compound>(&shape)) {
        return std::ranges::any_of(compound->parts, [](const CompoundPart& part) {
            return std::holds_alternative<Kind>(part.shape);
        });
    }
    return std::holds_alternative<Kind>(shape);
}

/// Neither box, ball nor plane: a pair with one is searched for by its support points.
bool is_convex_part(const BodyDef& body) {
    return has_part<Cylinder>(body.shape) || has_part<Capsule>(body.shape) || has_part<Hull>(body.shape);
}

/// A free rotation is then no rotation about a fixed axis (sim/model/integrate.cpp).
bool has_unequal_moments(const BodyDef& body) {
    return !body.is_static() && make_body_props(body).inertia_kind != InertiaKind::spherical;
}

std::string joints_of(const SceneDef& scene) {
    const auto count = [&](JointKind kind) { return std::ranges::count(scene.joints, kind, &JointDef::kind); };
    std::vector<std::string> parts;
    for (const auto& [number, name] :
         {std::pair(count(JointKind::ball), "ball"), {count(JointKind::hinge), "hinge"}, {count(JointKind::slider), "slider"}}) {
        if (number > 0) {
            parts.push_back(fmt::format("{} {}", number, name));
        }
    }
    return fmt::format("{}", fmt::join(parts, ", "));
}

std::string joints_with(const SceneDef& scene, const char* what, const std::function<bool(const JointDef&)>& test) {
    const auto count = std::ranges::count_if(scene.joints, test);
    return count > 0 ? fmt::format("{} {}", count, what) : "";
}

bool is_elastic(const BodyDef& body) {
    return body.material.restitution.value_or(0.0) >= elastic_restitution;
}

} // namespace

ImpactHandling impact_handling(const SceneDef& scene) {
    if (scene.step.impacts != ImpactHandling::automatic) {
        return scene.step.impacts;
    }
    return std::ranges::any_of(scene.bodies, is_elastic) ? ImpactHandling::stop : ImpactHandling::ahead;
}

std::vector<ModelPart> model_parts(const SceneDef& scene) {
    const StepSettings& step = scene.step;
    const auto moving = std::ranges::count_if(scene.bodies, [](const BodyDef& b) { return !b.is_static(); });
    const bool may_touch = moving > 0 && scene.bodies.size() > 1;
    std::vector<ModelPart> parts;
    const auto add = [&parts](const char* name, const std::string& reason) {
        parts.push_back({name, !reason.empty(), reason});
    };
    add("contacts", may_touch ? fmt::format("{} moving bodies, {} in all", moving, scene.bodies.size()) : "");
    add("restitution", may_touch ? range_of(scene, &MaterialDef::restitution) : "");
    add("friction", may_touch ? friction_of(scene) : "");
    add("joints", joints_of(scene));
    add("springs", joints_with(scene, "in joints", [](const JointDef& joint) { return joint.spring.has_value(); }));
    add("motors", joints_with(scene, "in joints", [](const JointDef& joint) { return joint.motor.has_value(); }));
    add("kinematic bodies", bodies_where(scene, [](const BodyDef& b) { return b.is_kinematic(); }));
    add("bodies released later", bodies_where(scene, [](const BodyDef& b) { return !b.is_there(0.0); }));
    add("support points (libccd)", may_touch ? bodies_where(scene, is_convex_part) : "");
    add("compounds", bodies_where(scene, [](const BodyDef& b) { return std::holds_alternative<Compound>(b.shape); }));
    add("gyroscopic term", bodies_where(scene, has_unequal_moments));
    const bool stops = impact_handling(scene) == ImpactHandling::stop;
    const std::string elastic = bodies_where(scene, is_elastic);
    const std::string why = step.impacts == ImpactHandling::automatic
                                ? fmt::format("elastic bodies (restitution {:g} or more): {}", elastic_restitution,
                                              elastic.empty() ? "none" : elastic)
                                : fmt::format("simulation.impacts is \"{}\"", stops ? "stop" : "ahead");
    add("contacts ahead of impacts", may_touch && !stops ? why : "");
    add("stop at impacts", may_touch && stops ? why : "");
    add("warm start", may_touch && step.warm_start ? "simulation.warm_start is true" : "");
    return parts;
}

} // namespace sim
