#include "run/step_budget.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "ode/methods.h"
#include "run/stiffest_parameter.h"

namespace planar_chain {

namespace {

long long stepsOf(const Simulation& simulation) {
  const Statistics statistics = simulation.statistics();
  return statistics.steps + statistics.rejected;
}

/// The index of the number of largest magnitude.
std::size_t largest(const std::vector<double>& values) {
  const auto isLess = [](double a, double b) { return std::abs(a) < std::abs(b); };
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end(), isLess) - values.begin());
}

}  // namespace

long long StepBudget::usual(const IntegratorSettings& settings, double span) {
  constexpr double perSecond = 1e6, most = 1e18;
  const double chosen = ode::hasFixedStep(settings.method) ? span / settings.step : 0;
  return static_cast<long long>(std::min(chosen + perSecond * std::max(span, 1.0), most));
}

StepBudget::StepBudget(Simulation& simulation, double end, std::optional<long long> most)
    : simulation_(simulation),
      begin_(simulation.time()),
      end_(end),
      most_(most),
      before_(stepsOf(simulation)) {}

long long StepBudget::made() const {
  return stepsOf(simulation_) - before_;
}

long long StepBudget::most() const {
  return most_ ? *most_ : usual(simulation_.scene().integrator, simulation_.time() - begin_);
}

std::string StepBudget::reason() const {
  const std::vector<Joint>& joints = simulation_.scene().chain.joints();
  const std::vector<double>& qd = simulation_.qd();
  std::vector<double> tau(qd.size());
  simulation_.jointTorques(tau.data());
  const std::size_t fastest = largest(qd), strongest = largest(tau);
  char text[200];
  std::snprintf(text, sizeof text, "stopped at t = %.9g s of %.9g s after %lld steps: the rate of ",
                simulation_.time(), end_, made());
  std::string why = text + joints[fastest].name;
  std::snprintf(text, sizeof text, " is %.3g %s, the %s in ", qd[fastest],
                joints[fastest].isPrismatic ? "m/s" : "rad/s",
                joints[strongest].isPrismatic ? "force" : "torque");
  why += text + joints[strongest].name;
  std::snprintf(text, sizeof text, " %.3g %s; ", tau[strongest], joints[strongest].isPrismatic ? "N" : "N m");
  why += text;
  const double step = (simulation_.time() - begin_) / static_cast<double>(std::max(made(), 1LL));
  why += stiffestParameter(simulation_.scene(), simulation_.time(), step);
  constexpr double fine = 1e-10;
  if (simulation_.tolerance() > 0 && simulation_.tolerance() < fine) {
    std::snprintf(text, sizeof text, "the tolerance is %.3g, and below 1e-10 rounding may exceed it; ",
                  simulation_.tolerance());
    why += text;
  }
  return why + "expected at most " + std::to_string(most()) + " steps";
}

}  // namespace planar_chain
