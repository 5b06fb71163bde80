#include "planar_chain/ode/methods.h"

#include <stdexcept>

#include "planar_chain/ode/explicit_runge_kutta.h"

namespace planar_chain::ode {

const std::vector<std::string>& methodNames() {
  static const std::vector<std::string> names{"auto", "rk4", "dopri5"};
  return names;
}

Method makeMethod(const std::string& name, int size, double step, const Tolerance& tolerance) {
  if (name == "rk4") return {"rk4", fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), size), step)};
  if (name == "dopri5" || name == "auto") {
    return {"dopri5", adaptiveSteps(std::make_unique<ExplicitRungeKutta>(dopri5(), size), tolerance)};
  }
  throw std::invalid_argument("no method is called " + name);
}

}  // namespace planar_chain::ode
