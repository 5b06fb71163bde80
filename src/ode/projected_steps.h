#pragma once

/// Steps of a system whose solution keeps conditions: each ends with a projection onto them. So the errors
/// of steps do not add up across the conditions, and the order stays.
///
/// The error estimate is that of the step before its projection, which is not smaller than the remaining
/// error. A projection that moves the state by far more than that error is no small correction: near a pose
/// in which the conditions depend on each other, the way on is not determined.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// Makes the given steps, and System::project() at the end of each. A step that cannot be projected is not
/// finite. One that is projected by more than `most`, of 1 + |y|, is undetermined. Allocates here alone.
std::unique_ptr<Integrator> projectedSteps(std::unique_ptr<Integrator> steps, System& f, double most);

}  // namespace planar_chain::ode
