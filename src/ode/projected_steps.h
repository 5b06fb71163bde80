#pragma once

/// Steps of a system whose solution keeps conditions: each ends with a projection onto them. So the errors
/// of steps do not add up across the conditions, and the order stays.
///
/// The error estimate is that of the step before its projection, which is not smaller than the remaining
/// error.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// Makes the given steps, and System::project() at the end of each. A step that cannot be projected is not
/// finite. Allocates here alone.
std::unique_ptr<Integrator> projectedSteps(std::unique_ptr<Integrator> steps, System& f);

}  // namespace planar_chain::ode
