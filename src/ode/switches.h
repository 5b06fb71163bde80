#pragma once

/// Switches: f is smooth between them, and a step ends at each.
///
/// A switch has a function due(t, y), which is continuous along a motion while nothing is switched:
///
///     due ≤ 0    the switch is not due: the present f is right
///     due > 0    it is due: f must change from here on
///
/// It happens at the first time t* after which due() is positive, so it belongs to the interval that it
/// begins: a step covers (t_0, t_1] with the f of before, and has switched if due() > 0 at t_1 or at a place
/// within that nearest() finds. At t_0 no switch is due. change() restores this: after it, due() ≤ 0
/// everywhere. This is checked where a step starts after a change, at a state at which the step needs f
/// anyway: if a switch is due, advance() returns `switched` at once, and no step is made. If switches follow
/// each other and time does not pass, it gives up with `endless`.
///
/// The order of calls for one step:
///
///     1. the integrator makes a step, or several pieces of it, with one f
///     2. due() at their ends; hidden() on the whole, if it is one piece; nearest() on each stretch on whose
///        ends none is due
///     3. crossing() on the first stretch at whose end one is due. The step ends there, and advance() returns
///        `switched`
///     4. the owner of the switches gives the Crossing, a value, to change(), which changes f and perhaps y
///     5. the owner calls Integrator::restartAfter()
///
/// Steps 2 and 3 change nothing: they may be called for any states, in any order and number, and the motion
/// is the same bit for bit. They return values, or references that are valid until the next call of the same
/// object. A Stretch and its pointers are valid during the call only.

#include <memory>
#include <optional>

#include "ode/course.h"
#include "ode/integrator.h"

namespace planar_chain::ode {

/// A part of a step, from y at t to `next` at t + h. No switch is due at its start.
struct Stretch {
  double t, h;
  const Eigen::VectorXd &y, &next;
  const Course* course = nullptr;  ///< the states of the whole step, if they are known
};

class Switches;

/// A switch that was found: a value that is passed from crossing() to change().
struct Crossing {
  double t = 0;
  const Switches* by = nullptr;   ///< the object that found it
  int which = -1;                 ///< its component, counted by that object; −1: unknown
  double slope = 0;               ///< the derivative of its due()
  bool changesStiffness = false;  ///< true if f is stiffer or less stiff behind it
};

/// The states are not arranged.
class Switches {
 public:
  virtual ~Switches() = default;
  /// Positive if a switch is due, else ≤ 0. Continuous along a motion.
  virtual double due(double t, const Eigen::VectorXd& y) const = 0;
  /// The time after which a switch may first be due before the end. Negative if none can be.
  virtual double nearest(const Stretch& of) const = 0;
  /// True if due() may rise above 0 and fall again within the step, so that nearest() does not see it.
  /// isLong: it is a polynomial of high order, and free to look at.
  virtual bool mayHide(const Stretch& /*of*/, bool /*isLong*/) const { return false; }
  /// Of a whole step whose course is known: the time after which there is a place where due() may be above 0,
  /// by the course and its error, although it is not at both ends. Negative if there is none.
  virtual double hidden(const Stretch& /*step*/) const { return -1; }
  /// The first time at which a switch is due, for a stretch at whose end one is. Nothing: unknown, or f
  /// changes so much there that the step size no longer suits.
  virtual std::optional<Crossing> crossing(const Stretch& /*of*/) const { return {}; }
};

/// Steps as the given integrator does, and ends a step just behind every switch. Then advance() returns
/// `switched`, and the owner of the switches changes f and calls restart(). A step within which a switch may
/// be due is cut into pieces until one is due or none can be.
///
/// If the switches give the time, the state there is taken from the course of the step, if the tolerance
/// allows the error of that. If not, a step is made that ends close behind, where its course is more exact.
/// Steps are at most thrice as long as the usual time between bends. If the switches do not give the
/// time, it is found by steps of the same method from the same state, to the spacing of the numbers at the
/// end of the step, or at its length. The bracket is narrowed by inverse interpolation and bisection
/// (T. Chandrupatla, Advances in Engineering Software 28 (1997) 145–149). Allocates here alone.
std::unique_ptr<Integrator> landingOnSwitches(std::unique_ptr<Integrator> steps, const Switches& switches,
                                              SeriesSystem& f);

}  // namespace planar_chain::ode
