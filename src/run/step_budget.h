#pragma once

/// A limit on the steps of a run, for callers that would otherwise wait without end: a torque of 1e12 N m on
/// a rod of 1 kg needs billions of steps in a few milliseconds.

#include <functional>
#include <optional>
#include <string>

#include "planar_chain/simulation.h"

namespace planar_chain {

class StepBudget {
 public:
  /// The usual limit for `span` s of simulated time: a million steps for each second, and at least a million;
  /// for a method of fixed step, besides the steps that its user has chosen.
  static long long usual(const IntegratorSettings& settings, double span);

  /// Counts the steps of the simulation, accepted and rejected, from now on. It must outlive this object.
  /// most: > 0; absent: the usual limit for the time that has passed since now. So a run that needs more ends
  /// soon, however far away its `end`, s, is.
  StepBudget(Simulation& simulation, double end, std::optional<long long> most);

  /// True while Simulation::advanceTo() may continue.
  bool isLeft() const { return made() < most(); }

  /// Returns why the run stops: the steps, the time, the fastest joint, the largest torque in a joint, and
  /// stiffestParameter(). It evaluates the dynamics. Allocates.
  std::string reason() const;

 private:
  long long made() const;
  long long most() const;

  Simulation& simulation_;
  double begin_, end_;
  std::optional<long long> most_;
  long long before_;  ///< steps made at the beginning
};

}  // namespace planar_chain
