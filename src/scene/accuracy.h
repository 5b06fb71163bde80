#pragma once

/// How exact the rates of a scene must be, and notes where it is less accurate than its tolerance, leaves
/// something out, or begins in a stop.

#include "planar_chain/scene.h"

namespace planar_chain {

/// Adds the notes. startsAtRest: joints may lean on their stops.
void addNotes(Scene& scene, bool startsAtRest);

/// Sets the rate_tolerance that the scene does not give, if the error of a rate, times a damping, might
/// decide whether a joint with breakaway sticks:
///
///     min(tolerance, max(3e-4 M_b / d, 1e-12 rad/s))
///
///     M_b    the least breakaway torque of joints in which it exceeds the friction
///     d      the most damping, of joints or stops
///
/// Nothing is set where tolerance · d ≤ M_b / 10000: no joint has stuck wrongly there.
void boundRates(Scene& scene);

}  // namespace planar_chain
