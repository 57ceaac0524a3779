#pragma once
/// Motion that is known in closed form, to be shown beside the computed one.
#include "sim/model/scene_def.h"

namespace render {

/// A body that slides straight up or down an incline under gravity and Coulomb friction: constant
/// deceleration until it stops, and rest if static friction holds it there.
struct SlidingBlock {
    double speed = 0.0;        ///< [m/s] at the start
    double acceleration = 0.0; ///< [m/s^2] along the start's velocity
    bool rests = false;        ///< it does not slide on after it stops
    double end = 0.0;          ///< [m] distance at which the incline ends

    /// [m] from the start, at time t [s]. Not meant beyond `end`.
    double distance(double t) const;
};

/// Of a body whose velocity at the start is along the top of a box.
SlidingBlock sliding_block(const sim::SceneDef& scene, int body, int incline);

} // namespace render
