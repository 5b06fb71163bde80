#pragma once

/// Steps of a system whose conditions may come to depend on each other (System::margin()).
///
/// Near such a pose steps shrink with the distance from it, and end before it. Where the motion is about to
/// reach it, a Leap (leap.h) goes over it, from as far before it to as far behind it. Its length is halved
/// until its error is allowed. Where it is not made, the given steps go on, as far as they get.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// most: as of projectedSteps(). Allocates here alone.
std::unique_ptr<Integrator> leapingSteps(std::unique_ptr<Integrator> steps, System& f, double most);

}  // namespace planar_chain::ode
