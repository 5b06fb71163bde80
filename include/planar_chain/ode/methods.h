#pragma once

/// The methods by name: what a scene's integrator/method may say.

#include <memory>
#include <string>
#include <vector>

#include "planar_chain/ode/integrator.h"

namespace planar_chain::ode {

/// "auto" first, then every method of the program.
const std::vector<std::string>& methodNames();

struct Method {
  std::string name;  ///< what runs: never "auto"
  std::unique_ptr<Integrator> integrator;
};

/// For system f, which must outlive the method. step: for methods of fixed step, s. tolerance: for adaptive
/// ones. "auto" is dopri5 here.
/// @throws std::invalid_argument for a name that is not one of methodNames().
Method makeMethod(const std::string& name, LinearizedSystem& f, double step, const Tolerance& tolerance);

}  // namespace planar_chain::ode
