#pragma once
/// What Newton's method of contacts has to know of joints. They are closed exactly beside it, so their impulses are no unknowns of its
/// own: bodies in joints only answer to contacts as these let them.
#include "sim/base/sort_once.h"
#include "sim/block/body_factors.h"
#include "sim/model/body.h"

#include <array>
#include <span>
#include <vector>

namespace sim {

class JointEquations {
public:
    JointEquations() = default;
    JointEquations(JointEquations&&) = default;
    JointEquations& operator=(JointEquations&&) = default;
    virtual ~JointEquations() = default;

    /// [body_count]; -1: no joint holds the body, or nothing moves it.
    virtual std::span<const int> assembly_of() const = 0;
    /// Those that hold some of these bodies, ascending.
    template <typename Indices>
    std::vector<int> assemblies_with(const Indices& bodies) const {
        const std::span<const int> of = assembly_of();
        std::vector<int> found;
        for (const auto body : bodies) {
            if (const int assembly = of[static_cast<std::size_t>(body)]; assembly >= 0) {
                found.push_back(assembly);
            }
        }
        sort_once(found);
        return found;
    }
    /// Bodies that move, ascending.
    virtual std::span<const int> bodies_of(int assembly) const = 0;
    /// Of these, those that a joint connects.
    virtual std::span<const std::array<int, 2>> pairs_of(int assembly) const = 0;

    /// Adds rows^T rows / compliance to the equations of bodies. A joint gives way as a contact does, by a share of the response that it
    /// would have with a body of `heaviest` [kg] in place of its lighter one; a spring as it does. place: [body_count] of bodies in `to`.
    virtual void add_equations(int assembly, double heaviest, std::span<const int> place, BodyFactors& to) const = 0;

    /// Applies the impulses that bring all rows to their targets at once. Returns the largest velocity change of a row [m/s].
    virtual double solve(std::span<const int> of, std::span<Velocity> velocity) = 0;

    /// Keeps the impulses of this solve; takes those that were kept last.
    virtual void keep(std::span<const int> of) = 0;
    virtual void take_kept(std::span<const int> of) = 0;
};

} // namespace sim
