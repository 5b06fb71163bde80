#pragma once

/// Steps of a system whose conditions may come to depend on each other (System::margin()).
///
/// The square root of the margin falls like the distance from such a pose. Near the pose steps shrink with
/// the distance, and never get over it. So the distances at the ends of steps are extrapolated. If a Leap
/// (leap.h) can reach the pose, one is tried. It begins with a length in which the fastest joint turns by
/// half a radian, and is shortened until its error is allowed, as long as it reaches the pose. Where none is
/// made, the given steps go on. A leap may end in the pose itself, if the time that is wanted is there: the
/// next one then begins there.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// most: as of projectedSteps(). Allocates here alone.
std::unique_ptr<Integrator> leapingSteps(std::unique_ptr<Integrator> steps, System& f, double most);

}  // namespace planar_chain::ode
