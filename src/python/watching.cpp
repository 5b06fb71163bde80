#include "python/watching.h"

#include <algorithm>
#include <string>

namespace planar_chain::python {

namespace {

Numbers copyOf(const std::vector<double>& values) {
  return Numbers(static_cast<py::ssize_t>(values.size()), values.data());
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

}  // namespace planar_chain::python
