#include "ode/methods.h"

#include <stdexcept>
#include <utility>

#include "ode/adaptive_steps.h"
#include "ode/explicit_runge_kutta.h"
#include "ode/radau.h"
#include "ode/rosenbrock.h"
#include "ode/taylor.h"

namespace planar_chain::ode {

const std::vector<std::string>& methodNames() {
  static const std::vector<std::string> names{"auto",    "rk4",    "dopri5",   "dop853",        "rodas5p",
                                              "radau13", "taylor", "ros34pw2", "ros34pw2_fixed"};
  return names;
}

bool hasFixedStep(const std::string& name) {
  return name == "rk4" || name == "ros34pw2_fixed";
}

std::unique_ptr<Integrator> makeMethod(const std::string& name, SeriesSystem& f, double step,
                                       const Tolerance& inOrder) {
  const Tolerance tolerance = inOrder.arrangedBy(f);
  const auto explicitBy = [&](const Tableau& table) {
    return std::make_unique<ExplicitRungeKutta>(table, f);
  };
  const auto implicitBy = [&](const RosenbrockTableau& table) {
    return std::make_unique<Rosenbrock>(table, f);
  };
  if (name == "auto") {
    auto stiffness = std::make_shared<LocalStiffness>(f);
    std::vector<std::unique_ptr<Stepper>> steppers;
    steppers.push_back(implicitBy(rodas5p()));
    steppers.push_back(std::make_unique<Radau>(f, tolerance, stiffness));
    const auto addSeries = [&] {
      if (f.seriesAreWorthwhile()) steppers.push_back(std::make_unique<Taylor>(f, tolerance.value));
    };
    // auto starts with the first explicit method: taylor if the tolerance is fine.
    constexpr double fine = 1e-5;
    if (tolerance.value <= fine) addSeries();
    steppers.push_back(explicitBy(dop853()));
    if (tolerance.value > fine) addSeries();
    return fastestSteps(std::move(steppers), tolerance, std::move(stiffness));
  }
  if (name == "rk4") return fixedSteps(explicitBy(rk4()), step);
  if (name == "dopri5") return adaptiveSteps(explicitBy(dopri5()), tolerance);
  if (name == "dop853") return adaptiveSteps(explicitBy(dop853()), tolerance);
  if (name == "rodas5p") return adaptiveSteps(implicitBy(rodas5p()), tolerance);
  if (name == "ros34pw2") return adaptiveSteps(implicitBy(ros34pw2()), tolerance);
  if (name == "ros34pw2_fixed") {
    RosenbrockTableau table = ros34pw2();
    table.name = "ros34pw2_fixed";
    return fixedSteps(implicitBy(table), step);
  }
  if (name == "taylor") return adaptiveSteps(std::make_unique<Taylor>(f, tolerance.value), tolerance);
  if (name == "radau13") {
    auto stiffness = std::make_shared<LocalStiffness>(f);
    return std::make_unique<AdaptiveSteps>(std::make_unique<Radau>(f, tolerance, stiffness), tolerance,
                                           stiffness);
  }
  throw std::invalid_argument("no method is called " + name);
}

}  // namespace planar_chain::ode
