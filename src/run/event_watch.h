#pragma once

/// The events that a caller wants to know (planar_chain/events.h), along the steps of a simulation.

#include <functional>
#include <memory>
#include <vector>

#include "ode/watched_steps.h"
#include "planar_chain/events.h"

namespace planar_chain {

/// Allocates.
class EventWatch {
 public:
  /// Writes the relative angles and rates of a state in chain order.
  using ToRelative =
      std::function<void(double t, const double* y, std::vector<double>& q, std::vector<double>& qd)>;

  /// near: of each event, the size of g up to which it is 0 at the start; none: 0. goesOn: `found` is from
  /// here, with these events. All but toRelative must outlive this object.
  /// @throws Refused for an event without a function, or with a negative number
  EventWatch(const std::vector<MotionEvent>& events, FoundEvents& found, bool goesOn,
             const std::vector<double>& near, ode::SeriesSystem& f, int n, const ToRelative& toRelative);
  ~EventWatch();

  /// These steps, watched.
  ode::Integrator& over(ode::Integrator& steps) {
    steps_->use(steps);
    return *steps_;
  }
  bool isOver() const { return steps_->isOver(); }
  /// Takes what was found in the last steps. Call it before turns are taken off the state.
  void take();
  void goBack(double t);
  /// Writes what was found, and `near` for a start at t, where the way ends.
  /// @throws what a function has thrown
  void end(double t, std::vector<double>& near);

 private:
  class Function;
  FoundEvents& found_;
  const std::size_t before_;  ///< found before
  ToRelative toRelative_;
  std::size_t n_;
  std::vector<std::unique_ptr<Function>> functions_;
  std::unique_ptr<ode::WatchedSteps> steps_;
};

}  // namespace planar_chain
