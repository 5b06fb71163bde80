#include "planar_chain/ode/methods.h"

#include <stdexcept>

#include "planar_chain/ode/explicit_runge_kutta.h"
#include "planar_chain/ode/rosenbrock.h"

namespace planar_chain::ode {

const std::vector<std::string>& methodNames() {
  static const std::vector<std::string> names{"auto", "rk4", "dopri5", "dop853", "rodas5p", "ros34pw2"};
  return names;
}

Method makeMethod(const std::string& name, LinearizedSystem& f, double step, const Tolerance& tolerance) {
  if (name == "rk4") return {"rk4", fixedSteps(std::make_unique<ExplicitRungeKutta>(rk4(), f), step)};
  if (name == "dopri5" || name == "auto") {
    return {"dopri5", adaptiveSteps(std::make_unique<ExplicitRungeKutta>(dopri5(), f), tolerance)};
  }
  if (name == "dop853") {
    return {"dop853", adaptiveSteps(std::make_unique<ExplicitRungeKutta>(dop853(), f), tolerance)};
  }
  if (name == "rodas5p") {
    return {"rodas5p", adaptiveSteps(std::make_unique<Rosenbrock>(rodas5p(), f), tolerance)};
  }
  if (name == "ros34pw2") {
    return {"ros34pw2", adaptiveSteps(std::make_unique<Rosenbrock>(ros34pw2(), f), tolerance)};
  }
  throw std::invalid_argument("no method is called " + name);
}

}  // namespace planar_chain::ode
