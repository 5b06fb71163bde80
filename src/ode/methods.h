#pragma once

/// The methods by name, as in a scene's integrator/method.

#include <memory>
#include <string>
#include <vector>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// "auto" first, then every method of the program.
const std::vector<std::string>& methodNames();

/// True for a method of equal steps, which ignores the tolerance.
bool hasFixedStep(const std::string& name);

/// True for a method that never solves with the Jacobian. False for auto, which has both kinds.
bool isExplicit(const std::string& name);

/// Makes the stepper of a method, but for auto. tolerance: in lane order; that to which radau13 solves its
/// stages, and which sets the order of taylor. Allocates.
/// @throws std::invalid_argument for any other name
std::unique_ptr<Stepper> makeStepper(const std::string& name, SeriesSystem& f, const Tolerance& tolerance,
                                     const std::shared_ptr<LocalStiffness>& stiffness);

/// Makes an integrator of system f, which must outlive it. Methods of fixed step use `step`, s; adaptive ones
/// use `tolerance`. "auto" chooses among dop853, taylor, rodas5p and radau13, and dopri5 where f often jumps,
/// by measured progress. Allocates.
/// @throws std::invalid_argument for a name that is not one of methodNames().
std::unique_ptr<Integrator> makeMethod(const std::string& name, SeriesSystem& f, double step,
                                       const Tolerance& tolerance);

}  // namespace planar_chain::ode
