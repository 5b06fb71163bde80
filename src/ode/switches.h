#pragma once

/// Switches: f is smooth between them, and no step may pass one.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// About the time after which a switch is due, and how fast due() grows there, 1/s. A slope of 0: unknown.
struct Crossing {
  double after = 0, slope = 0;
};

/// The states are not arranged.
class Switches {
 public:
  virtual ~Switches() = default;
  /// Positive if a switch is due, else ≤ 0. Continuous along a motion.
  virtual double due(double t, const Eigen::VectorXd& y) const = 0;
  /// For a step of h from y at t to next, with no switch due at either end: the time after which one may
  /// first be due between them. Negative if none can be.
  virtual double nearest(double t, const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const = 0;
  /// True if due() may rise above 0 and fall again within a long step, so that nearest() does not see it.
  virtual bool mayHide() const { return false; }
  /// For a step of h from y at t, where no switch is due, to next, where one is: a guess of the first time.
  /// An integrator keeps its step size after a switch with a guess: it changes f little.
  virtual Crossing crossing(double /*t*/, const Eigen::VectorXd& /*y*/, const Eigen::VectorXd& /*next*/,
                            double /*h*/) const {
    return {};
  }
};

/// Steps as the given integrator does, and ends a step just behind every switch. Then advance() returns
/// `switched`, and the owner of the switches changes f and calls restart(). A step within which a switch may
/// be due is cut into pieces until one is due or none can be. The time is found by steps of the same method
/// from the same state, to the spacing of the numbers at the end of the step, or at its length. With a guess,
/// one such step ends so close to the switch that y + δ f leads there. Without, the bracket is narrowed by
/// the Illinois rule (M. Dowell, P. Jarratt, BIT 11 (1971) 168–174). Steps are at most twice as long as the
/// usual time between switches with a guess. Allocates here alone.
std::unique_ptr<Integrator> landingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches,
                                              System& f);

}  // namespace planar_chain::ode
