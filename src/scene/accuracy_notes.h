#pragma once

/// Notes where a scene is less accurate than its tolerance, or leaves something out.

#include "planar_chain/scene.h"

namespace planar_chain {

/// If a link is so heavy between lighter ones and a free or held end that rounding exceeds the tolerance: the
/// acceleration of what is light then has the error 1e-16 of the ratio of the masses.
void noteRounding(Scene& scene);

/// If friction is so weak that it is left out (stick_slip.h).
void noteWeakFriction(Scene& scene);

/// If the error of a rate, times the damping of another joint, may decide what sticks.
void noteStiffDampers(Scene& scene);

}  // namespace planar_chain
