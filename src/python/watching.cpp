#include "python/watching.h"

#include <algorithm>
#include <string>

namespace planar_chain::python {

namespace {

py::object listOf(const py::object& list) {
  return list ? list : py::list();
}

MotionEvent eventOf(const py::object& function, const std::string& path) {
  if (PyCallable_Check(function.ptr()) == 0)
    throw Refused({{path, "a function of t, q and qd", shown(function)}});
  MotionEvent event;
  event.g = [function, path](double t, const std::vector<double>& q, const std::vector<double>& qd) {
    const py::gil_scoped_acquire gil;
    return numberOf(function(t, copyOf(q), copyOf(qd)), path.c_str());
  };
  const py::object terminal = py::getattr(function, "terminal", py::bool_(false)),
                   direction = py::getattr(function, "direction", py::int_(0));
  const std::string ofTerminal = path + ".terminal", ofDirection = path + ".direction";
  event.terminal = terminal.is_none() ? 0
                   : isBool(terminal) ? PyObject_IsTrue(terminal.ptr())
                                      : countOf(terminal, ofTerminal.c_str(), 0, 1'000'000'000'000'000);
  const double side = numberOf(direction, ofDirection.c_str());
  event.direction = side > 0 ? 1 : side < 0 ? -1 : 0;
  return event;
}

}  // namespace

Watching::Watching(const py::object& given) {
  if (PyCallable_Check(given.ptr()) != 0) {
    events_.push_back(eventOf(given, "events"));
    return;
  }
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given))
    throw Refused({{"events", "a function of t, q and qd, or a list of them", shown(given)}});
  for (const py::handle& one : given)
    events_.push_back(
        eventOf(py::reinterpret_borrow<py::object>(one), "events/" + std::to_string(events_.size())));
}

bool Watching::advanceTo(Running& running, double t, const StepBudget& budget, const char* cure) {
  running.advance([&](Simulation& simulation,
                      const auto& keepGoing) { return simulation.advanceTo(t, events_, found_, keepGoing); },
                  budget, cure);
  return found_.terminal.has_value();
}

py::object Watching::terminal() const {
  return found_.terminal ? py::object(py::int_(*found_.terminal)) : py::object(py::none());
}

py::list Watching::times() const {
  py::list all;
  for (std::size_t i = 0; i < events_.size(); ++i) {
    std::vector<double> times;
    for (const FoundEvent& one : found_.all) {
      if (one.which == i) times.push_back(one.t);
    }
    all.append(copyOf(times));
  }
  return all;
}

py::list Watching::states(std::size_t size) const {
  py::list all;
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const auto isOf = [i](const FoundEvent& one) { return one.which == i; };
    const auto count = std::count_if(found_.all.begin(), found_.all.end(), isOf);
    Numbers states({static_cast<py::ssize_t>(count), static_cast<py::ssize_t>(size)});
    double* to = states.mutable_data();
    for (const FoundEvent& one : found_.all) {
      if (isOf(one)) to = std::copy(one.qd.begin(), one.qd.end(), std::copy(one.q.begin(), one.q.end(), to));
    }
    all.append(states);
  }
  return all;
}

void bindAdvance(py::class_<Running>& simulation) {
  simulation
      .def(
          "advance_to",
          [](Running& self, const py::object& t, const py::object& mostSteps,
             const py::object& events) -> py::object {
            constexpr const char* cure = "; set_state(), settle(), reset() or clear_commands() lets it go on";
            const double end = numberOf(t, "t");
            const StepBudget budget = self.budget(end, stepsOf(mostSteps));
            if (events.is_none()) {
              self.advanceTo(end, budget, cure);
              return py::none();
            }
            Watching watching(events);
            watching.advanceTo(self, end, budget, cure);
            self.timesOfEvents = watching.times();
            self.statesOfEvents = watching.states(2 * self.size());
            return watching.terminal();
          },
          py::arg("t"), py::arg("most_steps") = py::none(), py::arg("events") = py::none(),
          R"(Integrates to time t (s, not before `time`). Other threads run meanwhile; Ctrl-C interrupts.

events: a function g(t, q, qd), or a list of them, with the attributes terminal (default False; a number: at that zero)
and direction (default 0; > 0: where g rises; < 0: where it falls), as scipy.integrate.solve_ivp() takes them. It ends
at the first zero of a terminal event and returns the event's number; at t, it returns None. t_events and y_events have
all zeros. One where it starts does not count, so the next call goes on.

Raises Failed when the integration fails, or after most_steps steps: by default a million for each second so far,
and at least a million. The state is then that of the last good step.)")
      .def_property_readonly(
          "t_events", [](const Running& self) { return listOf(self.timesOfEvents); },
          "Of the last advance_to() with events: for each an array of times, s.")
      .def_property_readonly(
          "y_events", [](const Running& self) { return listOf(self.statesOfEvents); },
          "Of the last advance_to() with events: for each an array of states, times × 2n.");
}

}  // namespace planar_chain::python
