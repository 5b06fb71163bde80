#pragma once

/// The methods by name: what a scene's integrator/method may say.

#include <memory>
#include <string>
#include <vector>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// "auto" first, then every method of the program.
const std::vector<std::string>& methodNames();

/// True for a method that takes equal steps and knows no tolerance.
bool hasFixedStep(const std::string& name);

/// For system f, which must outlive it. step: for methods of fixed step, s. tolerance: for adaptive ones.
/// "auto" chooses among dop853, taylor, rodas5p and radau13 by measured progress, whenever that
/// changes.
/// @throws std::invalid_argument for a name that is not one of methodNames().
std::unique_ptr<Integrator> makeMethod(const std::string& name, SeriesSystem& f, double step,
                                       const Tolerance& tolerance);

}  // namespace planar_chain::ode
