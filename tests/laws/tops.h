#pragma once
/// The tops on which the tippe top is judged, for the reference and for the simulation alike.
#include "tests/laws/reference/top.h"

#include <array>

namespace laws {

/// One top and its start: axis tilted, angular velocity vertical, no velocity of the centre of mass.
struct TopCase {
    const char* name = "";
    double radius = 0.0;      ///< R of the bowl [m]
    double mass = 0.0;        ///< [kg]
    double a = 0.0;           ///< [-] centre of mass below the bowl's centre, in R
    double transverse = 0.0;  ///< [-] A / (m R^2)
    double axial = 0.0;       ///< [-] C / (m R^2)
    double stem_end = 0.0;    ///< [m] centre of the stem's ball from the centre of mass
    double stem_radius = 0.0; ///< [m]
    double spin = 0.0;        ///< [rad/s]
    double tilt = 0.0;        ///< [rad]
};

/// All with A/C within (1 - a, 1 + a) and spin^2 a R sin(tilt) > 3.5 mu g for mu = 0.25.
inline constexpr std::array<TopCase, 3> top_cases{
    TopCase{"solid", 0.020, 0.030, 0.20, 0.40, 0.40, 0.035, 0.003, 180.0, 0.10},
    TopCase{"light", 0.015, 0.006, 0.30, 0.36, 0.40, 0.025, 0.002, 180.0, 0.10},
    TopCase{"large", 0.030, 0.080, 0.15, 0.45, 0.43, 0.050, 0.004, 150.0, 0.10},
};
inline constexpr std::array<double, 3> top_frictions{0.1, 0.17, 0.25};

inline reference::Top reference_top(const TopCase& c, double mu) {
    reference::Top top;
    top.mass = c.mass;
    top.transverse = c.transverse * c.mass * c.radius * c.radius;
    top.axial = c.axial * c.mass * c.radius * c.radius;
    top.bowl = {c.a * c.radius, c.radius};
    top.stem = {c.stem_end, c.stem_radius};
    top.mu = mu;
    return top;
}

} // namespace laws
