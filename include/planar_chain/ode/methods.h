#pragma once

/// The methods by name: what a scene's integrator/method may say.

#include <string>
#include <vector>

namespace planar_chain::ode {

/// "auto" first, then every method of the program.
const std::vector<std::string>& methodNames();

}  // namespace planar_chain::ode
