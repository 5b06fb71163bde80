#pragma once

/// This program's methods as contestants, without the guard on the energy balance, which would rescue a run
/// that fails.

#include "dynamics/dynamics.h"
#include "ode/integrator.h"
#include "report/contest.h"
#include "tools/common.h"

namespace planar_chain::tools {

/// The methods that are measured with equal steps: all that step in a way of their own.
std::vector<std::string> steppedMethods();

using MakeIntegrator = std::function<std::unique_ptr<ode::Integrator>(const Scene&, Dynamics&)>;
/// stagesTo: the tolerance to which radau13 solves its stages. taylor has order 20.
MakeIntegrator equalSteps(const std::string& method, double h, double stagesTo = 1e-6);
/// method: one of methodNames(); setting: its tolerance, or its step.
MakeIntegrator methodFor(const std::string& method, double setting);

/// θ and ω of a scene's start, absolute, n each; of slides positions and their rates.
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
  /// T + V, less the V of hanging straight down at rest, J.
  double energyOfMotion() const;

 private:
  const Chain& chain_;
  double end_;
  Dynamics dynamics_;
  std::unique_ptr<ode::Integrator> integrator_;
  ode::State state_;
};

/// Each method as a scene may name it; or each of steppedMethods().
std::vector<Contestant> ownContestants(bool withEqualSteps);

}  // namespace planar_chain::tools
