#pragma once
/// Closed forms of the motions of scenes that name a law: what a study then takes as the truth.
#include "render/study/motion.h"
#include "sim/scene/study.h"

#include <span>

namespace study {

/// The states at ascending times [s] by a law, that which the scene names (study.law).
/// Throws sim::Error (usage) if the scene is none that the law speaks of, and says what it expects.
///
///   sliding_block  a block that slides along an inclined plane, decelerated by friction, and stays where it
///                  stops: s = v t - (mu g_n - g_t) t^2 / 2
///   bouncing_ball  a ball over a plane without friction, each rebound e times as fast as the impact
///   rolling_ball   a ball on a level plane, from slipping to rolling: slip decays at mu g (1 + m R^2 / J)
///   tower          bodies that rest on each other: nothing moves
///   free_rotation  one body without gravity: Euler's equations, integrated by Runge-Kutta in steps of which
///                  2e5 make the duration, accurate to rounding
Motion law_motion(const sim::SceneDef& scene, sim::Law law, std::span<const double> times);

/// Throws sim::Error (usage) if what the scene's table study names does not fit the scene: law, seed_key.
void require_study(const sim::SceneDef& scene);

} // namespace study
