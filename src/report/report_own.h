#pragma once

/// This program's methods as contestants: each as a scene may name it, without the guard on the energy
/// balance, which would rescue what fails.

#include "dynamics/dynamics.h"
#include "ode/integrator.h"
#include "report/report_contest.h"

namespace planar_chain::tools {

std::vector<Contestant> ownContestants();

/// A scene under one of the program's methods.
class OwnRun : public Run {
 public:
  using Make = std::function<std::unique_ptr<ode::Integrator>(Dynamics&)>;
  /// The scene must outlive the run.
  OwnRun(const Scene& scene, double end, const Make& make);

  Progress step() override;
  Counts counts() const override;
  void read(double* theta, double* omega) const override;
  double time() const { return state_.t; }  ///< s

 private:
  double end_;
  int n_;
  Dynamics dynamics_;
  std::unique_ptr<ode::Integrator> integrator_;
  ode::State state_;
};

/// method: one of methodNames(); setting: its tolerance, or its step.
OwnRun::Make methodFor(const std::string& method, double setting);

}  // namespace planar_chain::tools
