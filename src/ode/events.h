#pragma once

/// Events: f is smooth between them, and a step ends at each.
///
/// An event has a function g(t, y), which is continuous along a motion while none is fired:
///
///     g ≤ 0    it has not happened: the present f is right
///     g > 0    it has happened: f must change from here on
///
/// It happens at the first time t* after which g is above 0, so it belongs to the interval that it begins: a
/// step covers (t_0, t_1] with the f of before. At t_0 no event has happened. Firing restores this: after it,
/// g ≤ 0 everywhere. This is checked where a step starts after a change, at a state at which the step needs f
/// anyway: if an event has happened there, advance() returns `switched` at once, and no step is made. If
/// events follow each other and time does not pass, it gives up with `endless`.
///
/// The order of calls for one step:
///
///     1. the integrator makes a step with one f
///     2. values() at its end; then values(), slopes() and noise() at states within it, until each function
///        is known to stay at or below its noise, or the first one to rise above 0 is found (event_search.h)
///     3. the state is set to that of the event, and advance() returns `switched`
///     4. the owner of the events gives the LocatedEvent, a value, to its fire(), which changes f and perhaps
///        y
///     5. the owner calls Integrator::restartAfter()
///
/// Step 2 changes nothing: the functions may be called for any states, in any order and number, and the
/// motion is the same bit for bit.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "ode/integrator.h"

namespace planar_chain::ode {

/// Some event functions g_0 … g_{count−1}. States are in chain order: [θ ω …].
class EventFunctions {
 public:
  virtual ~EventFunctions() = default;
  /// The largest count() ever.
  virtual int most() const = 0;
  /// Changes only when f does.
  virtual int count() const { return most(); }
  /// Writes all g. One that is far below 0 cannot happen at present.
  virtual void values(double t, const double* y, double* g) const = 0;
  /// Writes what rounding may add to each g, > 0. A function that rises above 0 by less than this between the
  /// ends of a step, and falls again, may be missed. Where an event is located, g may be above 0 by this.
  virtual void noise(double t, const double* y, double* of) const = 0;
  /// True if slopes() gives dg/dt along the motion, with the accelerations q̈. Otherwise slopes are those of
  /// the parabola through three values.
  virtual bool haveSlopes() const { return false; }
  virtual void slopes(double /*t*/, const double* /*y*/, const double* /*accelerations*/,
                      double* /*slope*/) const {}
  /// True if f is stiffer or less stiff behind an event.
  virtual bool changeStiffness() const { return false; }
};

/// The g of a function that cannot happen at present.
constexpr double never = -1e300;

/// The value that goes from step 2 to step 4.
struct LocatedEvent {
  double t = 0;
  const EventFunctions* by = nullptr;  ///< nullptr: it was found where a step starts
  int which = -1;                      ///< the number of the function
  double slope = 0;                    ///< dg/dt
};

using EventList = std::vector<const EventFunctions*>;

/// Steps as the given integrator does, and ends a step just behind every event. Then advance() returns
/// `switched`.
///
/// The state there is taken from the dense output of the step, if the tolerance allows the error of that. If
/// not, a step is made that ends close behind, where its dense output is more exact. If f has no dense
/// output, or its steps cost little, the time is found by steps of the same method from the same state. Steps
/// are at most thrice as long as the usual time between events.
/// The time is refined by Newton's method, on the polynomial through the values of g that are known, and by
/// halves where that fails. Allocates here alone.
std::unique_ptr<Integrator> stepsToEvents(std::unique_ptr<Integrator> steps, const EventList& events,
                                          SeriesSystem& f);

}  // namespace planar_chain::ode
