#pragma once

/// This program's methods as contestants, without the guard on the energy balance, which would rescue a run
/// that fails.

#include "dynamics/dynamics.h"
#include "ode/explicit_runge_kutta.h"
#include "ode/integrator.h"
#include "report/contest.h"
#include "tools/common.h"

namespace planar_chain::tools {

/// A method with equal steps.
struct Method {
  const char* name;
  const ode::Tableau* table;  ///< of an explicit method
  /// stagesTo: the tolerance to which radau13 solves its stages. taylor has order 20.
  std::function<std::unique_ptr<ode::Stepper>(Dynamics&, double stagesTo)> stepper;
};
const std::vector<Method>& measuredMethods();

using MakeIntegrator = std::function<std::unique_ptr<ode::Integrator>(Dynamics&)>;
MakeIntegrator equalSteps(const Method& method, double h, double stagesTo = 1e-6);
/// method: one of methodNames(); setting: its tolerance, or its step.
MakeIntegrator methodFor(const std::string& method, double setting);

/// θ and ω of a scene's start, absolute, n each.
void readStart(const Scene& scene, double* theta, double* omega);

/// A scene under a method.
class OwnRun : public Run {
 public:
  /// The scene must outlive the run.
  OwnRun(const Scene& scene, double end, const MakeIntegrator& make);

  Progress step() override;
  Counts counts() const override;
  void read(double* theta, double* omega) const override;
  double time() const { return state_.t; }  ///< s
  /// So many steps, or those to the end or a failure.
  Progress steps(int most);
  /// T + V, less the V of hanging straight down at rest, J.
  double energyOfMotion() const;

 private:
  const Chain& chain_;
  double end_;
  Dynamics dynamics_;
  std::unique_ptr<ode::Integrator> integrator_;
  ode::State state_;
};

/// Each method as a scene may name it.
std::vector<Contestant> ownContestants();
/// Each of measuredMethods().
std::vector<Contestant> ownEqualSteps();

}  // namespace planar_chain::tools
