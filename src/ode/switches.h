#pragma once

/// What f switches on: it is smooth between switches, and no step may pass one.

#include <memory>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// Of states that are not arranged.
class Switches {
 public:
  virtual ~Switches() = default;
  /// > 0 where a switch is due, ≤ 0 before; continuous along a motion.
  virtual double due(const Eigen::VectorXd& y) const = 0;
  /// For a step of h from y to next, or a piece of one: after what time a switch may first be due that is due
  /// at neither end, or a negative number if that cannot be.
  virtual double nearest(const Eigen::VectorXd& y, const Eigen::VectorXd& next, double h) const = 0;
};

/// Steps as the given integrator does, and lands just behind every switch: advance() then says `switched`,
/// and whoever owns the switches changes f and restarts. Where a switch may be due within a step, that is cut
/// into pieces until it is, or cannot be. The time is found by steps of the same method from the same state,
/// bracketed and by the Illinois rule (M. Dowell, P. Jarratt, BIT 11 (1971) 168–174), down to the spacing of
/// the numbers at the end of the step, or at its length.
std::unique_ptr<Integrator> landingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches,
                                              const System& f);

}  // namespace planar_chain::ode
