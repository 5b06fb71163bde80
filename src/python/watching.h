#pragma once

/// Events from Python: functions event(t, q, qd) with the attributes terminal and direction, as
/// scipy.integrate.solve_ivp() takes them.

#include <vector>

#include "planar_chain/events.h"
#include "python/running.h"

namespace planar_chain::python {

/// The functions of an argument `events`, and what was found with them. Only a thread of Python may make,
/// copy or destroy it.
class Watching {
 public:
  /// given: a function, or a sequence of them.
  /// @throws Refused for anything else
  explicit Watching(const py::object& given);

  /// As Running::advanceTo(). Appends to what was found.
  /// @returns true at a terminal event
  bool advanceTo(Running& running, double t, const StepBudget& budget, const char* cure = "");
  /// The number of the terminal event at which the last way ended, or None.
  py::object terminal() const;
  /// For each event an array of times; for each an array of states, times × 2n.
  py::list times() const;
  py::list states(std::size_t size) const;

 private:
  std::vector<MotionEvent> events_;
  FoundEvents found_;
};

}  // namespace planar_chain::python
