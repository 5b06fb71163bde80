#pragma once

/// Switches: f is smooth between them, and no step may pass one.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// The states are not arranged.
class Switches {
 public:
  virtual ~Switches() = default;
  /// Positive if a switch is due, else ≤ 0. Continuous along a motion.
  virtual double due(double t, const Eigen::VectorXd& y) const = 0;
  /// For a step of h from y at t to next, with no switch due at either end: the time after which one may
  /// first be due between them. Negative if none can be.
  virtual double nearest(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const = 0;
};

/// Steps as the given integrator does, and ends a step just behind every switch. Then advance() returns
/// `switched`, and the owner of the switches changes f and calls restart(). A step within which a switch may
/// be due is cut into pieces until one is due or none can be. The time is found by steps of the same method
/// from the same state, with a bracket and the Illinois rule (M. Dowell, P. Jarratt, BIT 11 (1971) 168–174),
/// to the spacing of the numbers at the end of the step, or at its length. Allocates here alone.
std::unique_ptr<Integrator> landingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches,
                                              const System& f);

}  // namespace planar_chain::ode
