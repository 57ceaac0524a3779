#pragma once
/// Independent integration of a row of equal balls on hinges that collide without friction and with e = 1, from event to
/// event. Shares no code with sim/.
///
/// Ball i turns rigidly about the hinge at (x_i, length) in a plane; angle q from hanging, inertia I about the hinge:
///   I q'' = -m g length sin q.
/// Neighbours touch where their centres are 2 r apart. The impulse acts along the line of centres, at the arm d x n of
/// the centre d about its hinge, and reverses the relative velocity along it.
#include <vector>

namespace reference {

struct Cradle {
    double length = 1.0;   ///< [m] from hinge to centre
    double radius = 0.1;   ///< [m]
    double spacing = 0.2;  ///< [m] from hinge to hinge, >= 2 radius
    double gravity = 9.81; ///< [m/s^2]
};

struct CradleState {
    std::vector<double> angle; ///< [rad] from hanging, towards the next ball
    std::vector<double> rate;  ///< [rad/s]
    int impacts = 0;           ///< of two balls, so far
};

/// Gap [m] between balls i and i + 1.
double cradle_gap(const Cradle& cradle, const CradleState& state, int i);

/// Advances by `duration` [s], impacts at the start and at the end included.
void integrate_cradle(const Cradle& cradle, CradleState& state, double duration);

} // namespace reference
