#include "ode/methods.h"

#include <stdexcept>
#include <utility>

#include "ode/explicit_runge_kutta.h"
#include "ode/local_stiffness.h"
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

bool isExplicit(const std::string& name) {
  return name == "rk4" || name == "dopri5" || name == "dop853" || name == "taylor";
}

std::unique_ptr<Stepper> makeStepper(const std::string& name, SeriesSystem& f, const Tolerance& tolerance,
                                     const std::shared_ptr<LocalStiffness>& stiffness) {
  if (name == "radau13") return std::make_unique<Radau>(f, tolerance, stiffness);
  if (name == "taylor") return std::make_unique<Taylor>(f, tolerance.value);
  for (const Tableau* table : {&rk4(), &dopri5(), &dop853()}) {
    if (name == table->name) return std::make_unique<ExplicitRungeKutta>(*table, f);
  }
  static const RosenbrockTableau fixed = [] {
    RosenbrockTableau table = ros34pw2();
    table.name = "ros34pw2_fixed";
    return table;
  }();
  for (const RosenbrockTableau* table : {&rodas5p(), &ros34pw2(), &fixed}) {
    if (name == table->name) return std::make_unique<Rosenbrock>(*table, f);
  }
  throw std::invalid_argument("no method is called " + name);
}

std::unique_ptr<Integrator> makeMethod(const std::string& name, SeriesSystem& f, double step,
                                       const Tolerance& inOrder) {
  const Tolerance tolerance = inOrder.inLaneOrder(f);
  const auto stiffness = std::make_shared<LocalStiffness>(f, tolerance.works);
  if (name != "auto") {
    auto stepper = makeStepper(name, f, tolerance, stiffness);
    if (hasFixedStep(name)) return fixedSteps(std::move(stepper), step);
    return adaptiveSteps(std::move(stepper), tolerance, stiffness);
  }

  // auto starts with the first explicit method. taylor is faster than dop853 if the tolerance is fine and the
  // chain short, and for one or two links without dampers or loads. A wrong bound costs a run its first
  // steps: trials then find the faster one.
  constexpr int twoLinks = 4;     // components
  constexpr int shortChain = 20;  // positions
  constexpr double veryFine = 1e-6;
  const bool isTiny = f.freedoms() <= twoLinks;
  const bool beginsWithSeries = isTiny || (tolerance.value <= veryFine && f.positions() <= shortChain);
  std::vector<const char*> names{"rodas5p", "radau13", "dop853"};
  if (f.seriesAreWorthwhile() && (isTiny || tolerance.isFine())) {
    names.insert(names.end() - (beginsWithSeries ? 1 : 0), "taylor");
  }
  if (f.jumpsOften()) names.push_back("dopri5");
  std::vector<std::unique_ptr<Stepper>> steppers;
  for (const char* each : names) steppers.push_back(makeStepper(each, f, tolerance, stiffness));
  return fastestSteps(std::move(steppers), tolerance, stiffness, f.jumpsOften());
}

}  // namespace planar_chain::ode
